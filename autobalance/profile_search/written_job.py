"""Job of a written design, by which ``balance`` finds it within tolerance already."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalance.profile_search.problem import Problem
from autobalance.toml_files.text import toml_text
from autobalance.units import MM_PER


def job_toml(problem: Problem) -> str:
    """Return a job of the written crank, by which ``balance`` finds it within tolerance already."""
    raw, start, anatomy = problem.design.raw, problem.design.start, problem.crank.anatomy
    back = anatomy.rotor_to_file
    own = raw["crankshaft"]

    def in_file(point: Any) -> list[float]:
        return [float(v) for v in back[:3, :3] @ np.asarray(point) + back[:3, 3]]

    def pins(crankpins: Sequence[Any]) -> list[dict[str, Any]]:
        return [
            {"centre_mm": in_file(p.centre_mm), "diameter_mm": p.diameter_mm, "width_mm": p.width_mm}
            for p in crankpins
        ]

    crankshaft: dict[str, Any] = {
        "file": "crank.stl",
        "unit": own.get("unit") or _unit_of(problem),
        "density_kg_m3": own["density_kg_m3"],
        "crankpin_in_file": start.crankshaft.crankpin_in_file,
        "axis_point_mm": in_file([0.0, 0.0, 0.0]),
        "axis_direction": [float(v) for v in back[:3, 2]],
        "crankpins": pins([throw.crankpin for throw in anatomy.throws]),
        "main_journals": pins(anatomy.main_journals),
    }
    balance = {**raw["balance"], "factor": problem.factor}
    tables = {"crankshaft": crankshaft, "engine": raw.get("engine", {}), "balance": balance}
    return toml_text({**tables, "correction": {"method": "drill"}})


def _unit_of(problem: Problem) -> str:
    scale = problem.crank.source.mm_per_unit
    return next(name for name, mm in MM_PER.items() if mm == scale)
