"""A comparison of kinds of correction as a record and as a table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape

from autobalance.balancing.comparison import ComparedRow, judged, why_recommended
from autobalance.correction.contract import Prefer
from autobalance.report.display_units import DisplayUnits, in_units
from autobalance.report.records.compare import Comparison, WorstPlace
from autobalance.report.tables import table
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.units import G_MM2_PER_KG_MM2
from autobalance.wording import percent

VERDICTS: Mapping[str | None, str] = {
    "within_tolerance": "within",
    "already_within_tolerance": "already",
    "above_tolerance": "ABOVE",
    None: "no place",
}


def comparison(
    job_name: str,
    tolerance: Tolerance,
    initial: Unbalance,
    rows: Sequence[ComparedRow],
    prefer: Prefer = "simple",
) -> Comparison:
    """Return a comparison: rows within tolerance are ranked, the first recommended."""
    rows, order = judged(rows, prefer)
    return Comparison(
        job=job_name,
        initial_g_mm=initial.magnitude_g_mm,
        initial_worst=WorstPlace.of(tolerance.worst(initial)),
        permissible_g_mm=tolerance.permissible_g_mm,
        prefer=prefer,
        recommended=order[0].method if order else None,
        why=why_recommended(order, rows, prefer),
        ranking=[row.name for row in order],
        rows=rows,
        unbeaten=[row.name for row in rows if row.outcome == "within_tolerance" and not row.beaten_by],
    )


def comparison_text(compared: Comparison, units: DisplayUnits) -> str:
    """Return a comparison as a table that a mechanic can read."""
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
    rows = [head] + [_cells(row, units) for row in compared.rows]
    worst = compared.initial_worst
    lines = [
        f"{compared.job}: {worst.place} has {units.of_unbalance(worst.g_mm)} before, "
        f"{units.of_unbalance(worst.permissible_g_mm)} permitted there ({percent(worst.share)}); "
        f"the resultant has {units.of_unbalance(compared.initial_g_mm)}",
        "",
        table(rows),
        "",
        "of permitted: the worst judged value, the resultant or a plane; "
        "metal: taken, added and pressed in; capacity: how many times this unbalance could be corrected",
    ]
    reasons: dict[str, list[str]] = {}
    for row in compared.rows:
        if row.outcome == "within_tolerance" and row.beaten_by:
            lines.append(f"{row.name} is beaten by {', '.join(row.beaten_by)}")
        elif row.outcome not in ("within_tolerance", "already_within_tolerance"):
            reasons.setdefault(in_units(row.reason or "", units), []).append(row.name)
    lines += [f"{', '.join(names)}: {reason}" for reason, names in reasons.items()]
    unbeaten = ", ".join(compared.unbeaten) or "none is within tolerance"
    best = f"Recommended: {_recommended(compared)} ({in_units(compared.why, units)})"
    return "\n".join([*lines, best, f"Nothing beats: {unbeaten}"])


def comparison_html(compared: Comparison, units: DisplayUnits) -> str:
    """Return a comparison as a table for a notebook, ranked, the recommended one first."""
    head = ("", "Correction", "verdict", "of permitted", "metal", "cuts", "different", "wall left")
    ordered = sorted(compared.rows, key=lambda row: math.inf if row.rank is None else row.rank)
    lines = []
    for row in ordered:
        name, rank, verdict, residual, metal, _, cuts, different, _, wall, *_ = _cells(row, units)
        cells = (rank, name.strip(), verdict, residual, metal, cuts, different, wall)
        lines.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
    title = "".join(f"<th>{escape(word)}</th>" for word in head)
    why = escape(in_units(compared.why, units))
    return (
        f"<p>Recommended: <b>{escape(_recommended(compared))}</b> ({why})</p>"
        f"<table><tr>{title}</tr>{''.join(lines)}</table>"
    )


def _recommended(compared: Comparison) -> str:
    return "none" if compared.recommended is None else "+".join(compared.recommended)


def _cells(row: ComparedRow, units: DisplayUnits) -> tuple[str, ...]:
    name, verdict = f"  {row.name}", VERDICTS[row.outcome]
    if row.outcome is None:
        return (name, "", verdict, *[""] * 9)
    inertia_kg_mm2 = (row.inertia_change_g_mm2 or 0.0) / G_MM2_PER_KG_MM2
    capacity = "plenty" if row.capacity_is_plenty else f"{row.capacity:.2f}"
    return (
        name,
        "" if row.rank is None else f"{row.rank}.",
        verdict,
        percent(row.residual_share or 0.0),
        units.of_mass(row.metal_moved_g or 0.0),
        units.of_inertia(inertia_kg_mm2, 2, "+"),
        str(row.cuts),
        str(row.different_cuts),
        units.of_length(max(abs(depth) for depth in row.depths_mm)) if row.depths_mm else "",
        "" if row.wall_left_mm is None else units.of_length(row.wall_left_mm),
        "" if row.web_metal_share is None else f"{100.0 * row.web_metal_share:.0f} %",
        capacity,
    )
