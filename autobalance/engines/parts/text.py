"""Weights of parts as lines to read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.declare import ABSENT
from autobalance.report.display_units import DisplayUnits
from autobalance.report.files import from_here
from autobalance.report.tables import table
from autobalance.units import G_MM2_PER_KG_MM2

if TYPE_CHECKING:
    from autobalance.engines.parts.answer import PartsReport, RodEnds, ThrowWeights


def parts_text(report: PartsReport, units: DisplayUnits) -> str:
    """Return the roll-up of the parts and the bob-weights."""
    blocks: list[str] = [from_here(report.job["file"])]
    for throw in report.throws:
        rows = [(_throw_name(throw), "weight", "may be off by")]
        for weights, title in (
            (throw.rotating, "rotating, one rod"),
            (throw.reciprocating, "reciprocating, one rod"),
            (throw.crankpin, "on the crankpin"),
        ):
            rows += [
                (f"    {part.name}", units.of_mass(part.mass_g), _off(part.pm_g, units))
                for part in weights.parts
            ]
            rows.append((f"  {title}", units.of_mass(weights.mass_g), _off(weights.pm_g, units)))
        blocks.append(table(rows))
        blocks.append(_bob_weight(throw, units))
    if report.present is not ABSENT:
        blocks.append(_present(report.present))
    if report.rod is not None:
        blocks.append(_rod(report.rod, units))
    return "\n".join(blocks)


def _bob_weight(throw: ThrowWeights, units: DisplayUnits) -> str:
    rods = f"  {throw.rods} rod{'s' * (throw.rods != 1)}"
    if throw.bob_weight_g is None or throw.balance_factor is None:
        return f"{rods}; no bob-weight without a balance factor"
    pin_fitted = throw.bob_weight_pin_fitted_g
    fitted = ""
    if pin_fitted is not None and pin_fitted != throw.bob_weight_g:
        fitted = f"; with the crankpin fitted {units.of_mass(pin_fitted)}"
    return (
        f"{rods}; bob-weight at {throw.balance_factor:.4f}: {units.of_mass(throw.bob_weight_g)}"
        f"{_plus_minus(throw.bob_weight_pm_g or 0.0, units)}{fitted}"
    )


def _present(factor: float | None) -> str:
    if factor is None:
        return "The throws cancel: the crank has no balance factor."
    return f"Balance factor of the crank as it is, with these parts: {factor:.4f}"


def _throw_name(throw: ThrowWeights) -> str:
    return "Throw" if throw.number is None else f"Throw {throw.number}"


def _off(pm_g: float, units: DisplayUnits) -> str:
    return f"± {units.of_mass(pm_g)}" if pm_g else ""


def _rod(rod: RodEnds, units: DisplayUnits) -> str:
    lines = [
        f"Bare rod: {units.of_mass(rod.big_end_g)} at the big end,"
        f" {units.of_mass(rod.small_end_g)} at the small end"
    ]
    if rod.centre_from_big_end_mm is not None:
        lines.append(f"  centre of mass {units.of_length(rod.centre_from_big_end_mm)} from the big end")
    if rod.couple_inertia_g_mm2 is not None:
        lines.append(
            f"  its two masses miss {rod.couple_inertia_g_mm2 / G_MM2_PER_KG_MM2:.1f} kg·mm² of inertia:"
            " the bearing loads count the couple"
        )
    return "\n".join(lines)


def _plus_minus(pm_g: float, units: DisplayUnits) -> str:
    """Return an uncertainty with its sign, or that none is stated."""
    return f" ± {units.of_mass(pm_g)}" if pm_g else ", uncertainty not stated"
