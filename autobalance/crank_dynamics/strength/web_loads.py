"""Bending, pressing and twisting of each web and pin of a crank over the cycle, by statics."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from autobalance.balancing.engine_from_job import beside_the_rods, mains_z_mm
from autobalance.crank.anatomy import Anatomy, Throw
from autobalance.crank_dynamics.torsion.from_job import webs_beside
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.firing_engine import as_complex
from autobalance.job import Job
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_N_MM, N_PER_G_MM_S2
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class WebLoads:
    """Loads of one web over the crank angle.

    Attributes
    ----------
    throw : int
        Number of the throw whose crankpin the web carries.
    web : int
        Number of the web.
    is_above : bool
        Whether it is above the crankpin (greater z).
    z_mm : float
        Middle of the web, where its loads are taken [mm].
    bending_n_m : (n,) float
        Moment in the plane of the throw; positive where the crankpin is pressed towards the axis [N·m].
    radial_n : (n,) float
        Force along the web; positive where it is pressed [N].
    pin_torque_n_m, journal_torque_n_m : (n,) float
        About the crankpin's own axis, and of the main journal beside the web [N·m].
    """

    throw: int
    web: int
    is_above: bool
    z_mm: float
    bending_n_m: Array
    radial_n: Array
    pin_torque_n_m: Array
    journal_torque_n_m: Array


@dataclass(frozen=True, eq=False)
class CrankpinLoads:
    """Loads in the middle of a crankpin over the crank angle.

    Attributes
    ----------
    throw : int
        Number of its throw.
    bending_n_m : (n, 2) float
        Moment of the forces along the throw, away from the crank axis, and across it, counter-clockwise seen
        from +z: what lies on that side of the crankpin is pressed where it is positive [N·m].
    torque_n_m : (n,) float
        About the crankpin's own axis [N·m].
    """

    throw: int
    bending_n_m: Array
    torque_n_m: Array


@dataclass(frozen=True, eq=False)
class _ThrowAtRest:
    """A throw with its bay, the factor that turns loads into its frame, and torques over the angle (n,)."""

    throw: Throw
    bay: _Bay
    turned: complex
    torque_before_n_mm: Array
    torque_after_n_mm: Array
    pin_torque_n_mm: Array


@dataclass(frozen=True, eq=False)
class _Bay:
    """The crank between two mains with all that loads these: rods and metal; overhangs belong to the ends.

    Attributes
    ----------
    low_mm, high_mm : float
        Places of the mains [mm].
    rods : sequence of (float, (n,) complex)
        Place and load of each rod, as the crank sees it, x + iy [N].
    pieces : sequence of (float, Moments)
        Place and moments of what is not metal of the crank.
    solid : Solid
        Its metal (rotor frame).
    density_g_mm3 : float
    pull : complex
        Ω² and what makes newtons of it.
    is_mirrored : bool
        Whether the engine turns clockwise, computed as its mirror image.
    """

    low_mm: float
    high_mm: float
    rods: Sequence[tuple[float, Complex]]
    pieces: Sequence[tuple[float, Moments]]
    solid: Solid
    density_g_mm3: float
    pull: float
    is_mirrored: bool

    def at(self, z_mm: float) -> tuple[Complex, Complex]:
        """Return the sum of the forces below a section (n,) [N], and their moment about it (n,) [N·mm].

        The main below it pushes back with the share of every load of the bay that the lever gives it.
        """
        whole = self._metal(self.solid, self.pieces)
        below = self._metal(self.solid.below(z_mm), [(z, each) for z, each in self.pieces if z < z_mm])
        force = self.pull * below[0] + sum(load for z, load in self.rods if z < z_mm)
        of_metal = self.pull * (z_mm * below[0] - below[1])
        moment = of_metal + sum((z_mm - z) * load for z, load in self.rods if z < z_mm)
        share = self.high_mm * whole[0] - whole[1]
        at_low = self.pull * share + sum((self.high_mm - z) * load for z, load in self.rods)
        at_low = at_low / (self.high_mm - self.low_mm)
        return np.asarray(force - at_low), np.asarray(moment - (z_mm - self.low_mm) * at_low)

    def _metal(self, solid: Solid, pieces: Sequence[tuple[float, Moments]]) -> tuple[complex, complex]:
        """Return unbalance and its moment about z = 0 as complex numbers."""
        moments = sum((each for _, each in pieces), solid.moments(self.density_g_mm3))
        unbalance = Unbalance.of(moments)
        both = complex(*unbalance.resultant_g_mm), complex(*unbalance.moment_g_mm2)
        return (both[0].conjugate(), both[1].conjugate()) if self.is_mirrored else both


def web_loads(
    cycle: CycleAnalysis, job: Job, anatomy: Anatomy, solid: Solid, density_g_mm3: float
) -> list[WebLoads]:
    """Return the loads of the webs on both sides of each throw.

    The crank is hinged at its mains, as the loads of ``cycle`` have it: a bay between two mains carries its
    rods and its own metal, which turns at constant speed. Torque goes out beyond the last main (largest z).

    Parameters
    ----------
    cycle : CycleAnalysis
        At the speed that counts.
    job : Job
    anatomy : Anatomy
    solid : Solid
        Of the crank (file coordinates).
    density_g_mm3 : float

    Raises
    ------
    JobError
        If a throw has no web on a side.
    """
    return [
        WebLoads(
            each.throw.number,
            web.number,
            is_above,
            z,
            N_M_PER_N_MM * (moment * each.turned).real,
            (-1.0 if is_above else 1.0) * (force * each.turned).real,
            N_M_PER_N_MM * each.pin_torque_n_mm,
            N_M_PER_N_MM * (each.torque_after_n_mm if is_above else each.torque_before_n_mm),
        )
        for each in _throws(cycle, job, anatomy, solid, density_g_mm3)
        for web, is_above in zip(webs_beside(anatomy, each.throw), (False, True), strict=True)
        for z in (0.5 * (web.z_min_mm + web.z_max_mm),)
        for force, moment in (each.bay.at(z),)
    ]


def crankpin_loads(
    cycle: CycleAnalysis, job: Job, anatomy: Anatomy, solid: Solid, density_g_mm3: float
) -> list[CrankpinLoads]:
    """Return the loads in the middle of each crankpin; parameters as in `web_loads`."""
    sense = -1.0 if job.engine.clockwise else 1.0  # such an engine is computed as its mirror image
    listed = []
    for each in _throws(cycle, job, anatomy, solid, density_g_mm3):
        moment = each.bay.at(float(each.throw.crankpin.centre_mm[2]))[1] * each.turned
        both = N_M_PER_N_MM * np.column_stack([moment.real, sense * moment.imag])
        listed.append(CrankpinLoads(each.throw.number, both, N_M_PER_N_MM * each.pin_torque_n_mm))
    return listed


def _throws(
    cycle: CycleAnalysis, job: Job, anatomy: Anatomy, solid: Solid, density_g_mm3: float
) -> Iterator[_ThrowAtRest]:
    """Yield every throw with the loads that it hands on, in the order of the axis."""
    back = np.exp(-1j * cycle.grid.angle_rad)
    rods_of = [
        (cylinder.z_mm, as_complex(load) * back)
        for cylinder, load in zip(cycle.firing.engine.cylinders, cycle.loads.crankpin_n, strict=True)
    ]
    metal = solid.moved(anatomy.file_to_rotor)
    pull = cycle.speed_rad_s**2 * N_PER_G_MM_S2
    bays = _bays(job, anatomy, rods_of, metal, density_g_mm3, pull)
    before = np.zeros(cycle.grid.angle_rad.size)
    for throw, place, load in zip(anatomy.throws, cycle.firing.throws, cycle.crankpins_n, strict=True):
        turned = np.exp(-1j * place.angle_rad)
        own = as_complex(load) * back * turned  # along the throw, and across it
        radius = throw.crank_radius_mm
        after = before + radius * own.imag
        bay = next((each for each in bays if place.z_mm <= each.high_mm), bays[-1])
        rods = [rods_of[number] for number in place.cylinders]
        at_pin = (bay.at(place.z_mm)[0] - sum(each for z, each in rods if z < place.z_mm)) * turned
        yield _ThrowAtRest(throw, bay, turned, before, after, before - radius * at_pin.imag)
        before = after


def _bays(
    job: Job,
    anatomy: Anatomy,
    rods: Sequence[tuple[float, Complex]],
    solid: Solid,
    density_g_mm3: float,
    pull: float,
) -> list[_Bay]:
    mains = mains_z_mm(anatomy)
    beside = [(z, part) for part, z in beside_the_rods(job, anatomy)]
    bays = []
    for low, high in pairwise(mains):
        first, last = low == mains[0], high == mains[-1]
        from_mm, to_mm = -math.inf if first else low, math.inf if last else high
        piece = solid if first else solid.above(low)
        bays.append(
            _Bay(
                low,
                high,
                [each for each in rods if from_mm < each[0] <= to_mm],
                [each for each in beside if from_mm < each[0] <= to_mm],
                piece if last else piece.below(high),
                density_g_mm3,
                pull,
                job.engine.clockwise,
            )
        )
    return bays
