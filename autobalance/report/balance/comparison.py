"""A comparison of kinds of correction as a record and as a table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape

from autobalance.balancing.comparison import ComparedRow, judged, why_recommended
from autobalance.correction.contract import Prefer
from autobalance.report.display_units import DisplayUnits, in_units
from autobalance.report.records.compare import Comparison, WorstPlace
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
GOOD = ("within_tolerance", "already_within_tolerance")


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


def comparison_text(compared: Comparison, units: DisplayUnits, verbose: bool = False) -> str:
    """Return a comparison that a mechanic can read: what is recommended, then a block a kind, best first.

    Kinds above tolerance are each given the reason's first and last words, all of them where ``verbose``.
    """
    worst = compared.initial_worst
    ordered = _ranked(compared.rows)
    within = sum(row.outcome in GOOD for row in ordered)
    first = next((row for row in ordered if row.rank == 1), None)
    head = [
        f"{'WITHIN' if within else 'ABOVE'} TOLERANCE with {within} of {len(ordered)} methods",
        f"Recommended: {_recommended(compared)}{_first(first, units)}",
        "left: no method within tolerance" if first is None else f"left {_used(first)} of permitted",
    ]
    before = (
        f"{compared.job}: {worst.place} has {units.of_unbalance(worst.g_mm)} before, "
        f"{units.of_unbalance(worst.permissible_g_mm)} permitted there ({percent(worst.share)}); "
        f"the resultant has {units.of_unbalance(compared.initial_g_mm)}"
    )
    blocks = ["\n".join(_block(row, units, verbose)) for row in ordered]
    unbeaten = ", ".join(compared.unbeaten) or "none is within tolerance"
    legend = (
        "of permitted: the worst judged value, the resultant or a plane; metal: taken, added and pressed in; "
        "capacity: how many times this unbalance could be corrected"
    )
    last = [
        f"Why {_recommended(compared)}: {in_units(compared.why, units)}",
        *([legend] if verbose else []),
        f"Nothing beats: {unbeaten}",
    ]
    return "\n\n".join(["\n".join(head), before, *blocks, "\n".join(last)])


def _ranked(rows: Sequence[ComparedRow]) -> list[ComparedRow]:
    """Return rows by rank, then those above tolerance by what they leave, then those without a place."""

    def order(row: ComparedRow) -> tuple[float, float]:
        left = math.inf if row.residual_share is None else row.residual_share
        return math.inf if row.rank is None else row.rank, left

    return sorted(rows, key=order)


def _first(row: ComparedRow | None, units: DisplayUnits) -> str:
    """Return the cuts of the recommended kind in a few words."""
    if row is None or not row.cuts:
        return ""
    deepest = units.of_size(max(abs(depth) for depth in row.depths_mm))
    return f": {row.cuts} cuts, deepest {deepest} ({units.of_mass(row.metal_moved_g or 0.0)} moved)"


def _used(row: ComparedRow) -> str:
    return percent(row.residual_share or 0.0)


def _block(row: ComparedRow, units: DisplayUnits, verbose: bool) -> list[str]:
    """Return the lines of a kind: verdict, cuts and metal, what is left of the crank; or why it fails."""
    if row.outcome is None:
        return [f"{row.name}: no place", f"  - {in_units(row.reason or '', units)}"]
    _, _, _, _, metal, inertia, cuts, different, deepest, wall, keep, capacity = _cells(row, units)
    rank = "" if row.rank is None else f"{row.rank}. "
    beaten = f", beaten by {', '.join(row.beaten_by)}" if row.outcome in GOOD and row.beaten_by else ""
    lines = [f"{rank}{row.name}: {VERDICTS[row.outcome]}, {_used(row)} of permitted{beaten}"]
    if row.cuts:
        lines.append(f"   {cuts} cuts, {different} different; deepest {deepest}; {metal} moved")
        left = f"wall left {wall}; " if wall else ""
        lines.append(f"   {left}webs keep {keep}; inertia {inertia}; capacity {capacity}")
    if row.outcome == "above_tolerance":
        clauses = in_units(row.reason or "", units).split("; ")
        shown = clauses if verbose or len(clauses) < 3 else [clauses[0], clauses[-1]]
        lines += [f"   - {clause}" for clause in shown]
    return lines


def comparison_html(compared: Comparison, units: DisplayUnits) -> str:
    """Return a comparison as a table for a notebook, ranked, the recommended one first."""
    head = ("", "Correction", "verdict", "of permitted", "metal", "cuts", "different", "wall left")
    ordered = _ranked(compared.rows)
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
        units.of_size(max(abs(depth) for depth in row.depths_mm)) if row.depths_mm else "",
        "" if row.wall_left_mm is None else units.of_size(row.wall_left_mm),
        "" if row.web_metal_share is None else f"{100.0 * row.web_metal_share:.0f} %",
        capacity,
    )
