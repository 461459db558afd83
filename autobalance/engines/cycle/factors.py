"""Loads and friction of ideal cranks by balance factor, and the engine's key figures.

An ideal crank has, in the plane of each throw and opposite to it, just the product n (m_rot + f m_rec) r of
its n rods, and no other unbalance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from autobalance.declare import NewtonMetres, Rpm
from autobalance.engines.cycle.firing_engine import FiringEngine, LoadParts, pulls_at_mains_n
from autobalance.running_gear.whole_engine import CrankUnbalance
from autobalance.types import Array, Complex
from autobalance.units import N_M_PER_G_MM2_S2, N_M_PER_N_MM

MAX_SPEED_RATIO = 10.0
"""Multiple of the speed up to which friction is asked whether it takes all torque."""
MIN_SPEED_RATIO = 0.1
"""Share of the speed from which on the largest torque is looked for."""


@dataclass(frozen=True, eq=False)
class FactorRow:
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
class MainLoads:
    """Loads of the mains at any speed and factor, from the parts of one calculation."""

    firing: FiringEngine
    parts: LoadParts

    @classmethod
    def of(cls, firing: FiringEngine) -> MainLoads:
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

    def row(self, factor: float, speed_rad_s: float) -> FactorRow:
        """Return the row of a factor."""
        size = self.sizes_n(factor, speed_rad_s)
        means = self.firing.grid.mean(size)
        friction = self.friction_mean_n_m(means, speed_rad_s)
        return FactorRow(factor, size.max(axis=1), float(means.mean()), friction)

    def surplus_n_m(self, factor: float | None, speed_rad_s: float) -> float:
        """Return the mean torque that friction leaves, at a speed [N·m]."""
        means = self.firing.grid.mean(self.sizes_n(factor, speed_rad_s))
        return self.firing.gas_mean_n_m - self.friction_mean_n_m(means, speed_rad_s)


def factor_rows(firing: FiringEngine, factors: Sequence[float], speed_rad_s: float) -> tuple[FactorRow, ...]:
    """Return main-bearing loads and friction by balance factor at a speed."""
    mains = MainLoads.of(firing)
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


def key_figures(firing: FiringEngine, speed_rad_s: float, factor: float | None = None) -> KeyFigures:
    """Return the key figures of an engine with an ideal crank of a factor, or as it is.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 1.3: throttle response, largest speed and largest torque.
    """
    mains = MainLoads.of(firing)

    def surplus(speed: float) -> float:
        return mains.surplus_n_m(factor, speed)

    inertia = float(np.mean(firing.inertia_g_mm2(firing.grid.even_rad))) * N_M_PER_G_MM2_S2
    torques = [surplus(share * speed_rad_s) for share in np.linspace(MIN_SPEED_RATIO, 1.0, 10)]
    return KeyFigures(surplus(speed_rad_s) / inertia, _greatest_speed(surplus, speed_rad_s), max(torques))


def _greatest_speed(surplus: Callable[[float], float], speed_rad_s: float) -> float | None:
    from scipy.optimize import brentq

    low, high = 1e-3 * speed_rad_s, MAX_SPEED_RATIO * speed_rad_s
    if surplus(low) <= 0.0:
        return 0.0
    if surplus(high) > 0.0:
        return None
    return float(brentq(surplus, low, high, xtol=1e-9 * high))


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
