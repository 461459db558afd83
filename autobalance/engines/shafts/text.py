"""Balance shafts as lines to read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from autobalance.engines.forces.show import orders_table
from autobalance.report.display_units import DisplayUnits
from autobalance.report.files import from_here
from autobalance.report.tables import table

if TYPE_CHECKING:
    from autobalance.engines.forces.counterweight import ShaftWeight
    from autobalance.engines.shafts.answer import RollAmplitude, Shaft, ShaftsReport

LEAST_ROLL = 0.005
"""Amplitude [N·m] from which on an order of the roll is listed."""


def shafts_text(report: ShaftsReport, units: DisplayUnits) -> str:
    """Return the summary of ``shafts``: orders that shake, proposals, and the effect of the job's shafts."""
    parts = [
        f"{from_here(report.job['file'])}: balance shafts at {report.speed_rpm:g} rpm, crank balanced to"
        f" {report.balance_factor:.4f}; moments about z = {report.moments_about_z_mm:.2f} mm",
        "Without shafts\n" + orders_table(report.without.orders),
    ]
    rows = [("Shafts that would cancel", "speed", "sense", "each", "phase", "where")]
    for offer in report.proposals:
        for shaft in offer.shafts:
            rows.append((f"  {offer.what}", *_shaft_cells(shaft, units), _where(shaft, units)))
        for pair in offer.couple_shafts:
            for each in pair.unbalances:
                cells = _turning(pair.order, pair.sense, each.product_g_mm, each.phase_deg, units)
                rows.append((f"  {offer.what}", *cells, f"z {units.of_length(each.z_mm)}"))
    parts.append(table(rows) if len(rows) > 1 else "No order that shafts could cancel is left.")
    if report.shafts:
        rows = [("Shafts of the job", "speed", "sense", "product", "phase", "where")]
        rows += [
            (f"  {number}", *_shaft_cells(shaft, units), _where(shaft, units))
            for number, shaft in enumerate(report.shafts, 1)
        ]
        lines = [table(rows)]
        for shaft in report.shafts:
            for weight in shaft.weights:
                lines.append(_bolted(weight, units))
        lines.append("Residual after the shafts\n" + orders_table(report.with_.orders))
        parts.append("\n".join(lines))
    parts.append(_shafts_roll(report))
    return "\n\n".join(parts)


def _shafts_roll(report: ShaftsReport) -> str:
    """Return the roll couple about the crank axis without shafts, with each proposal, and with the job's."""
    cases = [("without shafts", report.without.greatest_roll_n_m, report.without.roll_orders)]
    cases += [
        (f"with {offer.what} cancelled", offer.greatest_roll_n_m, offer.roll_orders)
        for offer in report.proposals
        if offer.shafts
    ]
    if report.shafts:
        cases.append(("with the job's shafts", report.with_.greatest_roll_n_m, report.with_.roll_orders))
    shown = [each for each in (1, 2, 3, 4) if any(_order(orders, each) >= LEAST_ROLL for *_, orders in cases)]
    head = ("Roll couple on the block, reaction of the torque left out", "maximum")
    rows: list[Sequence[str]] = [(*head, *(f"order {each}" for each in shown))]
    for name, greatest, orders in cases:
        amplitudes = (f"{_order(orders, each):.2f} N·m" for each in shown)
        rows.append((f"  {name}", f"{greatest:.2f} N·m", *amplitudes))
    if report.shafts:
        alone = f"{report.with_.greatest_shaft_roll_n_m:.2f} N·m"
        rows.append(("  the job's shafts alone", alone, *("" for _ in shown)))
    return table(rows)


def _order(orders: Sequence[RollAmplitude], number: int) -> float:
    return next(each.roll_n_m for each in orders if each.order == number)


def _where(shaft: Shaft, units: DisplayUnits) -> str:
    """Return the place of a shaft: along the axis, and beside it where it does not be on it."""
    along = f"z {units.of_length(shaft.z_mm)}"
    x, y = shaft.place_mm
    return along if x == y == 0.0 else f"{along}, x {units.of_length(x)}, y {units.of_length(y)}"


def _shaft_cells(shaft: Shaft, units: DisplayUnits) -> tuple[str, str, str, str]:
    return _turning(shaft.order, shaft.sense, shaft.product_g_mm, shaft.phase_deg, units)


def _turning(
    order: int, sense: str, product_g_mm: float, phase_deg: float, units: DisplayUnits
) -> tuple[str, str, str, str]:
    """Return the cells of an unbalance on a shaft."""
    return f"{order} ×", sense, units.of_unbalance(product_g_mm), f"{phase_deg:.1f}°"


def _bolted(weight: ShaftWeight, units: DisplayUnits) -> str:
    drawn = units.of_mass(weight.cad_g)
    at = units.of_length(weight.eccentricity_mm)
    if weight.weighed_g is None or weight.deviation is None:
        return f"  {weight.name}: {drawn} drawn, not weighed, at {at}"
    return (
        f"  {weight.name}: {drawn} drawn, {units.of_mass(weight.weighed_g)} weighed"
        f" ({100.0 * weight.deviation:+.2f} %), at {at}"
    )
