"""Balance factors and counterweights by the loads of the whole cycle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from autobalance.declare import NewtonMetres, Rpm
from autobalance.engines.cycle.firing_engine import FiringEngine, LoadParts, pulls_at_mains_n
from autobalance.engines.cycle.piston_friction import PistonFrictionParts
from autobalance.running_gear.whole_engine import CrankUnbalance
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_G_MM2_S2, N_M_PER_N_MM, N_PER_G_MM_S2
from autobalance.value_classes import dataclass

# Loads and friction of ideal cranks by balance factor, and the engine's key figures.
#
# An ideal crank has, in the plane of each throw and opposite to it, just the product n (m_rot + f m_rec) r
# of its n rods, and no other unbalance.


MAX_SPEED_RATIO = 10.0
"""Multiple of the speed up to which friction is asked whether it takes all torque."""
LOWEST_SPEED_RATIO = 1e-3
"""Share of the speed at which friction that takes all torque lets the engine not start."""
MIN_SPEED_RATIO = 0.1
"""Share of the speed from which on the largest torque is looked for."""


@dataclass(frozen=True, eq=False)
class FactorLoadsRow:
    """Main-bearing loads and friction of an ideal crank.

    Attributes
    ----------
    factor : float
    greatest_mains_n : (m,) float
        Largest load of each main [N].
    mean_main_n : float
        Mean magnitude over angles, then over the mains [N].
    friction_mean_n_m : float
        Of the mains and all the rest [N·m].
    """

    factor: float
    greatest_mains_n: Array
    mean_main_n: float
    friction_mean_n_m: float

    @property
    def greatest_main_n(self) -> float:
        """Largest over all mains [N]."""
        return float(self.greatest_mains_n.max())


def ideal_counterweights(firing: FiringEngine, factor: float) -> tuple[CrankUnbalance, ...]:
    """Return the counterweights of an ideal crank, one in the plane of each throw."""
    unbalances = []
    for throw in firing.throws:
        rods = [firing.engine.cylinders[number] for number in throw.cylinders]
        product = sum(rod.bob_weight_product_g_mm(factor) for rod in rods)
        direction = np.array([np.cos(throw.angle_rad), np.sin(throw.angle_rad)])
        unbalances.append(CrankUnbalance(-product * direction, throw.z_mm))
    return tuple(unbalances)


@dataclass(frozen=True, eq=False)
class FactorMainLoads:
    """Loads of the mains at any speed and factor, from the parts of one calculation."""

    firing: FiringEngine
    parts: LoadParts

    @classmethod
    def of(cls, firing: FiringEngine) -> FactorMainLoads:
        return cls(firing, firing.parts)

    def crank_n(self, factor: float | None) -> Complex:
        """Return the force of a crank of a factor (None: the crank as it is) on each main at 1 rad/s [N]."""
        if factor is None:
            return self.parts.crank_n
        return pulls_at_mains_n(ideal_counterweights(self.firing, factor), self.firing.mains_z_mm)

    def sizes_n(self, factor: float | None, speed_rad_s: float) -> Array:
        """Return the magnitude of each main's load (m, n) [N]."""
        result: Array = np.abs(self.parts.mains_n(speed_rad_s, self.crank_n(factor)))
        return result

    def friction_mean_n_m(self, mean_mains_n: Array, speed_rad_s: float) -> float:
        """Return the mean friction of mains with a mean load each, and of all the rest [N·m]."""
        lever = self.firing.friction.main_lever_mm(self.firing.main_diameters_mm)
        return float(lever @ mean_mains_n) * N_M_PER_N_MM + self.firing.piston_friction_n_m(speed_rad_s)

    def row(self, factor: float, speed_rad_s: float) -> FactorLoadsRow:
        """Return the row of a factor."""
        size = self.sizes_n(factor, speed_rad_s)
        means = self.firing.grid.mean(size)
        friction = self.friction_mean_n_m(means, speed_rad_s)
        return FactorLoadsRow(factor, size.max(axis=1), float(means.mean()), friction)

    @cached_property
    def means(self) -> CycleMeanLoads:
        """The same for means over the cycle alone."""
        return CycleMeanLoads.of(self.firing, self.parts)

    def surplus_n_m(self, factor: float | None, speed_rad_s: float) -> float:
        """Return the mean torque that friction leaves, at a speed [N·m]."""
        return self.means.surplus_n_m(self.means.of_crank(self.crank_n(factor)), speed_rad_s)


@dataclass(frozen=True, eq=False)
class CycleMeanLoads:
    """Means over the cycle of friction and of the mains' loads at any speed: from the Gauss points alone.

    Components x of all points are before components y of all: a sum at a speed is then one of real numbers.

    Attributes
    ----------
    firing : FiringEngine
    steady_n, rods_n : (m, 2 g) float
        Loads of the mains by gas, weight and drives; by rods and pistons at 1 rad/s [N].
    turning : (2, 2 g) float
        What turns with the crank: rows x and y of an unbalance along x and along y.
    shares : (g,) float
        Of each point in a mean.
    pistons : PistonFrictionParts or None
        At the same points.
    """

    firing: FiringEngine
    steady_n: Array
    rods_n: Array
    turning: Array
    shares: Array
    pistons: PistonFrictionParts | None

    @classmethod
    def of(cls, firing: FiringEngine, parts: LoadParts) -> CycleMeanLoads:
        """Return the parts of an engine that its means need."""
        grid = firing.grid
        points = slice(grid.even_rad.size, None)
        turned = np.exp(1j * grid.angle_rad[points])
        return cls(
            firing,
            _apart(parts.steady_mains_n[:, points]),
            _apart(parts.rod_mains_n[:, points]),
            _apart(np.stack([turned, 1j * turned])),
            grid.panels.weights_rad.ravel() / grid.span_rad,
            None if parts.pistons is None else parts.pistons.at_points(points),
        )

    def of_crank(self, crank_n: Complex) -> Array:
        """Return the loads (m, 2 g) at 1 rad/s of rods, pistons and a crank's unbalance at the mains [N]."""
        result: Array = self.rods_n + np.stack([crank_n.real, crank_n.imag], axis=-1) @ self.turning
        return result

    def surplus_n_m(self, moving_n: Array, speed_rad_s: float) -> float:
        """Return the mean torque that friction leaves at a speed, of a crank with its rods [N·m]."""
        return self.surpluses_n_m([moving_n], speed_rad_s)[0]

    def surpluses_n_m(self, moving_n: Sequence[Array], speed_rad_s: float) -> list[float]:
        """Return the mean torque that friction leaves at a speed, by crank [N·m]."""
        firing = self.firing
        left = firing.gas_mean_n_m - firing.mean_pressure_friction_n_m(speed_rad_s)
        steady = self.steady_n
        if self.pistons is not None:
            along = self.pistons.along_n(speed_rad_s)
            lost = np.einsum("cg,cg,g->", along, self.pistons.slope_mm, self.shares)
            left -= float(lost) * N_M_PER_N_MM
            steady = steady + self.pistons.rods.mains_n(along).reshape(steady.shape)
        lever = firing.friction.main_lever_mm(firing.main_diameters_mm) * N_M_PER_N_MM
        return [left - float(lever @ self._mean_sizes_n(steady, each, speed_rad_s)) for each in moving_n]

    def _mean_sizes_n(self, steady_n: Array, moving_n: Array, speed_rad_s: float) -> Array:
        whole = steady_n + speed_rad_s**2 * moving_n
        whole *= whole
        count = self.shares.size
        # not by @: BLAS would start threads for it, which cost more than they gain
        result: Array = np.einsum("mg,g->m", np.sqrt(whole[:, :count] + whole[:, count:]), self.shares)
        return result


def _apart(vectors: Complex) -> Array:
    """Return x + iy (m, g) as x of all points, then y of all (m, 2 g)."""
    return np.concatenate([vectors.real, vectors.imag], axis=-1)


def factor_rows(
    firing: FiringEngine, factors: Sequence[float], speed_rad_s: float
) -> tuple[FactorLoadsRow, ...]:
    """Return main-bearing loads and friction by balance factor at a speed."""
    mains = FactorMainLoads.of(firing)
    return tuple(mains.row(factor, speed_rad_s) for factor in factors)


@dataclass(frozen=True)
class KeyFigures:
    """Key figures of an engine's response.

    Attributes
    ----------
    acceleration_rad_s2 : float
        Throttle response at the speed: (gas − friction)/J without load [rad/s²].
    greatest_speed_rad_s : float or None
        Where friction takes all torque of the gas; 0 where it does from the start, None beyond ten times the
        speed [rad/s].
    greatest_torque_n_m : float
        Mean torque at the shaft, largest from a tenth of the speed to the speed [N·m].
    """

    acceleration_rad_s2: float
    greatest_speed_rad_s: Rpm | None
    greatest_torque_n_m: NewtonMetres


@dataclass(frozen=True)
class TorqueLeft:
    """Mean torque that friction leaves: at the speed, the largest, and where it ends; see `KeyFigures`."""

    now_n_m: float
    greatest_speed_rad_s: float | None
    greatest_torque_n_m: float

    def figures(self, inertia_g_mm2: float) -> KeyFigures:
        """Return the key figures with a mean inertia."""
        acceleration = self.now_n_m / (inertia_g_mm2 * N_M_PER_G_MM2_S2)
        return KeyFigures(acceleration, self.greatest_speed_rad_s, self.greatest_torque_n_m)


def torques_left(
    mains: FactorMainLoads, speed_rad_s: float, factors: Sequence[float | None] = (None,)
) -> tuple[TorqueLeft, ...]:
    """Return the torque left with ideal cranks of factors (None: the crank as it is)."""
    means = mains.means
    cranks = [means.of_crank(mains.crank_n(factor)) for factor in factors]
    low, high = LOWEST_SPEED_RATIO * speed_rad_s, MAX_SPEED_RATIO * speed_rad_s
    speeds = [low, *(np.linspace(MIN_SPEED_RATIO, 1.0, 10) * speed_rad_s).tolist(), high]
    by_speed = [means.surpluses_n_m(cranks, speed) for speed in speeds]  # friction of pistons once a speed
    rows = []
    for crank, torques in zip(cranks, zip(*by_speed, strict=True), strict=True):
        ends = dict(zip((low, high), (torques[0], torques[-1]), strict=True))

        def surplus(speed: float, crank: Array = crank, ends: dict[float, float] = ends) -> float:
            return ends[speed] if speed in ends else means.surplus_n_m(crank, speed)

        greatest = _greatest_speed(surplus, low, high)
        rows.append(TorqueLeft(torques[-2], greatest, max(torques[1:-1])))
    return tuple(rows)


def key_figures(
    firing: FiringEngine, speed_rad_s: float, factors: Sequence[float | None] = (None,)
) -> tuple[KeyFigures, ...]:
    """Return the key figures of an engine with ideal cranks of factors (None: the crank as it is).

    References
    ----------
    Hoem & Røsholm 2016, Sec. 1.3: throttle response, largest speed and largest torque.
    """
    inertia = mean_inertia_g_mm2(firing)
    return tuple(
        left.figures(inertia) for left in torques_left(FactorMainLoads.of(firing), speed_rad_s, factors)
    )


def mean_inertia_g_mm2(firing: FiringEngine) -> float:
    """Return the mean of J over the crank angle [g·mm²]."""
    return float(np.mean(firing.inertia_g_mm2(firing.grid.even_rad)))


def _greatest_speed(surplus: Callable[[float], float], low_rad_s: float, high_rad_s: float) -> float | None:
    from scipy.optimize import brentq

    if surplus(low_rad_s) <= 0.0:
        return 0.0
    if surplus(high_rad_s) > 0.0:
        return None
    return float(brentq(surplus, low_rad_s, high_rad_s, xtol=1e-9 * high_rad_s))


def inertia_figures(firing: FiringEngine, speed_rad_s: float, shares: Sequence[float]) -> list[KeyFigures]:
    """Return the key figures with the inertia of crank and flywheel multiplied by each share."""
    changed = [with_inertia(firing, share) for share in shares]
    if any(each.driven_inertia_g_mm2 for each in firing.drives):  # whose pull depends on the inertia before
        return [key_figures(each, speed_rad_s)[0] for each in changed]
    (left,) = torques_left(FactorMainLoads.of(firing), speed_rad_s)
    return [left.figures(mean_inertia_g_mm2(each)) for each in changed]


def reciprocating_figures(
    firing: FiringEngine, speed_rad_s: float, shares: Sequence[float]
) -> list[KeyFigures]:
    """Return the key figures with the reciprocating masses multiplied by each share."""
    rows = []
    for share in shares:
        changed = with_reciprocating(firing, share)
        (left,) = torques_left(FactorMainLoads(changed, changed.parts_beside(firing)), speed_rad_s)
        rows.append(left.figures(mean_inertia_g_mm2(changed)))
    return rows


def with_inertia(firing: FiringEngine, share: float) -> FiringEngine:
    """Return the engine with the inertia of its crank and flywheel multiplied by a share."""
    engine = replace(firing.engine, polar_inertia_g_mm2=share * firing.engine.polar_inertia_g_mm2)
    return replace(firing, engine=engine, flywheel_g_mm2=share * firing.flywheel_g_mm2)


def with_reciprocating(firing: FiringEngine, share: float) -> FiringEngine:
    """Return the engine with its reciprocating masses multiplied by a share."""
    cylinders = tuple(
        replace(
            each,
            reciprocating_g=share * each.reciprocating_g,
            small_end_g=min(share, 1.0) * each.small_end_g,
        )
        for each in firing.engine.cylinders
    )
    return replace(firing, engine=replace(firing.engine, cylinders=cylinders))


# The counterweight that leaves the least reaction: the smallest circle round a load as the crank sees it.
#
# A counterweight adds one constant vector to a load in the crank's frame. The largest load is smallest where
# that vector moves the centre of the smallest circle round the load's path to the axis; the radius is what
# is left.


@dataclass(frozen=True)
class LoadCircle:
    """Centre x + iy and radius."""

    centre: complex
    radius: float


MAX_COUNTERWEIGHT_RATIO = 4.0
"""Largest counterweight that is looked at, over that which would take the largest load away."""


@dataclass(frozen=True)
class BestCounterweight:
    """The unbalance to add in a throw's plane, in the rotor frame, and the largest load it leaves."""

    product_g_mm: float
    angle_rad: float
    greatest_n: float


def smallest_circle(points: Complex) -> LoadCircle:
    """Return the smallest circle that holds all points (n,) x + iy.

    Points of the hull are put in one by one; one that lies outside lies on the new circle's rim (Welzl). The
    order is fixed, so that the result is the same from run to run.

    Examples
    --------
    >>> found = smallest_circle(np.array([0.0, 2.0, 1.0 + 1.0j, 1.0]))
    >>> found.centre, round(found.radius, 12)
    ((1+0j), 1.0)
    """
    hull = np.random.default_rng(1).permutation(_hull(points))
    slack = 1e-12 * max(1.0, float(np.abs(hull).max()))
    circle = LoadCircle(complex(hull[0]), 0.0)
    for place, point in enumerate(hull):
        if abs(point - circle.centre) > circle.radius + slack:
            circle = _with_one(hull[:place], complex(point), slack)
    return circle


def _with_one(points: Complex, on_rim: complex, slack: float) -> LoadCircle:
    circle = LoadCircle(on_rim, 0.0)
    for place, point in enumerate(points):
        if abs(point - circle.centre) > circle.radius + slack:
            circle = _with_two(points[:place], on_rim, complex(point), slack)
    return circle


def _with_two(points: Complex, first: complex, second: complex, slack: float) -> LoadCircle:
    circle = LoadCircle(0.5 * (first + second), 0.5 * abs(first - second))
    for point in points:
        if abs(point - circle.centre) > circle.radius + slack:
            two = _through(first, second, complex(point))
            circle = circle if two is None else two
    return circle


def _through(a: complex, b: complex, c: complex) -> LoadCircle | None:
    """Circle through three points; None where they lie on one line."""
    b, c = b - a, c - a
    twice = 2.0 * (b.real * c.imag - b.imag * c.real)
    if twice == 0.0:
        return None
    centre = (abs(b) ** 2 * c - abs(c) ** 2 * b) * -1j / twice
    return LoadCircle(a + centre, abs(centre))


def _hull(points: Complex) -> Complex:
    """Corners of the convex hull; all points where they lie on a line."""
    from scipy.spatial import ConvexHull, QhullError

    distinct = np.unique(points)
    if distinct.size < 4:
        return distinct
    try:
        corners = ConvexHull(np.stack([distinct.real, distinct.imag], axis=1)).vertices
    except QhullError:
        return distinct
    result: Complex = distinct[corners]
    return result


def best_counterweight(load_n: Complex, angle_rad: Array, speed_rad_s: float) -> BestCounterweight:
    """Return the counterweight that leaves the least largest load.

    Parameters
    ----------
    load_n : (n,) complex
        Load without any counterweight, x + iy in the engine's frame [N].
    angle_rad : (n,) float
        Crank angles [rad].
    speed_rad_s : float
        [rad/s].

    References
    ----------
    O'Leary and Gatecliff, in Hoem & Røsholm 2016, Sec. 3.1.2, look for the circle by trial and error. For
    inertia alone and a long rod it is half the reciprocating mass.
    """
    circle = smallest_circle(load_n * np.exp(-1j * angle_rad))
    unbalance = -circle.centre / (speed_rad_s**2 * N_PER_G_MM_S2)
    return BestCounterweight(abs(unbalance), math.atan2(unbalance.imag, unbalance.real), circle.radius)


def best_counterweight_at(
    load_n: Complex, angle_rad: Array, speed_rad_s: float, place_rad: float
) -> BestCounterweight:
    """Return the best counterweight where only one direction in the rotor frame is allowed.

    The largest load is a convex function of the product: it has one valley. Zero where any makes it worse.
    """
    from scipy.optimize import minimize_scalar

    seen = load_n * np.exp(-1j * angle_rad)
    along = complex(math.cos(place_rad), math.sin(place_rad)) * speed_rad_s**2 * N_PER_G_MM_S2
    most = MAX_COUNTERWEIGHT_RATIO * float(np.abs(seen).max()) / abs(along)

    def greatest(product: float) -> float:
        return float(np.abs(seen + product * along).max())

    optimum = minimize_scalar(greatest, bounds=(0.0, most), method="bounded", options={"xatol": 1e-9 * most})
    product = float(optimum.x) if optimum.fun < greatest(0.0) else 0.0
    return BestCounterweight(product, place_rad, greatest(product))
