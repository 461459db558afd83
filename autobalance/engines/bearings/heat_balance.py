"""Balance of the heat of friction and the oil that carries it off: the running temperature of a film."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar

from autobalance.engines.bearings.oil import WaltherOil

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
