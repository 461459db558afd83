"""A comparison of kinds of correction as a record and as a table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from autobalance.balancing.comparison import Row, beaten_by, ranked, why_recommended
from autobalance.correction.contract import Prefer
from autobalance.report.display_units import DisplayUnits, in_units
from autobalance.report.records.compare import ComparedRow, Comparison, WorstPlace
from autobalance.report.tables import table
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.wording import percent

VERDICTS: Mapping[str | None, str] = {
    "within_tolerance": "within",
    "already_within_tolerance": "already",
    "above_tolerance": "ABOVE",
    None: "no place",
}


def comparison(
    job_name: str, tolerance: Tolerance, initial: Unbalance, rows: Sequence[Row], prefer: Prefer = "simple"
) -> Comparison:
    """Return a comparison: rows within tolerance are ranked, the first recommended."""
    beaten, order = beaten_by(rows), ranked(rows, prefer)
    rank = {row.name: place for place, row in enumerate(order, 1)}
    return Comparison(
        job=job_name,
        initial_g_mm=initial.magnitude_g_mm,
        initial_worst=WorstPlace.of(tolerance.worst(initial)),
        permissible_g_mm=tolerance.permissible_g_mm,
        prefer=prefer,
        recommended=order[0].methods if order else None,
        why=why_recommended(order, rows, prefer),
        ranking=[row.name for row in order],
        rows=[_row(row, rank.get(row.name), beaten[row.name]) for row in rows],
        unbeaten=[row.name for row in rows if row.outcome == "within_tolerance" and not beaten[row.name]],
    )


def _row(row: Row, rank: int | None, beaten_by: Sequence[str]) -> ComparedRow:
    plenty = row.capacity is not None and math.isinf(row.capacity)
    return ComparedRow(
        method=row.methods,
        outcome=row.outcome,
        reason=row.reason,
        residual_share=row.share,
        residual_g_mm=row.residual_g_mm,
        mass_change_g=row.mass_change_g,
        metal_moved_g=row.moved_g,
        inertia_change_g_mm2=row.inertia_change_g_mm2,
        cuts=row.cuts,
        different_cuts=row.different,
        depths_mm=row.depths_mm,
        wall_left_mm=row.wall_left_mm,
        web_metal_share=row.thinnest_share,
        capacity=None if plenty else row.capacity,
        capacity_is_plenty=plenty,
        rank=rank,
        beaten_by=beaten_by,
    )


def comparison_text(values: Mapping[str, Any], units: DisplayUnits) -> str:
    """Return a comparison as a table that a mechanic can read, from its own values."""
    head = (
        "Correction",
        "rank",
        "verdict",
        "of permitted",
        "metal",
        "inertia",
        "cuts",
        "different",
        "deepest",
        "wall left",
        "webs keep",
        "capacity",
    )
    rows = [head] + [_cells(row, units) for row in values["rows"]]
    worst = values["initial_worst"]
    lines = [
        f"{values['job']}: {worst['place']} has {units.of_unbalance(worst['g_mm'])} before, "
        f"{units.of_unbalance(worst['permissible_g_mm'])} permitted there ({percent(worst['share'])}); "
        f"the resultant has {units.of_unbalance(values['initial_g_mm'])}",
        "",
        table(rows),
        "",
        "of permitted: the worst judged value, the resultant or a plane; "
        "metal: taken, added and pressed in; capacity: how many times this unbalance could be corrected",
    ]
    reasons: dict[str, list[str]] = {}
    for row in values["rows"]:
        if row["outcome"] == "within_tolerance" and row["beaten_by"]:
            lines.append(f"{_name(row)} is beaten by {', '.join(row['beaten_by'])}")
        elif row["outcome"] not in ("within_tolerance", "already_within_tolerance"):
            reasons.setdefault(in_units(row["reason"] or "", units), []).append(_name(row))
    lines += [f"{', '.join(names)}: {reason}" for reason, names in reasons.items()]
    unbeaten = ", ".join(values["unbeaten"]) or "none is within tolerance"
    best = "none" if values["recommended"] is None else "+".join(values["recommended"])
    why = in_units(values["why"], units)
    return "\n".join([*lines, f"Recommended: {best} ({why})", f"Nothing beats: {unbeaten}"])


def comparison_html(values: Mapping[str, Any], units: DisplayUnits) -> str:
    """Return a comparison as a table for a notebook, ranked, the recommended one first."""
    head = ("", "Correction", "verdict", "of permitted", "metal", "cuts", "different", "wall left")
    ordered = sorted(values["rows"], key=lambda row: math.inf if row["rank"] is None else row["rank"])
    lines = []
    for row in ordered:
        name, rank, verdict, residual, metal, _, cuts, different, _, wall, *_ = _cells(row, units)
        cells = (rank, name.strip(), verdict, residual, metal, cuts, different, wall)
        lines.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
    title = "".join(f"<th>{escape(word)}</th>" for word in head)
    best = "none" if values["recommended"] is None else "+".join(values["recommended"])
    return (
        f"<p>Recommended: <b>{escape(best)}</b> ({escape(in_units(values['why'], units))})</p>"
        f"<table><tr>{title}</tr>{''.join(lines)}</table>"
    )


def _name(row: Mapping[str, Any]) -> str:
    return "+".join(row["method"])


def _cells(row: Mapping[str, Any], units: DisplayUnits) -> tuple[str, ...]:
    name, verdict = "  " + _name(row), VERDICTS[row["outcome"]]
    if row["outcome"] is None:
        return (name, "", verdict, *[""] * 9)
    depths = row["depths_mm"]
    capacity = "plenty" if row["capacity_is_plenty"] else f"{row['capacity']:.2f}"
    return (
        name,
        "" if row["rank"] is None else f"{row['rank']}.",
        verdict,
        percent(row["residual_share"]),
        units.of_mass(row["metal_moved_g"]),
        units.of_inertia(row["inertia_change_kg_mm2"], 2, "+"),
        str(row["cuts"]),
        str(row["different_cuts"]),
        units.of_length(max(abs(depth) for depth in depths)) if depths else "",
        "" if row["wall_left_mm"] is None else units.of_length(row["wall_left_mm"]),
        "" if row["web_metal_share"] is None else f"{100.0 * row['web_metal_share']:.0f} %",
        capacity,
    )
