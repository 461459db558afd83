"""The speed of the crank over a cycle: its periodic unevenness, the flywheel it needs, and the free run-up.

J(θ) θ̈ + ½ J′ θ̇² = T is d(½ J θ̇²)/dθ = T: at any angle θ̇ = √(2 (E₀ + ∫T dθ)/J(θ)), so that only E₀ is
looked for: that of the wanted mean speed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2
from autobalance.value_classes import dataclass

LEAST_SHARE = 1e-14
STALLED_SPEED_ERROR = 1e9
LONGEST_SHARE = 0.05
"""Share of the cycle's time that one angle may take: a crank that lingers longer counts as stopped."""
LARGEST_FLYWHEEL_G_MM2 = 1e15


@dataclass(frozen=True, eq=False)
class UnevenSpeed:
    """A speed that repeats with the cycle.

    Attributes
    ----------
    angle_rad : (n,) float
        Evenly over the cycle [rad].
    speed_rad_s : (n,) float
        There [rad/s].
    """

    angle_rad: Array
    speed_rad_s: Array

    @property
    def mean_rad_s(self) -> float:
        """Mean over time: angle of the cycle over its time [rad/s]."""
        return float(self.speed_rad_s.size / np.sum(1.0 / self.speed_rad_s))

    @property
    def greatest_rad_s(self) -> float:
        """Largest, between the angles too [rad/s]."""
        return _peak(self.speed_rad_s)

    @property
    def least_rad_s(self) -> float:
        """Least, between the angles too [rad/s]."""
        return -_peak(-self.speed_rad_s)

    @property
    def fluctuation(self) -> float:
        """(largest − least)/mean, the coefficient of fluctuation."""
        return (self.greatest_rad_s - self.least_rad_s) / self.mean_rad_s


def _peak(values: Array) -> float:
    """Top of the parabola through the largest of periodic values and the two beside it."""
    place = int(np.argmax(values))
    before, top, after = (float(values[(place + step) % values.size]) for step in (-1, 0, 1))
    bend = before - 2.0 * top + after
    return top if bend >= 0.0 else top - 0.125 * (after - before) ** 2 / bend


def periodic_speed(
    angle_rad: Array, work_n_m: Array, inertia_g_mm2: Array, mean_rad_s: float
) -> UnevenSpeed | None:
    """Return the speed that repeats, or None where the crank would come to a stop.

    Parameters
    ----------
    angle_rad : (n,) float
        Evenly over the cycle [rad].
    work_n_m : (n,) float
        Work of the torque less its mean from angle 0 to there, ∫(T − T̄) dθ [N·m].
    inertia_g_mm2 : (n,) float
        J(θ) [g·mm²].
    mean_rad_s : float
        Wanted mean over time [rad/s].

    References
    ----------
    Hoem & Røsholm 2016, Sec. 2.3, gives T = I dω/dt, true for a constant inertia only.
    """
    from scipy.optimize import brentq

    inertia = inertia_g_mm2 * N_M_PER_G_MM2_S2
    least = float(-work_n_m.min())
    most = float(np.max(0.5 * inertia * mean_rad_s**2 - work_n_m))

    def speed(energy: float) -> Array:
        result: Array = np.sqrt(2.0 * np.maximum(0.0, energy + work_n_m) / inertia)
        return result

    def late(energy: float) -> float:
        """Time of a cycle over the wanted one, less 1."""
        speeds = speed(energy)
        return STALLED_SPEED_ERROR if speeds.min() <= 0.0 else float(np.mean(mean_rad_s / speeds)) - 1.0

    high = most + LEAST_SHARE * abs(most)
    if not high > least or late(least) < 0.0:
        return None
    energy = brentq(late, least, high, xtol=1e-15 * abs(high), rtol=8.9e-16, maxiter=200)
    slowness = 1.0 / speed(float(energy))
    if slowness.max() > LONGEST_SHARE * slowness.sum():
        return None
    return UnevenSpeed(angle_rad, 1.0 / slowness)


def flywheel_needed_g_mm2(fluctuation: Callable[[float], float | None], target: float) -> float | None:
    """Return the flywheel that brings the fluctuation down to the wanted one.

    Parameters
    ----------
    fluctuation : callable
        Of a flywheel's inertia [g·mm²]; None where the crank stops.
    target : float
        Greater than 0.

    Returns
    -------
    float or None
        0 where none is needed, None where none of 10¹⁵ g·mm² is enough [g·mm²].
    """
    from scipy.optimize import brentq

    def over(flywheel: float) -> float:
        value = fluctuation(flywheel)
        return 1e9 if value is None else value - target

    if over(0.0) <= 0.0:
        return 0.0
    high = 1e3
    while over(high) > 0.0:
        high *= 4.0
        if high > LARGEST_FLYWHEEL_G_MM2:
            return None
    return float(brentq(over, 0.0 if high == 1e3 else high / 4.0, high, xtol=1e-9 * high, rtol=1e-12))


def run_up_s(
    surplus_n_m: Callable[[float], float], mean_inertia_g_mm2: float, speeds_rad_s: Array
) -> Array | None:
    """Return the times at which the unloaded engine passes rising speeds, ∫ J̄/T dΩ (n,) [s].

    Parameters
    ----------
    surplus_n_m : callable
        Mean torque left for speeding up at a speed, gas less friction [N·m].
    mean_inertia_g_mm2 : float
        J̄ [g·mm²].
    speeds_rad_s : (n,) float
        Increasing; the clock starts at the first [rad/s].

    Returns
    -------
    (n,) float or None
        None where friction takes all the torque before the last speed.
    """
    place, weight = np.polynomial.legendre.leggauss(5)
    half = 0.5 * np.diff(speeds_rad_s)[:, None]
    nodes = 0.5 * (speeds_rad_s[1:] + speeds_rad_s[:-1])[:, None] + half * place
    torque = np.array([[surplus_n_m(float(each)) for each in row] for row in nodes])
    if torque.min() <= 0.0:
        return None
    steps = (half * weight * mean_inertia_g_mm2 * N_M_PER_G_MM2_S2 / torque).sum(axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])
