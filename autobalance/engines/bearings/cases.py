"""Cases of bearings for analysis: one dataclass a kind, SI."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from autobalance.engines.bearings.film import JournalBearing
from autobalance.engines.bearings.heat_balance import Supply
from autobalance.engines.bearings.oil import WaltherOil
from autobalance.engines.bearings.oil_feeds import Feed
from autobalance.engines.bearings.rolling import RollingBearing
from autobalance.engines.bearings.unit_film import Boundary
from autobalance.types import Array

Solver = Literal["ocvirk", "reynolds", "petroff"]


@dataclass(frozen=True)
class Lubricant:
    """Viscosity as given, or an oil at a temperature, or an oil at the temperature that its heat makes."""

    given_Pa_s: float | None = None
    given_mm2_s: float | None = None
    oil: WaltherOil | None = None
    celsius: float | None = None
    supply: Supply | None = None

    def at(self, celsius: float) -> Lubricant:
        return Lubricant(oil=self.oil, celsius=celsius, supply=self.supply)

    @property
    def kinematic_mm2_s(self) -> float | None:
        """Kinematic viscosity [mm²/s]; None where it is not known."""
        if self.oil is None or self.celsius is None:
            return self.given_mm2_s
        return self.oil.kinematic_mm2_s(self.celsius)

    @property
    def viscosity_Pa_s(self) -> float | None:
        """Dynamic viscosity [Pa·s]; None where it is not known."""
        if self.oil is None or self.celsius is None:
            return self.given_Pa_s
        return self.oil.viscosity_Pa_s(self.celsius)

    @property
    def needed_mm2_s(self) -> float:
        """Kinematic viscosity [mm²/s]; ValueError where it is not known."""
        if self.kinematic_mm2_s is None:
            raise ValueError("the kinematic viscosity is not known")
        return self.kinematic_mm2_s

    @property
    def needed_Pa_s(self) -> float:
        """Dynamic viscosity [Pa·s]; ValueError where it is not known."""
        if self.viscosity_Pa_s is None:
            raise ValueError("the dynamic viscosity is not known")
        return self.viscosity_Pa_s


@dataclass(frozen=True)
class DryCase:
    """A dry journal with a coefficient of friction or a measured torque."""

    diameter_m: float
    load_N: float
    rotating_load_N: float
    mu: float | None
    torque_N_m: float | None


@dataclass(frozen=True, eq=False)
class History:
    """Force of the journal on the bush (n, 2) [N] over equal steps of the angle (n,) of one cycle [rad].

    ``clockwise``: journal and angle turn so, seen from +z, against x to y.
    """

    angle_rad: Array
    force_N: Array
    bush_speed_rad_s: float = 0.0
    clockwise: bool = False

    @property
    def sense(self) -> Array:
        """Factors (2,) that turn x and y into axes of an engine that turns from x to y, and back."""
        return np.array([1.0, -1.0 if self.clockwise else 1.0])


@dataclass(frozen=True, eq=False)
class PlainCase:
    """A plain bearing with an oil film under a load, at an eccentricity, or under loads by angle."""

    bearing: JournalBearing
    lubricant: Lubricant
    solver: Solver
    boundary: Boundary
    grid: tuple[int, int]
    load_N: float | None
    eccentricity_ratio: float | None
    attitude_rad: float
    history: History | None


@dataclass(frozen=True)
class RollingCase:
    """Equal rolling bearings, each with a radial load."""

    bearing: RollingBearing
    lubricant: Lubricant
    load_N: float
    count: int


@dataclass(frozen=True)
class PlatesCase:
    """Flat plates that squeeze a film."""

    lubricant: Lubricant
    load_N: float
    film_m: float
    length_m: float
    width_m: float


@dataclass(frozen=True, eq=False)
class FedCase:
    """A plain bearing with feeds under pressure; ``feeds`` gives them at a viscosity of what is supplied."""

    bearing: JournalBearing
    lubricant: Lubricant
    feeds: Callable[[float], tuple[Feed, ...]]
    wedge: bool
    boundary: Boundary
    grid: tuple[int, int]
    load_N: float | None
    eccentricity_ratio: float | None
    eccentricity_ratios: tuple[float, ...] = ()


Case = DryCase | FedCase | PlainCase | RollingCase | PlatesCase
