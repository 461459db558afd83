"""Influence coefficients and the weights that correct, as lines to read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from autobalance.report.balance.headline import OUTCOMES
from autobalance.report.display_units import DisplayUnits
from autobalance.report.tables import table

if TYPE_CHECKING:
    from autobalance.test_stands.influence.answer import InfluenceReport, PlaneCorrection

GOALS = {"least_squares": "least squares", "least_worst": "smallest worst reading"}


def influence_text(report: InfluenceReport, units: DisplayUnits) -> str:
    """Return the weights to add in each plane, and the readings before and after."""
    parts = [
        f"{len(report.initial)} readings, {len(report.planes)} planes, {GOALS[report.goal]}; "
        f"condition {report.condition:.3g}",
        _corrections(report.corrections, units),
        _readings(report),
    ]
    if report.add_to_left is not None:
        rows: list[Sequence[str]] = [("With the trials left on", "add", "at")]
        rows += [
            (
                f"  {each.plane}",
                units.of_unbalance(each.g_mm),
                units.heavy_at(each.g_mm, each.angle_deg, 2),
            )
            for each in report.add_to_left
        ]
        parts.insert(2, table(rows))
    if report.outcome is not None:
        parts.append(OUTCOMES[report.outcome] + (f": {report.reason}" if report.reason else ""))
    return "\n\n".join(parts)


def _corrections(corrections: Sequence[PlaneCorrection], units: DisplayUnits) -> str:
    rows: list[Sequence[str]] = [("Plane", "add", "at", "or take off at", "weight")]
    for each in corrections:
        grams, radius_mm = each.g, each.radius_mm
        weight = ""
        if grams is not None and radius_mm is not None:
            weight = f"{units.of_mass(grams)} at {units.of_length(radius_mm)}"
        rows.append(
            (
                f"  {each.plane}",
                units.of_unbalance(each.g_mm),
                units.heavy_at(each.g_mm, each.angle_deg, 2),
                units.heavy_at(each.g_mm, each.remove_angle_deg, 2),
                weight,
            )
        )
        rows += [
            ("    fitted", units.of_unbalance(piece.g_mm), f"{piece.angle_deg:.2f}°", "", "")
            for piece in each.split or ()
        ]
    return table(rows)


def _readings(report: InfluenceReport) -> str:
    rows: list[Sequence[str]] = [("Reading", "before", "after")]
    pairs = zip(report.initial, report.residual.readings, strict=True)
    rows += [
        (f"  {number}", f"{before[0]:.4g} ∠ {before[1]:.1f}°", f"{after[0]:.4g} ∠ {after[1]:.1f}°")
        for number, (before, after) in enumerate(pairs, 1)
    ]
    residual = report.residual
    return f"{table(rows)}\n  worst {residual.worst:.4g}, rms {residual.rms:.4g}"
