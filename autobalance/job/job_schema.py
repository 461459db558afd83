"""The JSON Schema of a job as TOML is parsed: what it refuses, the program refuses."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, get_args

from autobalance.correction import KINDS
from autobalance.correction.contract import Prefer
from autobalance.job.read import TOP_KEYS
from autobalance.job.read_crankshaft import CRANKSHAFT_KEYS
from autobalance.job.toml.keys import DRAFT
from autobalance.job.toml.typed_units import WEIGHT_TABLES

Values = dict[str, Any]
POSITIVE: Values = {"type": "number", "exclusiveMinimum": 0}
SHARE: Values = {"type": "number", "minimum": 0, "maximum": 1}
LENGTH: Values = {"type": ["number", "string"]}


def job_schema() -> Values:
    """Return the JSON Schema of a job as TOML is parsed."""
    tables = {
        "crankshaft": _crankshaft(),
        "engine": _engine(),
        "balance": _balance(),
        "correction": _correction(),
    }
    others = {key: {"type": ["object", "array"]} for key in TOP_KEYS if key not in tables}
    return {
        "$schema": DRAFT,
        "title": "job",
        "type": "object",
        "properties": {**tables, **others},
        "required": ["crankshaft", "balance", "correction"],
        "additionalProperties": False,
    }


def _table(properties: Values, required: tuple[str, ...] = ()) -> Values:
    return {
        "type": "object",
        "properties": properties,
        "required": list(required),
        "additionalProperties": False,
    }


def _crankshaft() -> Values:
    pins = {
        "type": "array",
        "minItems": 1,
        "items": _table({"centre_mm": _vector(3), "diameter_mm": LENGTH, "width_mm": LENGTH}, ("centre_mm",)),
    }
    known: Values = {
        "file": {"type": "string", "minLength": 1},
        "unit": {"enum": ["mm", "cm", "m", "inch"]},
        "density_kg_m3": POSITIVE,
        "density_pm_kg_m3": {"type": "number", "minimum": 0},
        "crankpin_in_file": {"type": "boolean"},
        "axis_point_mm": _vector(3),
        "axis_direction": _vector(3),
        "crankpins": pins,
        "main_journals": pins,
        "body": {"type": ["integer", "string"]},
    }
    return _table({key: known.get(key, {}) for key in CRANKSHAFT_KEYS}, ("file", "density_kg_m3"))


def _engine() -> Values:
    weight = {"type": ["number", "object"]}
    weights = {name: {"type": "object", "additionalProperties": weight} for name in WEIGHT_TABLES}
    rods = {"type": "integer", "minimum": 1}
    throw = _table({"number": rods, "rods": rods, "bank_deg": {}, **weights}, ("number",))
    return _table(
        {
            "rod_length_mm": LENGTH,
            "stroke_mm": LENGTH,
            "rods_per_throw": rods,
            **weights,
            "throw": {"type": "array", "items": throw},
            "attached": {"type": "array", "items": {"type": "object"}},
            "layout": {"type": "object"},
            "rod": {"type": "object"},
        }
    )


def _balance() -> Values:
    return {
        "type": "object",
        "properties": {
            "factor": {"anyOf": [SHARE, {"const": "original"}]},
            "grade": POSITIVE,
            "speed_rpm": POSITIVE,
            "judge": {"enum": ["dynamic", "static"]},
            "rotor_mass_g": POSITIVE,
            "tolerance_planes_mm": _vector(2),
        },
        "required": ["factor", "grade", "speed_rpm"],
    }


def _correction() -> Values:
    method = {"enum": list(KINDS)}
    kinds = {name: _table({each.name: {} for each in fields(kind.limits)}) for name, kind in KINDS.items()}
    # the types of limits are the program's to check: their keys are what an editor needs
    return {
        "type": "object",
        "properties": {
            "method": {"anyOf": [method, {"type": "array", "items": method, "minItems": 1}]},
            "prefer": {"enum": list(get_args(Prefer)), "default": "simple"},
            **kinds,
        },
        "required": ["method"],
    }


def _vector(length: int) -> Values:
    return {"type": "array", "items": LENGTH, "minItems": length, "maxItems": length}
