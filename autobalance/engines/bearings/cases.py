"""Cases of bearings for analysis, one dataclass a kind, and the balance of their heat. SI."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, Protocol, TypeVar

import numpy as np

from autobalance.engines.bearings.film import Boundary, JournalBearing
from autobalance.engines.bearings.oil import Feed, WaltherOil
from autobalance.engines.bearings.rolling import RollingBearing
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Balance of the heat of friction and the oil that carries it off: the running temperature of a film.


HOTTEST_RISE_K = 400.0
"""Largest rise above the supply at which a balance is sought."""
NEAR_K = 1e-6


@dataclass(frozen=True)
class Supply:
    """Oil as it comes to the bearing: temperature [°C] and specific heat [J/(kg K)]."""

    celsius: float
    heat_capacity_J_kg_K: float = 2000.0


class Heated(Protocol):
    """A film that makes heat, and the oil that leaves it."""

    @property
    def heat_W(self) -> float: ...

    @property
    def side_flow_m3_s(self) -> float: ...


AFilm = TypeVar("AFilm", bound=Heated)


def outlet_rise_K(film: Heated, oil: WaltherOil, supply: Supply) -> float:
    """Return the temperature rise of the side flow that carries off the whole heat of film and pump [K]."""
    carried = oil.density_kg_m3 * supply.heat_capacity_J_kg_K * film.side_flow_m3_s
    return film.heat_W / carried


def running_temperature_C(
    film_at: Callable[[float], AFilm | None], oil: WaltherOil, supply: Supply
) -> tuple[float, AFilm] | None:
    """Return the film's mean temperature, half way from supply to outlet, and the film at it.

    All heat leaves with the side flow, and the viscosity is that of the mean temperature throughout the
    film. A hotter oil is thinner and heats less, so there is one balance.

    Parameters
    ----------
    film_at : callable
        Film at an oil temperature [°C], None at contact.
    oil : WaltherOil
    supply : Supply

    Returns
    -------
    (float, Film) or None
        None where the film breaks, or would be hotter than ``HOTTEST_RISE_K``, before heat and flow balance.

    References
    ----------
    .. [1] A. A. Raimondi, J. Boyd, A solution for the finite journal bearing, ASLE Trans. 1 (1958) 159-209.
    """

    def excess(celsius: float) -> float:
        film = film_at(celsius)
        if film is None or not film.side_flow_m3_s > 0.0:
            return celsius - supply.celsius  # nothing to balance: the search ends below the break
        return celsius - supply.celsius - 0.5 * outlet_rise_K(film, oil, supply)

    hottest = supply.celsius + HOTTEST_RISE_K
    if excess(hottest) < 0.0:
        return None
    from scipy.optimize import brentq  # every `verify` loads this file for its keys alone

    celsius = float(brentq(excess, supply.celsius, hottest, xtol=NEAR_K))
    film = film_at(celsius)
    if film is None or abs(excess(celsius)) > 1e-3:
        return None
    return celsius, film


# Cases of bearings for analysis: one dataclass a kind, SI.


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
