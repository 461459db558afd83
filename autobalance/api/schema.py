"""``ab.schema``: the JSON Schema of a file that the program reads or writes, for editors and checks."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from autobalance.errors import UsageError

Values = dict[str, Any]

WRITTEN: Mapping[str, str] = {
    "cycle": "cycle.CycleReport",
    "forces": "forces.ForcesReport",
    "grade": "grade.GradeReport",
    "parts": "forces.PartsReport",
    "shafts": "forces.ShaftsReport",
}
"""Name → module of ``report.records`` and record of what a verb writes with ``--json``."""
NAMES = (
    *("job", "reading", "trials", "machine", "report", "inspect", "recut", "influence", "machine-report"),
    *WRITTEN,
)
"""Files that have a schema: what is read first, then what is written."""
DRAFT = "https://json-schema.org/draft/2020-12/schema"

NUMBER, TEXT, FLAG = {"type": "number"}, {"type": "string"}, {"type": "boolean"}
PAIR = {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2}
TABLE = {"type": "object"}
NUMBER_OR_NULL = {"type": ["number", "null"]}


def schema(name: str) -> Values:
    """Return the JSON Schema (draft 2020-12) of a kind of file.

    Parameters
    ----------
    name : str
        One of ``NAMES``: TOML files as they are parsed, reports as JSON.

    Raises
    ------
    UsageError
        If there is none of that name.

    Examples
    --------
    >>> schema("trials")["required"]
    ['initial', 'trial']
    """
    if name not in NAMES:
        raise UsageError(f"schema {name!r} is not there; there are {', '.join(NAMES)}")
    if name == "job":
        return _job()
    if name in ("reading", "trials", "machine"):
        return _read(name)
    if name in WRITTEN:
        return _of_record(*WRITTEN[name].split("."))
    if name in ("report", "inspect", "recut"):
        return _report(name)
    return _written("influence", INFLUENCE) if name == "influence" else _written("machine", MACHINE)


def _read(name: str) -> Values:
    from autobalance.job.files.machine import MACHINE_KEYS
    from autobalance.job.files.reading import READING_KEYS
    from autobalance.job.files.trials import TRIALS_KEYS
    from autobalance.job.toml.keys import json_schema

    keys = {"reading": READING_KEYS, "trials": TRIALS_KEYS, "machine": MACHINE_KEYS}
    return json_schema(f"{name.upper()}.toml of autobalance", keys[name])


def _report(name: str) -> Values:
    from autobalance.report.balance.values import schema as report_schema

    whole = report_schema()
    if name == "report":
        return whole
    properties = {**whole["properties"], "command": {"const": name}}
    return {**whole, "title": f"Report of autobalance {name}", "properties": properties}


def _of_record(module: str, name: str) -> Values:
    from autobalance.report.records.schema import schema_of

    record = getattr(import_module(f"autobalance.report.records.{module}"), name)
    head = {"$schema": DRAFT, "title": f"Report of autobalance {record.command}"}
    return schema_of(record, head, [])


def _job() -> Values:
    from autobalance.job.tables import job_schema

    return job_schema()


def _listed(properties: Mapping[str, Any], nullable: bool = False) -> Values:
    item = {"type": "object", "properties": dict(properties), "required": list(properties)}
    return {"type": ["array", "null"] if nullable else "array", "items": item}


def _written(command: str, properties: Mapping[str, Any]) -> Values:
    head = {"schema_version": {"const": 1}, "autobalance": TABLE, "command": {"const": command}}
    every = {**head, **properties}
    return {
        "$schema": DRAFT,
        "title": f"Report of autobalance {command}",
        "type": "object",
        "properties": every,
        "required": list(every),
    }


READINGS = {"type": "array", "items": PAIR}
WARNINGS = {"type": "array", "items": TEXT}
PLANE = {"type": ["integer", "string"]}
INFLUENCE: Mapping[str, Any] = {
    "goal": {"enum": ["least_squares", "least_worst"]},
    "planes": {"type": "array", "items": PLANE},
    "influence": {"type": "array", "items": READINGS},
    "condition": {"type": "number", "minimum": 0},
    "corrections": _listed(
        {
            "plane": PLANE,
            "g_mm": NUMBER,
            "angle_deg": NUMBER,
            "remove_angle_deg": NUMBER,
            "g": NUMBER_OR_NULL,
            "radius_mm": NUMBER_OR_NULL,
            "split": _listed({"angle_deg": NUMBER, "g_mm": NUMBER}, nullable=True),
        }
    ),
    "add_to_left": _listed({"plane": PLANE, "g_mm": NUMBER, "angle_deg": NUMBER}, nullable=True),
    "initial": READINGS,
    "residual": {
        "type": "object",
        "properties": {"readings": READINGS, "worst": NUMBER, "rms": NUMBER},
        "required": ["readings", "worst", "rms"],
    },
    "outcome": {"enum": ["within_tolerance", "above_tolerance", None]},
    "reason": {"type": ["string", "null"]},
    "warnings": WARNINGS,
}
MACHINE: Mapping[str, Any] = {
    "rotor": {
        "type": "object",
        "properties": {
            "mass_g": NUMBER,
            "centre_of_mass_mm": {"type": "array", "items": NUMBER, "minItems": 3, "maxItems": 3},
            "unbalance_g_mm": PAIR,
            "moment_g_mm2": PAIR,
            "magnitude_g_mm": NUMBER,
            "planes": {"type": "array"},
            "kind": {"enum": ["balanced", "static", "couple", "quasi_static", "dynamic"]},
            "principal_axis_deg": NUMBER_OR_NULL,
        },
        "required": ["mass_g", "unbalance_g_mm", "moment_g_mm2", "planes", "kind", "principal_axis_deg"],
    },
    "sensors": _listed({"name": TEXT, "z_mm": NUMBER, "angle_deg": NUMBER}, nullable=True),
    "nodes": _listed({"plane": TEXT, "z_mm": NUMBER}, nullable=True),
    "static": {"type": ["object", "null"]},
    "runs": _listed(
        {
            "planes": _listed({"name": TEXT, "unbalance_g_mm": PAIR, "g_mm": NUMBER, "angle_deg": NUMBER}),
            "left": TABLE,
        }
    ),
    "corrections": _listed({"plane": TEXT, "g_mm": NUMBER, "angle_deg": NUMBER, "depth_mm": NUMBER_OR_NULL}),
    "noise": TABLE,
    "warnings": WARNINGS,
}
