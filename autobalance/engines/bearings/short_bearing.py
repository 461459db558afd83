"""Ocvirk's short bearing: the film's pressure by closed form, parabolic along the bearing.

The half film from the widest gap to the narrowest one carries, however the journal moves.
"""

from __future__ import annotations

import math

import numpy as np

from autobalance.engines.bearings.unit_film import FilmModel, Pressure, UnitFilm

POINTS = (121, 21)
"""Number of points of the pressure that is kept for plots."""


def ocvirk(slenderness: float) -> FilmModel:
    """Return the film of a short bearing as a function of the eccentricity ratio.

    Radial force −4 λ² ε²/(1 − ε²)², tangential λ² π ε/(1 − ε²)^1.5, with λ = L/D. The load's Sommerfeld
    number is S λ² = (1 − ε²)²/(π ε √(π² (1 − ε²) + 16 ε²)). Its attitude is tan φ = π √(1 − ε²)/(4 ε).

    Parameters
    ----------
    slenderness : float
        Length over diameter, positive.

    References
    ----------
    .. [1] F. W. Ocvirk, Short-bearing approximation for full journal bearings, NACA TN 2808 (1952).

    Examples
    --------
    >>> film = ocvirk(0.25)(0.4)
    >>> round(film.sommerfeld * 0.25**2, 5), round(math.degrees(film.attitude_rad), 2)
    (0.17046, 60.94)
    """

    def film(ratio: float) -> UnitFilm:
        short = 4.0 * slenderness**2
        rest = 1.0 - ratio**2
        pressure = _pressure(ratio, slenderness)
        return UnitFilm(
            ratio,
            radial=-short * ratio**2 / rest**2,
            tangential=short * math.pi * ratio / (4.0 * rest**1.5),
            radial_slope=-short * 2.0 * ratio * (1.0 + ratio**2) / rest**3,
            tangential_slope=short * math.pi * (1.0 + 2.0 * ratio**2) / (4.0 * rest**2.5),
            radial_squeeze=-short * math.pi * (1.0 + 2.0 * ratio**2) / (2.0 * rest**2.5),
            tangential_squeeze=short * 2.0 * ratio / rest**2,
            side_flow=ratio,
            greatest_pressure=_greatest(ratio, slenderness),
            pressure=pressure,
        )

    return film


def _greatest(ratio: float, slenderness: float) -> float:
    """Return the largest pressure, at cos θ = (1 − √(1 + 24 ε²))/(4 ε) in the middle of the length."""
    cosine = -6.0 * ratio / (1.0 + math.sqrt(1.0 + 24.0 * ratio**2))
    sine = math.sqrt(1.0 - cosine**2)
    return 3.0 * slenderness**2 * ratio * sine / (1.0 + ratio * cosine) ** 3


def _pressure(ratio: float, slenderness: float) -> Pressure:
    around, along = POINTS
    angle, place = np.linspace(0.0, 2.0 * np.pi, around), np.linspace(0.0, 1.0, along)
    middle = 3.0 * slenderness**2 * ratio * np.sin(angle) / (1.0 + ratio * np.cos(angle)) ** 3
    return Pressure(angle, place, np.outer(np.maximum(middle, 0.0), 1.0 - place**2))
