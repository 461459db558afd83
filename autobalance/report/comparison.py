"""A comparison of kinds of correction as JSON values and as a table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.balancing.comparison import Row, beaten_by
from autobalance.report.json import G_MM2_PER_KG_MM2, SCHEMA_VERSION
from autobalance.report.tables import table
from autobalance.report.text import Units, fixed
from autobalance.rigid_rotor.tolerance import Tolerance

Values = dict[str, Any]

VERDICTS: Mapping[str | None, str] = {
    "within_tolerance": "within",
    "already_within_tolerance": "already",
    "above_tolerance": "ABOVE",
    None: "no place",
}


def comparison(job_name: str, tolerance: Tolerance, initial_g_mm: float, rows: Sequence[Row]) -> Values:
    """Return a comparison as JSON values.

    ``beaten_by`` lists what is nowhere worse and somewhere better; what nothing beats has none.
    """
    beaten = beaten_by(rows)
    return {
        "schema_version": SCHEMA_VERSION,
        "command": "compare",
        "job": job_name,
        "initial_g_mm": initial_g_mm,
        "permissible_g_mm": tolerance.permissible_g_mm,
        "rows": [{**_row(row), "beaten_by": beaten[row.name]} for row in rows],
        "unbeaten": [row.name for row in rows if row.outcome == "within_tolerance" and not beaten[row.name]],
    }


def _row(row: Row) -> Values:
    inertia = row.inertia_change_g_mm2
    plenty = row.capacity is not None and math.isinf(row.capacity)
    return {
        "method": list(row.methods),
        "outcome": row.outcome,
        "reason": row.reason,
        "residual_share": row.share,
        "residual_g_mm": row.residual_g_mm,
        "mass_change_g": row.mass_change_g,
        "metal_moved_g": row.moved_g,
        "inertia_change_kg_mm2": None if inertia is None else inertia / G_MM2_PER_KG_MM2,
        "cuts": row.cuts,
        "depths_mm": list(row.depths_mm),
        "wall_left_mm": row.wall_left_mm,
        "capacity": None if plenty else row.capacity,
        "capacity_is_plenty": plenty,
    }


def comparison_text(values: Mapping[str, Any], units: Units) -> str:
    """Return a comparison as a table that a mechanic can read, from its own values."""
    head = (
        "Correction",
        "verdict",
        "residual",
        "metal",
        "inertia",
        "cuts",
        "deepest",
        "wall left",
        "capacity",
    )
    rows = [head] + [_cells(row, units) for row in values["rows"]]
    lines = [
        f"{values['job']}: {units.of_unbalance(values['initial_g_mm'])} before, "
        f"{units.of_unbalance(values['permissible_g_mm'])} permitted",
        "",
        table(rows),
        "",
        "metal: taken, added and pressed in; capacity: how many times this unbalance could be corrected",
    ]
    for row in values["rows"]:
        if row["outcome"] == "within_tolerance" and row["beaten_by"]:
            lines.append(f"{_name(row)} is beaten by {', '.join(row['beaten_by'])}")
        elif row["outcome"] not in ("within_tolerance", "already_within_tolerance"):
            lines.append(f"{_name(row)}: {row['reason']}")
    unbeaten = ", ".join(values["unbeaten"]) or "none is within tolerance"
    return "\n".join([*lines, f"Nothing beats: {unbeaten}"])


def _name(row: Mapping[str, Any]) -> str:
    return "+".join(row["method"])


def _cells(row: Mapping[str, Any], units: Units) -> tuple[str, ...]:
    name, verdict = "  " + _name(row), VERDICTS[row["outcome"]]
    if row["outcome"] is None:
        return (name, verdict, *[""] * 7)
    depths = row["depths_mm"]
    capacity = "plenty" if row["capacity_is_plenty"] else f"{row['capacity']:.2f}"
    return (
        name,
        verdict,
        units.of_unbalance(row["residual_g_mm"]),
        units.of_mass(row["metal_moved_g"]),
        f"{row['inertia_change_kg_mm2']:+.2f} kg·mm²",
        str(row["cuts"]),
        units.of_length(max(abs(depth) for depth in depths)) if depths else "",
        "" if row["wall_left_mm"] is None else f"{fixed(row['wall_left_mm'] / units.mm_per_length, 2)}",
        capacity,
    )
