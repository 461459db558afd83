"""The JSON Schemas of what is written, made from the typed records."""

from __future__ import annotations

from typing import Any

from autobalance.correction import KINDS
from autobalance.declare.schema import schema_of
from autobalance.job.listed_cuts import LISTED
from autobalance.report.records.report import Report

Values = dict[str, Any]

REPORT_HEAD: Values = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "$id": "https://autobalance.invalid/report-1.schema.json",
    "title": "Report of autobalance, schema_version 1",
    "description": "Numbers are in the unit that a key ends with; positions and vectors in the rotor "
    "frame unless the key begins with file_; angles counter-clockwise seen from +z.",
}
RULES: list[Values] = [
    {
        "if": {"properties": {"command": {"enum": ["balance", "recut"]}}},
        "then": {
            "properties": {
                "job": {"type": "object"},
                "engine": {"type": "object"},
                "balance_factor": {"type": "object"},
                "tolerance": {"type": "object"},
                "residual": {"type": "object"},
                "outcome": {"type": "string"},
                "inertia_change_kg_mm2": {"type": "number"},
                "outputs": {"required": ["solid"]},
            }
        },
        "else": {"required": ["faces"], "properties": {"job": {"type": "null"}}},
    },
    {
        "if": {"properties": {"outcome": {"const": "above_tolerance"}}},
        "then": {"properties": {"reason": {"type": "string"}}},
        "else": {"properties": {"reason": {"type": "null"}}},
    },
    {
        "if": {"properties": {"command": {"const": "recut"}}},
        "then": {
            "required": [
                "serial",
                "previous",
                "stages",
                "machine_reading",
                "earlier_corrections",
                "input_is_untouched",
            ]
        },
    },
]
"""Conditions that depend on the values: a balanced crank has a job, an unreached tolerance a reason."""


def written_schema() -> Values:
    """Return the JSON Schema (draft 2020-12) of reports, from the records.

    The kinds of correction in it are those that exist.
    """
    schema = schema_of(Report, REPORT_HEAD, RULES)
    method = schema["$defs"]["job_correction"]["properties"]["method"]
    method["items"]["enum"] = [*KINDS, LISTED]
    schema["$defs"]["correction"]["properties"]["kind"]["enum"] = list(KINDS)
    return schema
