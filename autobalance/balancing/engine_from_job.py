"""A job and its crank become an engine: cylinders on throws, linked rods, oil, pressed-in crankpins."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from itertools import pairwise
from weakref import WeakKeyDictionary

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.balancing.rotor_from_job import attached_moments, rod_weights_g, throw_loads, total_g
from autobalance.crank.anatomy import Anatomy, Throw, Web
from autobalance.crank.sections import OilRoom, oil_rooms
from autobalance.errors import JobError
from autobalance.job import Job, RodOnScales
from autobalance.job.model import ThrowOil
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.running_gear.articulated import LinkCrank
from autobalance.running_gear.conrod import ConnectingRod
from autobalance.running_gear.roll import ShakingForce, shaking_force
from autobalance.running_gear.shafts import BalanceShaft
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import CrankUnbalance, Cylinder, Engine
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array

# Throws with a master rod and link rods become cylinders.


LONG_ROD = 1e3
"""Rod ÷ crank radius where the job gives no rod length; only the first order is used then, which is free
of it."""


def articulated(job: Job, throw: Throw, before: int) -> list[Cylinder]:
    """Return the cylinders of a throw with link rods, by number; none where each rod has its own big end.

    ``before`` is how many cylinders other throws have before it.

    Raises
    ------
    JobError
        If a link's cylinder is not one of the throw's, or the master's direction is not one angle.
    """
    engine = job.engine
    parts = engine.of_throw(throw.number)
    if not parts.links:
        return []
    numbers = list(range(before + 1, before + parts.rods + 1))
    by_number = {link.cylinder: link for link in parts.links}
    for number in by_number:
        if number not in numbers:
            raise JobError(
                f"{job.path.name}: engine.throw number {throw.number}: link.cylinder is {number}; expected"
                f" one of its cylinders, {numbers[0]} to {numbers[-1]}"
            )
    master_number = next(number for number in numbers if number not in by_number)
    banks = engine.layout.banks_of(throw.number) or (0.0,)
    if len(banks) != 1:
        raise JobError(
            f"{job.path.name}: bank_deg of throw {throw.number} has {len(banks)} angles; expected one, the"
            " master's: set bank_deg of link rods in their own tables"
        )
    radius, z = throw.crank_radius_mm, float(throw.crankpin.centre_mm[2])
    length = engine.rod_length_mm or LONG_ROD * radius
    small_end_g, couple = bare_rod(engine.rod, length)
    rotating, reciprocating = total_g(parts.weights.rotating), total_g(parts.weights.reciprocating)
    master = SliderCrank(radius, length, engine.layout.offset_mm)
    cylinders = []
    for number in numbers:
        link = by_number.get(number)
        if link is None:
            cylinders.append(
                Cylinder(master, rotating, reciprocating, throw.angle_rad, banks[0], z, small_end_g, couple)
            )
            continue
        train = LinkCrank(
            radius,
            link.rod_length_mm,
            engine.layout.offset_mm,
            master,
            banks[0] - link.bank_rad,
            link.knuckle_radius_mm,
            link.knuckle_rad,
        )
        turning, moving = rod_weights_g(link, rotating, reciprocating)
        cylinders.append(
            Cylinder(train, turning, moving, throw.angle_rad, link.bank_rad, z, master=master_number - 1)
        )
    return cylinders


def bare_rod(rod: RodOnScales | None, length_mm: float) -> tuple[float, float]:
    """Return a bare rod's mass at its small end and the inertia that two masses miss; 0 where not weighed."""
    if rod is None:
        return 0.0, 0.0
    two_masses = ConnectingRod.from_two_scales(rod.big_end_g, rod.small_end_g, length_mm, rod.inertia_g_mm2)
    return two_masses.small_end_g, two_masses.couple_inertia_g_mm2


# A job and its crank become an engine: cylinders on throws, and the crank's unbalance bay by bay.


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


# Crankpins put into a pressed-up crank whose file leaves them out.


PIN_SEGMENTS = 96
PIN_OVERLAP_SHARE = 1e-4
"""Share by which the flats of a crankpin that is put in lie outside its bore, and its ends outside its webs.
No sliver is left between them, nor where two planes coincide except for rounding."""
BEYOND, BEHIND = 1.15, 0.1
"""Height and half width, over the crankpin's radius, of the region behind a crankpin in which a web is
sought."""


def with_crankpins(solid: Solid, crank: Crank) -> Solid:
    """Return a crank's solid (rotor frame) with the crankpins that its file leaves out, through both webs.

    The crankpins are of the crank's own metal, solid, and one piece with the webs that they are pressed into.

    Parameters
    ----------
    solid : Solid
        The crank's, or one with other counterweights [mm].
    crank : Crank
        As its file was measured.

    Raises
    ------
    JobError
        If a crankpin that is missing has no webs on both sides.
    """
    if crank.holds_crankpins:
        return solid
    for throw in crank.anatomy.throws:
        pin = throw.crankpin
        z = float(pin.centre_mm[2])
        webs = _beside(crank.anatomy, z)
        radius = 0.5 * pin.diameter_mm * (1.0 + PIN_OVERLAP_SHARE) / math.cos(math.pi / PIN_SEGMENTS)
        place = (float(pin.centre_mm[0]), float(pin.centre_mm[1]))
        outside = throw.direction * (throw.crank_radius_mm + BEYOND * radius)
        low = _metal_mm(solid, webs[0], outside, BEHIND * radius)[0]
        high = _metal_mm(solid, webs[1], outside, BEHIND * radius)[1]
        proud = PIN_OVERLAP_SHARE * pin.diameter_mm
        solid = solid + Solid.prism(Region.circle(radius, PIN_SEGMENTS, place), low - proud, high + proud)
    return solid


def _metal_mm(solid: Solid, web: Web, place: Array, radius: float) -> tuple[float, float]:
    """Return begin and end of a web's metal behind its crankpin; its counterweight may be thicker."""
    circle = Region.circle(radius, 16, (float(place[0]), float(place[1])))
    metal = Solid.prism(circle, web.z_min_mm, web.z_max_mm) & solid
    if metal.is_empty:
        raise JobError(f"web {web.number} has no metal behind its crankpin")
    low, high = (float(z) for z in metal.bounds[:, 2])
    return low, high


def _beside(anatomy: Anatomy, z_mm: float) -> tuple[Web, Web]:
    below = [web for web in anatomy.webs if 0.5 * (web.z_min_mm + web.z_max_mm) < z_mm]
    above = [web for web in anatomy.webs if 0.5 * (web.z_min_mm + web.z_max_mm) > z_mm]
    if not (below and above):
        raise JobError("a crankpin that is not in the file needs a web on both sides")
    return below[-1], above[0]


# The oil in a job's crank, by throw: what counts in its bob-weights, and what no bob-weight stands for.


_ROOMS: WeakKeyDictionary[Anatomy, tuple[Solid, tuple[OilRoom, ...]]] = WeakKeyDictionary()
"""Rooms of cranks in use: loads, weights and tables ask for them in turn, and they take long to find."""


def rooms_of(crank: Crank) -> tuple[OilRoom, ...]:
    """Return the oil volumes in a crank, its crankpins put in if they are not in the file."""
    solid, anatomy = crank.source.solid, crank.anatomy
    known = _ROOMS.get(anatomy)
    if known is None or known[0] is not solid:
        whole = with_crankpins(solid.moved(anatomy.file_to_rotor), crank)
        known = _ROOMS[anatomy] = solid, oil_rooms(whole, anatomy)
    return known[1]


def with_oil(job: Job, crank: Crank) -> Job:
    """Return a job with the oil that its crank holds, by throw, where ``[engine.oil]`` fills it."""
    density = job.engine.oil_g_mm3
    if density is None:
        return job
    rooms, anatomy = rooms_of(crank), crank.anatomy
    planes = _between_throws_mm(anatomy)
    by_throw = {}
    for throw, low, high in zip(anatomy.throws, (None, *planes), (*planes, None), strict=True):
        oil = Moments.zero()
        for room in rooms:
            piece = room.solid if low is None else room.solid.above(low)
            oil = oil + (piece if high is None else piece.below(high)).moments(density)
        if oil.mass_g > 0.0:
            by_throw[throw.number] = throw_oil(oil, throw)
    return replace(job, engine=replace(job.engine, oil=by_throw))


def throw_oil(oil: Moments, throw: Throw) -> ThrowOil:
    """Return a throw's oil as a mass in its crankpin with the same pull along the throw, and the rest."""
    along = float(oil.first_g_mm[:2] @ throw.direction) / throw.crank_radius_mm
    on_crankpin = max(0.0, along)  # more oil on the counterweight's side is not a bob-weight
    return ThrowOil(oil, on_crankpin, oil - Moments.point(on_crankpin, throw.crankpin.centre_mm))


def _between_throws_mm(anatomy: Anatomy) -> tuple[float, ...]:
    """Return z between neighbouring throws' oil: in the middle of the main journal, else halfway [mm]."""
    mains = [float(journal.centre_mm[2]) for journal in anatomy.main_journals]
    pins = [float(throw.crankpin.centre_mm[2]) for throw in anatomy.throws]
    return tuple(
        next((z for z in mains if low < z < high), float(np.mean([low, high])))
        for low, high in pairwise(pins)
    )
