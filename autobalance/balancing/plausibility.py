"""Whether a crank and a job can be what they say: physics, not taste.

What no crank can be is refused; what is odd is said, with the unit that may be meant and where.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from autobalance.balancing.rotor_from_job import throw_loads, total_g
from autobalance.crank.anatomy import Anatomy
from autobalance.engine.conrod import ConnectingRod
from autobalance.errors import JobError
from autobalance.job.model import Crankshaft, Job
from autobalance.solid.formats.read import Source

if TYPE_CHECKING:
    from autobalance.balancing.measured_crank import Crank

DENSITY_KG_M3 = (500.0, 23000.0)
"""Foamed plastic to osmium: no crank is of anything lighter or heavier."""
SIZE_MM = (5.0, 5000.0)
"""Longest side of a crank: a model aircraft's to a large ship's throw."""
ODD_MM = (25.0, 3000.0)
"""Beyond these a crank is odd: most likely it is drawn in another unit."""
BOB_SHARE = (1e-3, 20.0)
"""Bob-weights over the crank's own mass: nothing that runs lies outside."""
UNLIKE = 50.0
"""How many times all that turns with a rod may weigh what goes up and down with it, or the reverse."""
FACTOR = (-1.0, 3.0)
"""Balance factor that a crank may have before, with parts that are meant for it."""
INERTIA_SHARE = (0.5, 2.0)
INERTIA_REFUSED = (0.05, 20.0)
"""A rod's inertia over m a b of two masses at its eyes: rods are near 1."""
BIG_END = (1.2, 5.0)
"""The rod's big end on the scale over all that turns with it: odd above, refused above."""


def refuse_density(crankshaft: Crankshaft) -> None:
    """Refuse a density that nothing has.

    Raises
    ------
    JobError
        That says which unit may be meant.
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
    JobError
        That says which unit would make it one.
    """
    low, high = SIZE_MM
    longest = _longest_mm(source)
    if not low <= longest <= high:
        raise JobError(
            f"{file}: the crank is {longest:.4g} mm long; needed {low:g} to {high:g} mm{_meant(source)}"
        )


def odd_size(source: Source) -> str | None:
    """Return what is odd about a crank's size, if anything is."""
    low, high = ODD_MM
    longest = _longest_mm(source)
    if low <= longest <= high:
        return None
    return f"the crank is {longest:.4g} mm long; odd outside {low:g} to {high:g} mm{_meant(source)}"


def _longest_mm(source: Source) -> float:
    low, high = source.solid.bounds
    return float((high - low).max())


def _meant(source: Source) -> str:
    """Ask for the units that would make a solid a crank of a usual size."""
    own, longest = source.mm_per_unit, _longest_mm(source)
    meant = [
        name
        for name, mm in (("mm", 1.0), ("cm", 10.0), ("m", 1000.0), ("inch", 25.4))
        if 50.0 <= longest / own * mm <= 2000.0 and mm != own
    ]
    return f"; is its unit {' or '.join(meant)}?" if meant else ""


def oddities(job: Job, crank: Crank, factor_before: float | None) -> tuple[str, ...]:
    """Return what is odd about a job for its crank, one line each.

    Raises
    ------
    JobError
        For what cannot be: weights in another unit, a rod that is none, rods beyond the mains.
    """
    odd = (*_bob_weights(job, crank), *_unlike_weights(job))
    return (*odd, *_factor(job, factor_before), *_rod(job), *_pitch(job, crank.anatomy))


def _bob_weights(job: Job, crank: Crank) -> Iterator[str]:
    """Weights in kilograms make bob-weights of nothing; those in milligrams, ones heavier than the crank."""
    total = sum(load.parts.bob_weight_g(1.0) for load in throw_loads(crank.anatomy, job.engine))
    if total <= 0.0:
        return
    share = total / crank.moments.mass_g
    low, high = BOB_SHARE
    if not low <= share <= high:
        meant = "kg" if share < low else "mg"
        raise JobError(
            f"{job.path.name}: the weights of [engine] add up to {total:.4g} g on a crank of"
            f" {crank.moments.mass_g:.4g} g; needed {low:g} to {high:g} times that; are they in {meant}?"
        )
    if not 10.0 * low <= share <= 0.25 * high:
        yield (
            f"{job.path.name}: the weights of [engine], {total:.4g} g, are odd for a crank of"
            f" {crank.moments.mass_g:.4g} g"
        )


def _unlike_weights(job: Job) -> Iterator[str]:
    """One table in kilograms beside another in grams."""
    weights = job.engine.default.weights
    rotating, reciprocating = total_g(weights.rotating), total_g(weights.reciprocating)
    less, more = sorted((rotating, reciprocating))
    if 0.0 < less < more / UNLIKE:
        table = "rotating_g" if rotating < reciprocating else "reciprocating_g"
        yield (
            f"{job.path.name}: engine.{table} adds up to {less:.4g} g, the weights beside it to {more:.4g} g;"
            " is one of them in another unit?"
        )


def _factor(job: Job, before: float | None) -> Iterator[str]:
    if before is not None and not FACTOR[0] <= before <= FACTOR[1]:
        yield (
            f"{job.path.name}: the crank's balance factor before is {before:.4g} with these weights; odd"
            f" outside {FACTOR[0]:g} to {FACTOR[1]:g}: check weights, density and the file's unit"
        )


def _rod(job: Job) -> Iterator[str]:
    """Compare ``[engine.rod]`` with the weights and with itself."""
    rod, engine = job.engine.rod, job.engine
    if rod is None:
        return
    rotating = total_g(engine.default.weights.rotating)
    if rotating > 0.0 and rod.big_end_g > BIG_END[1] * rotating:
        raise JobError(
            f"{job.path.name}: engine.rod.big_end_g is {rod.big_end_g:g}, all of engine.rotating_g"
            f" {rotating:g} g; the big end is a part of that"
        )
    if rotating > 0.0 and rod.big_end_g > BIG_END[0] * rotating:
        yield (
            f"{job.path.name}: engine.rod.big_end_g is {rod.big_end_g:g}, more than all of engine.rotating_g,"
            f" {rotating:g} g"
        )
    if rod.inertia_g_mm2 is None or engine.rod_length_mm is None:
        return
    whole = ConnectingRod.from_two_scales(rod.big_end_g, rod.small_end_g, engine.rod_length_mm)
    if not whole.two_mass_inertia_g_mm2 > 0.0:
        return
    share = rod.inertia_g_mm2 / whole.two_mass_inertia_g_mm2
    told = (
        f"{job.path.name}: engine.rod.inertia_kg_mm2 is {rod.inertia_g_mm2 * 1e-3:g}, {share:.3g} times"
        " that of two masses at its eyes"
    )
    if not INERTIA_REFUSED[0] <= share <= INERTIA_REFUSED[1]:
        raise JobError(f"{told}; needed {INERTIA_REFUSED[0]:g} to {INERTIA_REFUSED[1]:g} times (kg·mm²)")
    if not INERTIA_SHARE[0] <= share <= INERTIA_SHARE[1]:
        yield f"{told}; rods are near 1"


def _pitch(job: Job, anatomy: Anatomy) -> Iterator[str]:
    """Rods stand on their crankpin, not beyond the mains beside it."""
    pitch = abs(job.engine.layout.rod_pitch_mm)
    mains = sorted(float(journal.centre_mm[2]) for journal in anatomy.main_journals)
    for throw in anatomy.throws:
        half = 0.5 * pitch * (job.engine.of_throw(throw.number).rods - 1)
        if half == 0.0:
            continue
        z, pin = float(throw.crankpin.centre_mm[2]), throw.crankpin.width_mm
        beside = [pair for pair in itertools.pairwise(mains) if pair[0] <= z <= pair[1]]
        if any(z - half < low or z + half > high for low, high in beside):
            raise JobError(
                f"{job.path.name}: engine.layout.rod_pitch_mm is {pitch:g}; on throw {throw.number} the rods"
                f" would stand beyond the main bearings beside it; its crankpin is {pin:.4g} mm wide"
            )
        if half > 0.5 * pin and math.isfinite(pin):
            yield (
                f"{job.path.name}: engine.layout.rod_pitch_mm is {pitch:g}; on throw {throw.number} rods"
                f" stand beside the crankpin, which is {pin:.4g} mm wide"
            )
