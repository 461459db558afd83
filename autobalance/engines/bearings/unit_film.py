"""The oil film of a plain journal bearing in its own units: the result of every film model.

Angles θ run in the sense of turning from the widest gap, where the film is H = h/c = 1 + ε cos θ. The radial
direction points from the bush's centre to the journal's (to the narrowest gap), the tangential one a quarter
turn on. Force is in units of η Ω R L (R/c)², pressure in η Ω (R/c)², flow in Ω R L c, squeeze speed ε̇ in Ω.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from autobalance.types import Array

Boundary = Literal["half", "reynolds", "full"]
"""Treatment of negative pressure: cut from the full solution, prevented so that it ends without slope, or
left."""
CONTACT_ECCENTRICITY_RATIO = 0.99
"""Eccentricity ratio above which smooth surfaces and a stiff bush are a fiction: the film is broken."""


@dataclass(frozen=True, eq=False)
class Pressure:
    """Film pressure (n, m) over angles from the widest gap (n,) and places z/(L/2) (m,), half the length."""

    angle_rad: Array
    place: Array
    pressure: Array


@dataclass(frozen=True, eq=False)
class UnitFilm:
    """Force of the film on the journal at one eccentricity, with its derivatives; dimensionless.

    ``*_slope`` is by the eccentricity ratio, ``*_squeeze`` by its rate over Ω. A turn of the line of centres
    turns the force; its rate φ̇ acts as the speed Ω − 2 φ̇ does.
    """

    eccentricity_ratio: float
    radial: float
    tangential: float
    radial_slope: float
    tangential_slope: float
    radial_squeeze: float
    tangential_squeeze: float
    side_flow: float
    greatest_pressure: float
    pressure: Pressure

    @property
    def load(self) -> float:
        """Magnitude of the force."""
        return math.hypot(self.radial, self.tangential)

    @property
    def load_slope(self) -> float:
        """Derivative of the load by the eccentricity ratio."""
        return (self.radial * self.radial_slope + self.tangential * self.tangential_slope) / self.load

    @property
    def attitude_rad(self) -> float:
        """Angle from the load to the line of centres, in the sense of turning [rad]."""
        return math.atan2(self.tangential, -self.radial)

    @property
    def sommerfeld(self) -> float:
        """Sommerfeld number (η N L D/W) (R/c)² with N in revolutions a second."""
        return 1.0 / (math.pi * self.load)

    @property
    def stiffness(self) -> Array:
        """−∂F/∂e [[rr, rt], [tr, tt]] about the line of centres, e over c."""
        ratio = self.eccentricity_ratio
        return -np.array(
            [
                [self.radial_slope, -self.tangential / ratio],
                [self.tangential_slope, self.radial / ratio],
            ]
        )

    @property
    def damping(self) -> Array:
        """−∂F/∂ė [[rr, rt], [tr, tt]] about the line of centres, ė over c Ω."""
        ratio = self.eccentricity_ratio
        return -np.array(
            [
                [self.radial_squeeze, -2.0 * self.radial / ratio],
                [self.tangential_squeeze, -2.0 * self.tangential / ratio],
            ]
        )


FilmModel = Callable[[float], UnitFilm]
"""Function from an eccentricity ratio in (0, 1) to the film."""

TOLERANCE = 1e-11
"""Step in the logarithm of the load."""


def film_for_load(model: FilmModel, load: float, guess: UnitFilm | None = None) -> UnitFilm | None:
    """Return the film that carries a load; None beyond ``CONTACT_ECCENTRICITY_RATIO``.

    Newton's method on log load over x = log ε/(1 − ε)², in which the load of a short bearing is nearly
    straight; where a step leaves the bracket it is halved.

    Parameters
    ----------
    model : FilmModel
    load : float
        Positive, in units of η Ω R L (R/c)².
    guess : UnitFilm, optional
        A film of the same model near the answer.
    """
    low, high = -30.0, _stretched(CONTACT_ECCENTRICITY_RATIO)
    film = model(0.5) if guess is None else guess
    x = _stretched(film.eccentricity_ratio)
    for _ in range(100):
        miss = math.log(film.load / load)
        if abs(miss) < TOLERANCE:
            return film
        if miss < 0.0:
            if film.eccentricity_ratio >= CONTACT_ECCENTRICITY_RATIO:
                return None
            low = x
        else:
            high = x
        ratio = film.eccentricity_ratio
        slope = film.load_slope / film.load / (1.0 / ratio + 2.0 / (1.0 - ratio))
        step = x - miss / slope
        if step >= high and high == _stretched(CONTACT_ECCENTRICITY_RATIO):
            step = high
        elif not low < step < high:
            step = 0.5 * (low + high)
        if abs(step - x) < 1e-14:
            return film
        x = step
        film = model(CONTACT_ECCENTRICITY_RATIO if x == _stretched(CONTACT_ECCENTRICITY_RATIO) else _ratio(x))
    return film


def _stretched(ratio: float) -> float:
    return math.log(ratio / (1.0 - ratio) ** 2)


def _ratio(stretched: float) -> float:
    """Return the eccentricity ratio of ``_stretched``: the smaller root of q ε² − (2 q + 1) ε + q."""
    q = math.exp(stretched)
    return 2.0 * q / (2.0 * q + 1.0 + math.sqrt(4.0 * q + 1.0))
