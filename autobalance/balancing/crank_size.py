"""Whether a solid can be a crank by its density and size, and which unit would make it one."""

from __future__ import annotations

import math

import numpy as np

from autobalance.errors import JobError
from autobalance.job.model import Crankshaft
from autobalance.solid.formats.read import Source
from autobalance.units import MM_PER

DENSITY_KG_M3 = (500.0, 23000.0)
"""Foamed plastic to osmium: no crank is of anything lighter or heavier."""
SIZE_MM = (5.0, 5000.0)
"""Longest side of a crank: a model aircraft's to a large ship's throw."""
ODD_MM = (18.0, 3000.0)
"""Beyond these a crank is odd where another unit would make it usual: it may be drawn in that one."""
USUAL_MM = (50.0, 2000.0)
NEVER_MIXED = {MM_PER["m"], MM_PER["inch"]}


def refuse_density(crankshaft: Crankshaft) -> None:
    """Refuse a density that nothing has.

    Raises
    ------
    JobError With the unit that may be meant.
    """
    low, high = DENSITY_KG_M3
    density = crankshaft.density_g_mm3 * 1e6
    if not low <= density <= high and density > 0.0:
        meant = f"; {density * 1e3:g} if that was g/cm³" if low <= density * 1e3 <= high else ""
        raise JobError(
            f"crankshaft.density_kg_m3 is {density:g}; must be {low:g} to {high:g} kg/m³ for any metal{meant}"
        )


def refuse_size(source: Source, file: object) -> None:
    """Refuse a solid that no crank can be, by its longest side.

    Raises
    ------
    JobError With the unit that would make it one.
    """
    low, high = SIZE_MM
    longest = longest_mm(source)
    if not low <= longest <= high:
        raise JobError(
            f"{file}: the crank is {longest:.4g} mm long; expected {low:g} to {high:g} mm{_meant(source)}"
        )


def odd_size(source: Source) -> str | None:
    """Return a warning of a crank's odd size; None where it is usual, or in no unit is."""
    low, high = ODD_MM
    longest, meant = longest_mm(source), _meant(source)
    if low <= longest <= high or not meant:
        return None
    return f"the crank is {longest:.4g} mm long; odd outside {low:g} to {high:g} mm{meant}"


def longest_mm(source: Source) -> float:
    """Return the length of a solid along the file's axes, or along its own where that may count.

    Seen along the file's axes, a slanting one may look 1.7 times shorter than it is.
    """
    low, high = source.solid.bounds
    side = float((high - low).max())
    if USUAL_MM[0] <= side and math.sqrt(3.0) * side <= USUAL_MM[1]:
        return side
    away = source.solid.mesh.vertices - 0.5 * (low + high)
    _, own = np.linalg.eigh(away.T @ away)
    return max(side, float(np.ptp(away @ own, axis=0).max()))


def _meant(source: Source) -> str:
    """Ask for the units that would make a solid a crank of a usual size."""
    meant = usual_units(source)
    return f"; is its unit {' or '.join(meant)}?" if meant else ""


def usual_units(source: Source) -> dict[str, float]:
    """Return the units that would make a solid a crank of a usual size, and how much longer it would be."""
    own, longest = source.mm_per_unit, longest_mm(source)
    low, high = USUAL_MM
    if low <= longest <= high:
        return {}
    factors = {name: mm / own for name, mm in MM_PER.items() if mm != own and {mm, own} != NEVER_MIXED}
    return {name: by for name, by in factors.items() if low <= longest * by <= high}
