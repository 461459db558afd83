"""A job and its crank become an engine: cylinders on throws, and the crank's unbalance bay by bay."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from autobalance.balancing.linked_rods import LONG_ROD, articulated, bare_rod
from autobalance.balancing.measured import Crank
from autobalance.balancing.rotor_from_job import attached_moments, throw_loads, total_g
from autobalance.crank.anatomy import Anatomy, Throw
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.running_gear.force_summary import ShakingForce, shaking_force
from autobalance.running_gear.shafts import BalanceShaft
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import CrankUnbalance, Cylinder, Engine
from autobalance.solid.csg.solid import Solid

ROUNDING = 1e-5
"""Share of a crank's mass below which what its bays miss of it is rounding, or its facets."""


def cylinders(job: Job, anatomy: Anatomy, *, rod_needed: bool = True) -> tuple[Cylinder, ...]:
    """Return the cylinders of a job's engine.

    Raises
    ------
    JobError
        If the rod length or a cylinder's direction is missing, or a rod is too short.
    """
    if job.engine.rod_length_mm is None and rod_needed:
        raise JobError(f"{job.path.name}: engine.rod_length_mm is missing; forces need it")
    try:
        all_cylinders: list[Cylinder] = []
        for throw in anatomy.throws:
            all_cylinders += articulated(job, throw, len(all_cylinders)) or _of_throw(job, throw)
        return tuple(all_cylinders)
    except JobError:  # has named the job and the key
        raise
    except ValueError as error:
        raise JobError(f"{job.path.name}: engine: {error}") from None


def _of_throw(job: Job, throw: Throw) -> list[Cylinder]:
    engine = job.engine
    parts, layout = engine.of_throw(throw.number), engine.layout
    banks = layout.banks_of(throw.number)
    if banks is None:
        if parts.rods > 1:
            raise JobError(
                f"{job.path.name}: engine.layout.bank_deg is missing; {parts.rods} rods on throw"
                f" {throw.number} need the directions of their cylinders, one angle each"
            )
        banks = (0.0,)
    if len(banks) != parts.rods:
        raise JobError(
            f"{job.path.name}: engine.layout.bank_deg has {len(banks)} angle{'s' * (len(banks) != 1)}"
            f" for the {parts.rods} rod{'s' * (parts.rods != 1)} on throw {throw.number}; expected one each"
        )
    length = engine.rod_length_mm or LONG_ROD * throw.crank_radius_mm
    small_end_g, couple = bare_rod(engine.rod, length)
    first = float(throw.crankpin.centre_mm[2]) - 0.5 * layout.rod_pitch_mm * (parts.rods - 1)
    return [
        Cylinder(
            SliderCrank(throw.crank_radius_mm, length, layout.offset_mm),
            total_g(parts.weights.rotating),
            total_g(parts.weights.reciprocating),
            throw_angle_rad=throw.angle_rad,
            bank_rad=bank,
            z_mm=first + number * layout.rod_pitch_mm,
            small_end_g=small_end_g,
            couple_inertia_g_mm2=couple,
        )
        for number, bank in enumerate(banks)
    ]


def in_its_sense(job: Job, engine: Engine) -> Engine:
    """Return an engine drawn in the rotor's frame as it is computed: clockwise ones as their mirror image."""
    return engine.mirrored() if job.engine.clockwise else engine


def as_measured(job: Job, crank: Crank) -> Engine:
    """Return the engine with its crank as the file has it; the metal loads the mains of its bay."""
    return with_solid(job, crank.anatomy, crank.source.solid, crank.density_g_mm3, crank.moments)


def with_solid(job: Job, anatomy: Anatomy, solid: Solid, density_g_mm3: float, crank: Moments) -> Engine:
    """Return the engine with a solid (file coordinates) for its crank; metal loads the mains of its bay.

    What the crank's moments have besides the solid (slugs pressed in) is shared by the outermost mains.
    """
    beside = beside_the_rods(job, anatomy)
    mains = mains_z_mm(anatomy)
    if len(mains) < 2:
        return with_moments(job, anatomy, crank)
    solid = solid.moved(anatomy.file_to_rotor)
    rest = crank
    pieces: list[CrankUnbalance] = []
    for number, (low, high) in enumerate(itertools.pairwise(mains)):
        bay = solid
        if number < len(mains) - 2:
            bay, solid = solid.below(high), solid.above(high)
        moments = bay.moments(density_g_mm3)
        rest = rest - moments
        for part, z in beside:
            inside = (z > low or number == 0) and (z <= high or number == len(mains) - 2)
            moments = moments + part if inside else moments
        pieces += _at_mains(moments, low, high)
    if abs(rest.mass_g) > ROUNDING * crank.mass_g:
        pieces += _at_mains(rest, mains[0], mains[-1])
    engine = Engine(cylinders(job, anatomy), tuple(pieces), _polar(job, anatomy, crank))
    return in_its_sense(job, engine)


def beside_the_rods(job: Job, anatomy: Anatomy) -> list[tuple[Moments, float]]:
    """Crankpin parts, oil and attached rotors, each with its place on the axis."""
    masses = [(attached_moments((part,)), part.z_mm) for part in job.engine.attached]
    for throw, load in zip(anatomy.throws, throw_loads(anatomy, job.engine), strict=True):
        mass = load.parts.crankpin_g
        masses.append((Moments.point(mass, throw.crankpin.centre_mm), load.z_mm))
        if throw.number in job.engine.oil:
            masses.append((job.engine.oil[throw.number].rest, load.z_mm))
    return masses


def with_moments(job: Job, anatomy: Anatomy, crank: Moments, *, rod_needed: bool = True) -> Engine:
    """Return the engine with a crank known by its moments alone, as two pieces at its ends."""
    moments = sum((part for part, _ in beside_the_rods(job, anatomy)), crank)
    mains = mains_z_mm(anatomy)
    low, high = (mains[0], mains[-1]) if len(mains) > 1 else (0.0, 1.0)
    engine = Engine(
        cylinders(job, anatomy, rod_needed=rod_needed),
        _at_mains(moments, low, high),
        _polar(job, anatomy, crank),
    )
    return in_its_sense(job, engine)


def _at_mains(moments: Moments, low_mm: float, high_mm: float) -> tuple[CrankUnbalance, CrankUnbalance]:
    """Return the unbalance and mass of a piece of the crank as shares at two places beside it."""
    a, b = Unbalance.of(moments).in_planes(low_mm, high_mm)
    at_high = (float(moments.first_g_mm[2]) - low_mm * moments.mass_g) / (high_mm - low_mm)
    return CrankUnbalance(a, low_mm, moments.mass_g - at_high), CrankUnbalance(b, high_mm, at_high)


def _polar(job: Job, anatomy: Anatomy, crank: Moments) -> float:
    beside = beside_the_rods(job, anatomy)
    return crank.polar_inertia_g_mm2 + sum(part.polar_inertia_g_mm2 for part, _ in beside)


def mains_z_mm(anatomy: Anatomy) -> tuple[float, ...]:
    """Return the places of the main bearings on the axis, increasing."""
    return tuple(sorted(float(pin.centre_mm[2]) for pin in anatomy.main_journals))


def balanced_to(engine: Engine, job: Job, anatomy: Anatomy, factor: float) -> Engine:
    """Return the engine with a crank balanced to a factor, each throw by itself."""
    by_throw = [
        CrankUnbalance(
            -(load.parts.bob_weight_g(factor) - load.parts.crankpin_g)
            * load.crank_radius_mm
            * engine.shown(np.array([np.cos(load.angle_rad), np.sin(load.angle_rad)])),
            load.z_mm,
        )
        for load in throw_loads(anatomy, job.engine)
    ]
    return replace(engine, crank=tuple(by_throw))


def balance_shafts(job: Job, reference_mm: float) -> tuple[BalanceShaft, ...]:
    """Return the job's balance shafts; one that does not say its z is where moments are taken about."""
    return tuple(
        BalanceShaft(
            each.order,
            each.forward,
            each.product_g_mm,
            each.phase_rad,
            *each.place_mm,
            reference_mm if each.z_mm is None else each.z_mm,
        )
        for each in job.shafts
    )


def shafts_beside(engine: Engine, job: Job, reference_mm: float) -> tuple[BalanceShaft, ...]:
    """Return the job's balance shafts beside an engine as it is computed: mirrored where that is."""
    shafts = balance_shafts(job, reference_mm)
    return tuple(each.mirrored() for each in shafts) if engine.clockwise else shafts


def shaking(job: Job, anatomy: Anatomy, crank: Moments) -> ShakingForce | None:
    """Return the shaking force of the job's engine at its top speed with a crank of those moments.

    None where several rods share a throw and the job does not say where their cylinders are. Without a
    rod length only the first order is right, and there are no others.

    Raises
    ------
    JobError
        If the directions given do not fit the rods, or a rod is too short.
    """
    numbers = [throw.number for throw in anatomy.throws]
    if any(
        job.engine.layout.banks_of(number) is None
        and job.engine.of_throw(number).rods > 1
        and not job.engine.of_throw(number).links
        for number in numbers
    ):
        return None
    engine = with_moments(job, anatomy, crank, rod_needed=False)
    force = shaking_force(engine, job.balance.service_speed_rad_s)
    return force.first_order() if job.engine.rod_length_mm is None else force


def moment_reference_mm(anatomy: Anatomy, chosen_mm: float | None = None) -> float:
    """Return the place on the axis that moments are taken about: a chosen one, else the middle of the mains.

    With fewer than two main journals, the middle of the crankpins.
    """
    if chosen_mm is not None:
        return chosen_mm
    low, high = shaft_ends_mm(anatomy)
    return 0.5 * (low + high)


def shaft_ends_mm(anatomy: Anatomy) -> tuple[float, float]:
    """Return z of the outermost main journals, or with fewer than two, of the ends of the crankpins."""
    mains = mains_z_mm(anatomy)
    if len(mains) > 1:
        return mains[0], mains[-1]
    ends = [end for throw in anatomy.throws for end in throw.crankpin.z_range_mm]
    return min(ends), max(ends)
