"""Questions of a job or a chain's file about torsion, in SI units."""

from __future__ import annotations

import math
from dataclasses import field
from typing import Any, Literal

import numpy as np

from autobalance.crank_dynamics.torsion.trains import TrainParts
from autobalance.types import Array
from autobalance.value_classes import dataclass

Formula = Literal["ker_wilson", "carter"]

USUAL_DAMPING_RATIO = 0.01
"""Damping of every mode if the file gives neither a ratio nor a damper, as bare crankshafts have it."""


@dataclass(frozen=True)
class Excitation:
    """A torque at a station (from 0), as a complex number T exp(iφ)."""

    station: int
    order: float
    torque_n_m: complex


@dataclass(frozen=True)
class RunUp:
    """A ramp of the mean speed from one to the other at a rate [rad/s, rad/s²]."""

    from_rad_s: float
    to_rad_s: float
    rate_rad_s2: float

    @property
    def duration_s(self) -> float:
        return abs(self.to_rad_s - self.from_rad_s) / self.rate_rad_s2

    @property
    def acceleration_rad_s2(self) -> float:
        """Rate with its sign: negative of a run-down."""
        return math.copysign(self.rate_rad_s2, self.to_rad_s - self.from_rad_s)

    def speed(self, time_s: Array) -> Array:
        return np.asarray(self.from_rad_s + self.acceleration_rad_s2 * time_s)

    def phase(self, time_s: Array) -> Array:
        return np.asarray(self.from_rad_s * time_s + 0.5 * self.acceleration_rad_s2 * time_s**2)


@dataclass(frozen=True)
class PendulumAbsorber:
    """A pendulum and the station (from 0) it hangs at, if any."""

    order: float
    distance_m: float
    mass_kg: float
    station: int | None

    @property
    def length_m(self) -> float:
        """R/n²: short enough to be tuned to the order at any speed."""
        return self.distance_m / self.order**2

    @property
    def inertia_kg_m2(self) -> float:
        """M (R + L)²."""
        return self.mass_kg * (self.distance_m + self.length_m) ** 2


@dataclass(frozen=True, eq=False)
class TorsionQuestion:
    """Speeds, torques, absorber, parts of a train; ``damping_ratio`` None: as usual."""

    speeds_rad_s: Array
    excitations: tuple[Excitation, ...]
    pendulum: PendulumAbsorber | None
    parts: TrainParts = field(default_factory=TrainParts)
    damping_ratio: float | None = None
    run_up: RunUp | None = None

    def ratio_of_modes(self, damped: bool) -> float:
        """Return the share of critical damping of every mode; ``damped``: dampers take up what swings."""
        if self.damping_ratio is not None:
            return self.damping_ratio
        return 0.0 if damped else USUAL_DAMPING_RATIO


@dataclass(frozen=True)
class Driven:
    """An inertia on a separate shaft, next to the crank or to another such inertia."""

    name: str
    inertia_kg_m2: float
    shaft_n_m_rad: float
    shaft_damping_n_m_s: float
    damping_n_m_s: float
    diameter_m: float | None


@dataclass(frozen=True, eq=False)
class CrankTorsion:
    """A job's keys on its crank's torsion."""

    question: TorsionQuestion
    formula: Formula
    shear_modulus_mpa: float
    flywheel_kg_m2: float
    damper_kg_m2: float
    cylinder_damping_n_m_s: float
    front: tuple[Driven, ...]
    train: tuple[Driven, ...]
    fem: bool
    fem_size_mm: float | None
    filled: dict[str, Any]
