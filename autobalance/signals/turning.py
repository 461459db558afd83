"""The shaft's angle as a smooth function of time, with its speed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline

from autobalance.types import Array

TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Turning:
    """Angle θ(t) between two instants; a cubic spline, so that the speed has no steps and no corners.

    Parameters
    ----------
    times_s : (k,) array
        Ascending, k ≥ 2 [s].
    angles_rad : (k,) array
        Ascending [rad]; 0 is the origin of phases.
    """

    times_s: Array
    angles_rad: Array
    _spline: CubicSpline = field(init=False, repr=False)

    def __post_init__(self) -> None:
        spline = (
            CubicSpline(self.times_s, self.angles_rad, bc_type="natural")
            if len(self.times_s) < 4
            else CubicSpline(self.times_s, self.angles_rad)
        )
        object.__setattr__(self, "_spline", spline)

    @classmethod
    def steady(cls, speed_rpm: float, duration_s: float) -> Turning:
        """Return a constant speed from angle 0 at the first sample."""
        return cls(np.array([0.0, duration_s]), np.array([0.0, TURN * speed_rpm / 60.0 * duration_s]))

    @property
    def start_s(self) -> float:
        """Return the first time with a known angle [s]."""
        return float(self.times_s[0])

    @property
    def end_s(self) -> float:
        """Return the last time with a known angle [s]."""
        return float(self.times_s[-1])

    @property
    def turns(self) -> float:
        """Return the number of turns, not rounded."""
        return float(self.angles_rad[-1] - self.angles_rad[0]) / TURN

    def angle_rad(self, times_s: Array) -> Array:
        """Return the angles at times (n,) [rad]."""
        return np.asarray(self._spline(times_s))

    def speed_rad_s(self, times_s: Array) -> Array:
        """Return the speeds at times (n,) [rad/s]."""
        return np.asarray(self._spline(times_s, 1))

    def time_s(self, angles_rad: Array) -> Array:
        """Return the times of angles (n,), by Newton's method from the nearest known ones [s]."""
        times = np.interp(angles_rad, self.angles_rad, self.times_s)
        for _ in range(4):
            speed = np.maximum(self.speed_rad_s(times), 1e-9)
            times = np.clip(times - (self.angle_rad(times) - angles_rad) / speed, self.start_s, self.end_s)
        return times

    def speeds_rpm(self) -> Array:
        """Return the speeds at the known angles and midway between them [1/min]."""
        middle = 0.5 * (self.times_s[1:] + self.times_s[:-1])
        return self.speed_rad_s(np.sort(np.concatenate([self.times_s, middle]))) * 60.0 / TURN

    @property
    def mean_rpm(self) -> float:
        """Return the mean speed over time [1/min]."""
        return 60.0 * self.turns / (self.end_s - self.start_s)
