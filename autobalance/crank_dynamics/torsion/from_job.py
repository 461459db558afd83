"""Torsional chain of a job and its measured crank: inertias of its metal, springs of its throws."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, replace

import numpy as np

from autobalance.balancing.engine_from_job import articulated
from autobalance.balancing.measured import Crank
from autobalance.balancing.rotor_from_job import total_g
from autobalance.crank.anatomy import Anatomy, MainJournal, Pin, Throw, Web
from autobalance.crank.sections import Section, sections
from autobalance.crank_dynamics.torsion.chain import (
    ThrowShape,
    TorsionChain,
    springs_between,
    throw_stiffness_n_m_rad,
)
from autobalance.crank_dynamics.torsion.model import CrankTorsion
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.running_gear.loads import variable_inertia_g_mm2, whole_turn
from autobalance.running_gear.whole_engine import Cylinder
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.units import KG_M2_PER_G_MM2, M_PER_MM
from autobalance.value_classes import dataclass

ANGLES = 720
LEAST_BORE = 0.15
"""Share of a diameter below which what a section lacks is facets or an oil hole, not a bore."""
CORE = 0.2
"""Half the breadth of the strip on which a web's thickness is measured, over the crank radius."""
CELLS = (5, 3)
"""Points of that strip, along and across; the median of their thicknesses counts."""
BESIDE_PINS = 1.15
"""Over the radius of a pin: beyond its fillet."""
INSIDE_EDGE = 0.01
"""Over the crank radius: a web's edge is drafted or broken."""
LEAST_BESIDE = 0.01
"""Share of a web's arm beside its pins' fillets, at least, for its thickness to be taken there."""
MIN_SHOULDER_RATIO = 1.1
"""Ratio of the metal next to the pins to that between them above which a counterweight's shoulder is on it:
webs of the drafted bundled crank came out at 17.7 mm for 11."""


@dataclass(frozen=True, eq=False)
class CrankChain:
    """A crank's chain with both formulas' springs (n − 1,) beside each other.

    ``names`` are those of the stations; ``throw_stations`` are the throws' stations, from 0. ``diameters_m``
    are the smaller of journal and crankpin along each spring. ``shapes`` are the throws' dimensions, the mean
    of both sides; ``throws_n_m_rad`` are their stiffness by each formula.
    """

    chain: TorsionChain
    names: tuple[str, ...]
    throw_stations: tuple[int, ...]
    ker_wilson_n_m_rad: Array
    carter_n_m_rad: Array
    diameters_m: tuple[float | None, ...]
    shapes: tuple[ThrowShape, ...]
    throws_n_m_rad: Mapping[str, tuple[float, ...]]
    _stations: _Stations
    _asked: CrankTorsion

    @property
    def crank_links(self) -> tuple[int, ...]:
        """Return the chain's springs that are the crank's own metal, from 0."""
        first = len(self._asked.front)
        return tuple(range(first, first + len(self._stations.names) - 1))

    def with_throws(self, throws_n_m_rad: Sequence[float]) -> TorsionChain:
        """Return the chain with other stiffnesses of the throws."""
        springs = _with_shafts(self._stations.springs(list(throws_n_m_rad)), self._asked)
        return replace(self.chain, springs_n_m_rad=springs)


def crank_chain(job: Job, crank: Crank, model: CrankTorsion) -> CrankChain:
    """Return the torsional chain of a job's crank.

    Raises
    ------
    JobError
        If the crank has no journal beside its throws, or a throw that a formula does not hold for.
    """
    anatomy = crank.anatomy
    stations = _Stations.of(anatomy)
    pairs = sides_of_throws(crank)
    throws = {
        name: tuple(_stiffness(name, number, pair, model) for number, pair in enumerate(pairs, 1))
        for name in ("ker_wilson", "carter")
    }
    formulas = {name: _with_shafts(stations.springs(list(each)), model) for name, each in throws.items()}
    inertias = _inertias(job, crank, stations)
    inertias[0] += model.damper_kg_m2
    inertias[-1] += model.flywheel_kg_m2
    damping = np.zeros(len(inertias))
    for throw, station in zip(anatomy.throws, stations.of_throws, strict=True):
        damping[station] += model.cylinder_damping_n_m_s * job.engine.of_throw(throw.number).rods
    front, train = model.front[::-1], model.train
    chain = TorsionChain(
        _between([each.inertia_kg_m2 for each in front], inertias, [each.inertia_kg_m2 for each in train]),
        formulas[model.formula],
        _between([each.damping_n_m_s for each in front], damping, [each.damping_n_m_s for each in train]),
        _between(
            [each.shaft_damping_n_m_s for each in front],
            np.zeros(len(inertias) - 1),
            [each.shaft_damping_n_m_s for each in train],
        ),
    )
    outer = [tuple(each.diameter_m for each in side) for side in (front, train)]
    return CrankChain(
        chain,
        (*(each.name for each in front), *stations.names, *(each.name for each in train)),
        tuple(station + len(front) for station in stations.of_throws),
        formulas["ker_wilson"],
        formulas["carter"],
        (*outer[0], *stations.diameters_m(pairs), *outer[1]),
        tuple(_mean(*pair) for pair in pairs),
        throws,
        stations,
        model,
    )


def _with_shafts(springs: Array, model: CrankTorsion) -> Array:
    """Return the springs of the crank with those of what is driven on both its ends."""
    front, train = ([each.shaft_n_m_rad for each in side] for side in (model.front[::-1], model.train))
    return _between(front, springs, train)


def _between(front: Sequence[float], middle: Array, behind: Sequence[float]) -> Array:
    whole: Array = np.concatenate(
        [np.asarray(front, dtype=np.float64), middle, np.asarray(behind, dtype=np.float64)]
    )
    return whole


def throw_shapes(crank: Crank) -> tuple[ThrowShape, ...]:
    """Return the dimensions of a crank's throws, the mean of both sides, measured on its solid.

    Raises
    ------
    JobError
        If a throw has no web on a side.
    """
    return tuple(_mean(*pair) for pair in sides_of_throws(crank))


def sides_of_throws(crank: Crank) -> list[tuple[ThrowShape, ThrowShape]]:
    """Return the dimensions of each throw as its lower side has them, and as its upper side has them."""
    solid = crank.source.solid.moved(crank.anatomy.file_to_rotor)
    return [_shapes(solid, crank.anatomy, throw) for throw in crank.anatomy.throws]


@dataclass(frozen=True)
class _Stations:
    """First main, throws, last main; a main that is missing has no station."""

    throws: tuple[Throw, ...]
    first: MainJournal | None
    last: MainJournal | None

    @classmethod
    def of(cls, anatomy: Anatomy) -> _Stations:
        throws = anatomy.throws
        before = [m for m in anatomy.main_journals if m.centre_mm[2] < throws[0].crankpin.centre_mm[2]]
        after = [m for m in anatomy.main_journals if m.centre_mm[2] > throws[-1].crankpin.centre_mm[2]]
        stations = cls(throws, before[0] if before else None, after[-1] if after else None)
        if stations.first is None and stations.last is None:
            raise JobError("torsion needs a main journal beside the throws; none was found")
        return stations

    @property
    def names(self) -> tuple[str, ...]:
        mains = [f"main {m.number}" if m else None for m in (self.first, self.last)]
        throws = [f"throw {throw.number}" for throw in self.throws]
        return tuple(name for name in (mains[0], *throws, mains[1]) if name is not None)

    @property
    def z_mm(self) -> tuple[float, ...]:
        pins: list[Pin | None] = [self.first, *(throw.crankpin for throw in self.throws), self.last]
        return tuple(float(pin.centre_mm[2]) for pin in pins if pin is not None)

    @property
    def of_throws(self) -> tuple[int, ...]:
        start = 0 if self.first is None else 1
        return tuple(range(start, start + len(self.throws)))

    def springs(self, throws_n_m_rad: list[float]) -> Array:
        """Return the springs between the stations there are."""
        return self._there(springs_between(throws_n_m_rad))

    def diameters_m(self, pairs: list[tuple[ThrowShape, ThrowShape]]) -> tuple[float, ...]:
        """Return the smaller of journal and crankpin along each spring."""
        smallest = [min(side.journal_mm for side in pair) for pair in pairs]
        smallest = [min(size, pair[0].pin_mm) for size, pair in zip(smallest, pairs, strict=True)]
        between = [min(a, b) for a, b in zip([math.inf, *smallest], [*smallest, math.inf], strict=True)]
        return tuple(float(each) for each in M_PER_MM * self._there(np.array(between)))

    def _there(self, values: Array) -> Array:
        return values[(0 if self.first else 1) : (len(values) if self.last else len(values) - 1)]


# --- springs ------------------------------------------------------------------------------------------------


def _stiffness(formula: str, number: int, sides: tuple[ThrowShape, ThrowShape], model: CrankTorsion) -> float:
    """Return a throw's stiffness; its two halves may have different journals and webs."""
    lengths = [
        each.ker_wilson_per_mm3() if formula == "ker_wilson" else each.carter_per_mm3() for each in sides
    ]
    try:
        return throw_stiffness_n_m_rad(0.5 * sum(lengths), model.shear_modulus_mpa)
    except ValueError as error:
        raise JobError(f"throw {number}: {error} ({formula})") from None


def _shapes(solid: Solid, anatomy: Anatomy, throw: Throw) -> tuple[ThrowShape, ThrowShape]:
    """Return the dimensions of a throw as its lower side has them, and as its upper side has them."""
    webs = webs_beside(anatomy, throw)
    pin = throw.crankpin
    bore = _bore_mm(solid, pin)
    sides = []
    for web, above in zip(webs, (False, True), strict=True):
        journal = journal_beside(anatomy, throw, above)
        sides.append(
            ThrowShape(
                pin.diameter_mm if journal is None else journal.diameter_mm,
                0.0 if journal is None else _bore_mm(solid, journal),
                0.0 if journal is None else _between_webs_mm(anatomy, journal),
                pin.diameter_mm,
                bore,
                _between_webs_mm(anatomy, pin),
                throw.crank_radius_mm,
                *_web_mm(solid, web, throw, journal),
            )
        )
    lone = [journal_beside(anatomy, throw, above) is None for above in (False, True)]
    if lone[0] != lone[1]:  # at the end of a crank: the other side's journal is as good a measure
        good = sides[1] if lone[0] else sides[0]
        keep = {"web_thickness_mm", "web_breadth_mm"}
        at = 0 if lone[0] else 1
        sides[at] = replace(good, **{name: getattr(sides[at], name) for name in keep})
    return sides[0], sides[1]


def _mean(one: ThrowShape, other: ThrowShape) -> ThrowShape:
    """Return the mean of both sides of a throw, for people."""
    return ThrowShape(*(0.5 * (a + b) for a, b in zip(astuple(one), astuple(other), strict=True)))


def webs_beside(anatomy: Anatomy, throw: Throw) -> tuple[Web, Web]:
    """Return the webs on both sides of a throw's crankpin."""
    z = float(throw.crankpin.centre_mm[2])
    below = [web for web in anatomy.webs if 0.5 * (web.z_min_mm + web.z_max_mm) < z]
    above = [web for web in anatomy.webs if 0.5 * (web.z_min_mm + web.z_max_mm) > z]
    if not below or not above:
        raise JobError(f"throw {throw.number} has no web on one side; its stiffness and strength need both")
    return below[-1], above[0]


def journal_beside(anatomy: Anatomy, throw: Throw, above: bool) -> MainJournal | None:
    """Return the main journal next to a throw on one side; None where another throw comes first."""
    z = float(throw.crankpin.centre_mm[2])
    sign = 1.0 if above else -1.0
    away = [(sign * (float(m.centre_mm[2]) - z), m) for m in anatomy.main_journals]
    away = [(d, m) for d, m in away if d > 0.0]
    if not away:
        return None
    distance, journal = min(away, key=lambda each: each[0])
    others = [sign * (float(t.crankpin.centre_mm[2]) - z) for t in anatomy.throws if t is not throw]
    return None if any(0.0 < other < distance for other in others) else journal


def _between_webs_mm(anatomy: Anatomy, pin: Pin) -> float:
    """Return the length between the webs beside a pin, fillets in it; to its end if there is no web."""
    z, (low, high) = float(pin.centre_mm[2]), pin.z_range_mm
    below = max((web.z_max_mm for web in anatomy.webs if web.z_max_mm < z), default=low)
    above = min((web.z_min_mm for web in anatomy.webs if web.z_min_mm > z), default=high)
    return above - below


def _bore_mm(solid: Solid, pin: Pin) -> float:
    """Return the bore of a journal or crankpin from the metal that its section lacks; 0 if it is solid."""
    circle = Region.circle(0.51 * pin.diameter_mm, 256, tuple(float(x) for x in pin.centre_mm[:2]))
    area = (solid.section(float(pin.centre_mm[2])) & circle).area_mm2
    whole = 0.25 * math.pi * pin.diameter_mm**2
    if area < LEAST_BORE * whole:  # the crankpin of a pressed-up crank is not in the file
        return 0.0
    bore = math.sqrt(max(0.0, 4.0 * (whole - area) / math.pi))
    return bore if bore > LEAST_BORE * pin.diameter_mm else 0.0


def _web_mm(solid: Solid, web: Web, throw: Throw, journal: Pin | None) -> tuple[float, float]:
    """Return thickness and breadth of a web's arm, their means between the crank axis and the crankpin's.

    A counterweight may be thicker than the arm; only the arm counts. Its thickness is taken next to the
    fillets: above a journal or crankpin, and in a fillet, metal continues.
    """
    x, y = throw.direction
    radius = throw.crank_radius_mm
    turn = np.eye(4)
    turn[:2, :2] = [[x, -y], [y, x]]
    half = CORE * radius
    low_mm, high_mm = np.array([0.0, -half, web.z_min_mm]), np.array([radius, half, web.z_max_mm])
    core = (solid & Solid.box(low_mm, high_mm).moved(turn)).moved(turn.T)
    thickness = float(np.median([_thickness_mm(core, cell, web) for cell in _cells(radius, half)]))
    if not thickness > 0.0:
        raise JobError(
            f"torsion needs a web next to throw {throw.number}; there is no metal between axis and pin"
        )
    turned = solid.section(float(core.bounds[:, 2].mean())).turned(np.array([[x, y], [-y, x]]))
    low, high = turned.bounds
    between = Region.rectangle((0.0, float(low[1]) - 1.0), (radius, float(high[1]) + 1.0))
    arm = turned & between
    beside = arm - Region.circle(BESIDE_PINS * 0.5 * throw.crankpin.diameter_mm, 64, (radius, 0.0))
    if journal is not None:
        beside = beside - Region.circle(BESIDE_PINS * 0.5 * journal.diameter_mm, 64)
    beside = beside.grown(-INSIDE_EDGE * radius)
    if beside.area_mm2 > LEAST_BESIDE * arm.area_mm2:
        column = Solid.prism(beside, web.z_min_mm, web.z_max_mm)
        of_arm = (solid.moved(turn.T) & column).volume_mm3 / beside.area_mm2
        thickness = of_arm if of_arm < MIN_SHOULDER_RATIO * thickness else thickness
    return thickness, arm.area_mm2 / radius


def _cells(radius_mm: float, half_mm: float) -> list[tuple[Array, Array]]:
    """Return lower and upper corner (2,) of the cells of a web's strip; an oil hole is in a few of them."""
    along, across = np.linspace(0.0, radius_mm, CELLS[0] + 1), np.linspace(-half_mm, half_mm, CELLS[1] + 1)
    return [
        (np.array([along[i], across[j]]), np.array([along[i + 1], across[j + 1]]))
        for i in range(CELLS[0])
        for j in range(CELLS[1])
    ]


def _thickness_mm(core: Solid, cell: tuple[Array, Array], web: Web) -> float:
    box = Solid.box(np.append(cell[0], web.z_min_mm), np.append(cell[1], web.z_max_mm))
    return float((core & box).volume_mm3 / np.prod(cell[1] - cell[0]))


# --- inertias -----------------------------------------------------------------------------------------------


def _inertias(job: Job, crank: Crank, stations: _Stations) -> Array:
    """Return the inertia of each station: the crank's metal, crankpin parts, the rods' share [kg m²]."""
    anatomy = crank.anatomy
    total = np.zeros(len(stations.names))
    for part in sections(crank.source.solid, anatomy, crank.density_g_mm3):
        for station, share in _shares(part, anatomy, stations):
            total[station] += share * part.moments.polar_inertia_g_mm2
    total *= crank.moments.polar_inertia_g_mm2 / total.sum()  # parts of a rounding's size are left out
    before = 0
    for throw, station in zip(anatomy.throws, stations.of_throws, strict=True):
        parts = job.engine.of_throw(throw.number)
        weights, square = parts.weights, throw.crank_radius_mm**2
        total[station] += total_g(weights.crankpin) * square
        if parts.links:
            total[station] += _of_articulated(articulated(job, throw, before))
        else:
            rod_g = total_g(weights.rotating) + 0.5 * total_g(weights.reciprocating)
            total[station] += parts.rods * rod_g * square
        before += parts.rods
    return total * KG_M2_PER_G_MM2


def _of_articulated(cylinders: Sequence[Cylinder]) -> float:
    """Return the inertia of a master rod with its links and pistons, by its mean kinetic energy [g·mm²].

    The links' knuckle pins are off the crankpin's circle, so that m_rot r² + ½ m_rec r² is too little.
    """
    turn = whole_turn(ANGLES)
    return float(
        sum(
            variable_inertia_g_mm2(
                each, each.slider_crank.motion(turn + each.throw_angle_rad - each.bank_rad)
            ).mean()
            for each in cylinders
        )
    )


def _shares(part: Section, anatomy: Anatomy, stations: _Stations) -> list[tuple[int, float]]:
    """Return the stations that a part's inertia goes to, with its shares."""
    if part.kind == "crankpin":
        return [(stations.of_throws[part.number - 1], 1.0)]
    z = _middle_mm(part, anatomy)
    places = stations.z_mm
    if part.kind in ("web", "counterweight"):
        throws = [places[station] for station in stations.of_throws]
        beside = sorted(range(len(throws)), key=lambda n: abs(throws[n] - z))[:1]
        return [(stations.of_throws[n], 1.0) for n in beside]
    if z <= places[0]:
        return [(0, 1.0)]
    if z >= places[-1]:
        return [(len(places) - 1, 1.0)]
    after = int(np.searchsorted(places, z))
    share = (z - places[after - 1]) / (places[after] - places[after - 1])
    return [(after - 1, 1.0 - share), (after, share)]


def _middle_mm(part: Section, anatomy: Anatomy) -> float:
    if part.kind == "main journal":
        return float(anatomy.main_journals[part.number - 1].centre_mm[2])
    return float(part.moments.centre_mm[2])
