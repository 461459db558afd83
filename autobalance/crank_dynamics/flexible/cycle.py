"""The cycle of a crank that bends and twists: main loads, journal orbits and web moments."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from autobalance.balancing.engine_from_job import beside_the_rods, mains_z_mm
from autobalance.balancing.measured import Crank
from autobalance.crank.anatomy import Anatomy, Pin
from autobalance.crank.sections import SHOULDER_MARGIN_RATIO, away_from_crankpin
from autobalance.crank_dynamics.flexible.crank_in_films import (
    BeamPiece,
    CrankOnSprings,
    JournalFilms,
    journal_paths,
    taken_n,
)
from autobalance.crank_dynamics.rotor.from_crank import E_GPA, NU, throw_bending
from autobalance.crank_dynamics.torsion.chain import ThrowShape
from autobalance.crank_dynamics.torsion.from_job import crank_chain, throw_shapes, webs_beside
from autobalance.crank_dynamics.torsion.input import crank_torsion
from autobalance.crank_dynamics.torsion.model import CrankTorsion, named_train
from autobalance.crank_dynamics.torsion.train import train_response
from autobalance.engines.bearings.orbit import short_film_unit_n
from autobalance.engines.cycle.analysis import CycleAnalysis, torque_orders, torques_on_throws
from autobalance.engines.cycle.films import FILM_ANGLE_STRIDE, main_bearings
from autobalance.engines.cycle.firing_engine import as_complex
from autobalance.engines.cycle.model import OilFilms
from autobalance.job import Job
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array, Complex
from autobalance.units import M_PER_MM, MPA_PER_GPA, N_M_PER_N_MM, N_PER_G_MM_S2
from autobalance.value_classes import dataclass

# The cycle of a crank that bends: main loads, journal orbits and web moments on springs.


SAME_MM = 1e-6
JOURNAL_SIDES = 64


@dataclass(frozen=True, eq=False)
class WebMoment:
    """Bending moment in a throw's plane in the middle of a web (n,) [N·m]."""

    throw: int
    web: int
    bending_n_m: Array


@dataclass(frozen=True, eq=False)
class FlexibleCycle:
    """Bending of the crank over the cycle.

    Attributes
    ----------
    stiffness_n_mm : tuple of float or None
        Of each main's spring; None: the mains run in films.
    main_n : (m, n) complex
        Loads of the crank on its mains, engine's frame, x + iy [N].
    orbit_mm : (m, n) complex
        Where the journals are, engine's frame [mm].
    webs : tuple of WebMoment
    rigid_difference : float
        Largest difference to a main load of the rigid crank, over the largest of these.
    clearance_mm : (m,) float or None
        Of films, radial.
    is_periodic : bool
        Whether the paths in films repeat.
    """

    stiffness_n_mm: tuple[float, ...] | None
    main_n: Complex
    orbit_mm: Complex
    webs: tuple[WebMoment, ...]
    rigid_difference: float
    clearance_mm: Array | None = None
    is_periodic: bool = True


def flexible_cycle(
    cycle: CycleAnalysis,
    job: Job,
    crank: Crank,
    mains_on: tuple[float, ...] | OilFilms,
    stiffer: float = 1.0,
    counterweights: bool = True,
) -> FlexibleCycle:
    """Return the cycle of a crank that bends on springs or in films.

    Parameters
    ----------
    cycle : CycleAnalysis
        Of the same crank, rigid.
    job : Job
    crank : Crank
    mains_on : tuple of float, or OilFilms
        Stiffness of each main [N/mm], or the films that the mains run in.
    stiffer : float
        Times which the crank is as stiff as it is.
    counterweights : bool
        Whether the metal of the counterweights turns with the crank; its stiffness is the same.
    """
    anatomy = crank.anatomy
    back = np.exp(-1j * cycle.grid.angle_rad)
    solid = crank.source.solid.moved(anatomy.file_to_rotor)
    webs = [(throw, web) for throw in anatomy.throws for web in webs_beside(anatomy, throw)]
    nodes, forces = _forces(cycle, job, crank, solid if counterweights else _without(solid, anatomy))
    beam = _stretches(cycle, anatomy, throw_shapes(crank), nodes, stiffer)
    at_mains = [int(np.argmin(np.abs(nodes - z))) for z in mains_z_mm(anatomy)]
    clearance, periodic = None, True
    if isinstance(mains_on, OilFilms):
        free = CrankOnSprings(beam, np.zeros(len(nodes)))
        on_films, orbit, periodic = _in_films(cycle, anatomy, mains_on, free, forces, at_mains)
        loads, moved, clearance = on_films * back, orbit * back, main_bearings(anatomy, mains_on).clearance_mm
    else:
        springs = np.zeros(len(nodes))
        springs[at_mains] = mains_on
        moved = CrankOnSprings(beam, springs).deflections_mm(forces)[at_mains]
        loads = np.array(mains_on)[:, None] * moved
    left = forces.copy()
    left[at_mains] -= loads
    rigid = as_complex(cycle.loads.main_n)
    moments = []
    for throw, web in webs:
        z = 0.5 * (web.z_min_mm + web.z_max_mm)
        arms = np.maximum(z - nodes, 0.0)
        turned = np.exp(-1j * cycle.firing.throws[throw.number - 1].angle_rad)
        moments.append(WebMoment(throw.number, web.number, N_M_PER_N_MM * (turned * (arms @ left)).real))
    return FlexibleCycle(
        None if isinstance(mains_on, OilFilms) else mains_on,
        loads / back,
        moved / back,
        tuple(moments),
        float(np.abs(loads / back - rigid).max() / np.abs(rigid).max()),
        clearance,
        periodic,
    )


def _forces(cycle: CycleAnalysis, job: Job, crank: Crank, solid: Solid) -> tuple[Array, Complex]:
    """Return the beam's nodes [mm], and the loads on them (nodes, n) as the crank sees them [N]."""
    anatomy, back = crank.anatomy, np.exp(-1j * cycle.grid.angle_rad)
    webs = [web for throw in anatomy.throws for web in webs_beside(anatomy, throw)]
    gravity = cycle.firing.gravity
    fall = 0j if gravity is None else _seen(job, _vector(gravity.fall_mm_s2)) * N_PER_G_MM_S2
    places = [
        *(float(z) for z in solid.bounds[:, 2]),
        *mains_z_mm(anatomy),
        *(0.5 * (web.z_min_mm + web.z_max_mm) for web in webs),
        *(cylinder.z_mm for cylinder in cycle.firing.engine.cylinders),
        *(z for _, z in beside_the_rods(job, anatomy)),
        *([] if gravity is None else [z for _, z in gravity.parts]),
        *(drive.z_mm for drive in cycle.firing.drives),
    ]
    nodes = np.unique(np.round(np.array(places) / SAME_MM) * SAME_MM)
    node = {place: int(np.argmin(np.abs(nodes - place))) for place in places}
    forces = np.zeros((len(nodes), back.size), dtype=np.complex128)
    pull = cycle.speed_rad_s**2 * N_PER_G_MM_S2
    for place in range(len(nodes) - 1):
        piece = solid.above(nodes[place]).below(nodes[place + 1])
        moments = piece.moments(crank.density_g_mm3)
        ends = Unbalance.of(moments).in_planes(nodes[place], nodes[place + 1])
        later = (float(moments.first_g_mm[2]) - nodes[place] * moments.mass_g) / (
            nodes[place + 1] - nodes[place]
        )
        masses = moments.mass_g - later, later
        for at, vector, mass in zip((place, place + 1), ends, masses, strict=True):
            forces[at] += pull * _seen(job, vector)
            if fall:
                forces[at] += mass * fall * back
    for part, z in beside_the_rods(job, anatomy):
        forces[node[z]] += pull * _seen(job, Unbalance.of(part).resultant_g_mm)
        if fall:
            forces[node[z]] += part.mass_g * fall * back
    for mass, z in () if gravity is None else gravity.parts:
        forces[node[z]] += mass * fall * back
    pulls = cycle.firing.parts.pulls
    for drive, pulled in zip(cycle.firing.drives, () if pulls is None else pulls.pull_n, strict=True):
        forces[node[drive.z_mm]] += pulled * back
    for cylinder, load in zip(cycle.firing.engine.cylinders, cycle.loads.crankpin_n, strict=True):
        forces[node[cylinder.z_mm]] += as_complex(load) * back
    return nodes, forces


def _without(solid: Solid, anatomy: Anatomy) -> Solid:
    """Return a crank without its counterweights: the webs' metal beyond the axis, away from the crankpins.

    A counterweight that is thicker than its web is around a journal, which stays.
    """
    far = 2.0 * float(np.abs(solid.bounds[:, :2]).max())
    journals = union([_around(journal) for journal in anatomy.main_journals])
    for web in anatomy.webs:
        if web.counterweight:
            away = away_from_crankpin(web, anatomy)
            along = np.array([-away[1], away[0]])
            corners = [far * along, -far * along, far * (away - along), far * (away + along)]
            half = Solid.prism(Region.of([np.array(corners)]), web.z_min_mm, web.z_max_mm)
            solid = solid - (half - journals)
    return solid


def _around(journal: Pin) -> Solid:
    radius, (x, y) = 0.5 * (1.0 + SHOULDER_MARGIN_RATIO) * journal.diameter_mm, journal.centre_mm[:2]
    return Solid.prism(Region.circle(radius, JOURNAL_SIDES, (float(x), float(y))), *journal.z_range_mm)


def _in_films(
    cycle: CycleAnalysis,
    anatomy: Anatomy,
    film: OilFilms,
    beam: CrankOnSprings,
    forces_n: Complex,
    at_mains: list[int],
) -> tuple[Complex, Complex, bool]:
    """Return loads [N] and places [mm] of the journals (m, n), engine's frame, and whether they repeat.

    Paths are worked out at even angles and straight between them.
    """
    grid, bearings = cycle.grid, main_bearings(anatomy, film)
    count = grid.even_rad.size
    held, stiffness = beam.held(forces_n, at_mains)
    sizes_mm = (0.5 * bearings.diameter_mm, bearings.length_mm, bearings.clearance_mm)
    unit = short_film_unit_n(film.viscosity_pa_s, cycle.speed_rad_s, *(M_PER_MM * each for each in sizes_mm))
    films = JournalFilms(bearings.clearance_mm, unit)
    every = FILM_ANGLE_STRIDE
    paths = journal_paths(grid.even_rad[::every], held[:, :count:every], stiffness, films)
    ends = np.append(grid.even_rad[::every], grid.span_rad)
    ratio = np.concatenate([paths.ratio, paths.ratio[:, :1]], axis=1)
    place = np.stack([np.interp(grid.angle_rad % grid.span_rad, ends, each) for each in ratio])
    orbit: Complex = (place * bearings.clearance_mm[:, None]).astype(np.complex128)
    back = np.exp(-1j * grid.angle_rad)
    loads: Complex = (held - taken_n(stiffness, orbit * back)) / back
    return loads, orbit, paths.is_periodic


def _vector(value: complex) -> Array:
    return np.array([value.real, value.imag])


def _seen(job: Job, vector_g_mm: Array) -> complex:
    """Return a vector of the rotor's frame as the engine's model has it: mirrored, where clockwise."""
    vector = complex(*vector_g_mm)
    return vector.conjugate() if job.engine.clockwise else vector


def _stretches(
    cycle: CycleAnalysis, anatomy: Anatomy, shapes: tuple[ThrowShape, ...], nodes: Array, stiffer: float
) -> list[BeamPiece]:
    """Return the beam: of the nearest throw between the outermost mains, beyond them of a journal."""
    youngs = E_GPA * MPA_PER_GPA
    bendings = [throw_bending(shape, youngs, youngs / (2.0 * (1.0 + NU))) for shape in shapes]
    pins = np.array([throw.crankpin.centre_mm[2] for throw in anatomy.throws])
    mains = mains_z_mm(anatomy)
    stretches = []
    for low, high in pairwise(nodes):
        middle = 0.5 * float(low + high)
        nearest = int(np.argmin(np.abs(pins - middle)))
        length = float(high - low)
        if mains[0] < middle < mains[-1]:
            bending, angle = bendings[nearest], cycle.firing.throws[nearest].angle_rad
            both = bending.in_plane_n_mm2, bending.across_n_mm2
            stretches.append(BeamPiece(length, stiffer * both[0], stiffer * both[1], angle))
        else:
            shape = shapes[nearest]
            round_bar = math.pi / 64.0 * (shape.journal_mm**4 - shape.journal_bore_mm**4) * youngs
            stretches.append(BeamPiece(length, stiffer * round_bar, stiffer * round_bar))
    return stretches


# Twist of a crank over its cycle: the chain of `torsion` under the torques of the cycle's throws.


@dataclass(frozen=True, eq=False)
class ShaftTwist:
    """Twist (n,) [rad] and torque (n,) [N·m] between two stations next to each other, at even angles."""

    first: str
    second: str
    twist_rad: Array
    torque_n_m: Array


def shaft_twists(
    cycle: CycleAnalysis, job: Job, crank: Crank, stiffer: float = 1.0
) -> tuple[ShaftTwist, ...] | None:
    """Return the twist of the crank from its first main to its last; None if gears or branches are attached.

    Orders up to the 12th swing by the chain's inertias; the mean torque goes out behind the last throw.
    ``stiffer``: times which the springs are as stiff as they are.
    """
    torsion = job.table(CrankTorsion) or crank_torsion(job.raw)
    question = torsion.question
    if not question.parts.plain:
        return None
    bare = crank_chain(job, crank, torsion)
    chain = replace(bare.chain, springs_n_m_rad=stiffer * bare.chain.springs_n_m_rad)
    train = named_train(chain, bare.names, bare.diameters_m, question.parts).train
    radii = [throw.crank_radius_mm for throw in crank.anatomy.throws]
    torques = torques_on_throws(cycle.firing, cycle.loads.crankpin_n, radii)
    orders = torque_orders(cycle.firing.strokes)
    at = np.zeros((len(orders), len(bare.names)), dtype=np.complex128)
    mean = np.zeros(len(bare.names))
    for station, torque in zip(bare.throw_stations, torques, strict=True):
        at[:, station] = cycle.grid.harmonics(torque, orders)
        mean[station] = float(cycle.grid.mean(torque))
    angles = train_response(
        train, orders * cycle.speed_rad_s, at, question.ratio_of_modes(train.damped)
    ).angles_rad
    turned = np.exp(1j * np.outer(orders, cycle.grid.even_rad))
    twists = []
    low, high = max(bare.throw_stations[0] - 1, 0), bare.throw_stations[-1] + 1
    for link in range(low, min(high, len(bare.names) - 1)):
        spring = float(chain.springs_n_m_rad[link])
        swing = ((angles[:, link] - angles[:, link + 1])[:, None] * turned).real.sum(axis=0)
        twist = swing + float(mean[: link + 1].sum()) / spring
        twists.append(ShaftTwist(bare.names[link], bare.names[link + 1], twist, spring * twist))
    return tuple(twists)
