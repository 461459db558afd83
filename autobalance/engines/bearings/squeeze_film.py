"""Squeeze film between parallel rectangular plates: stiffness and damping."""

from __future__ import annotations

import numpy as np

TERMS = np.arange(1.0, 400.0, 2.0)
"""Odd numbers of the series; what is left out is below 1e-11 of its sum."""


def stiffness_N_m(load_N: float, film_m: float) -> float:
    """Return 3 W/H: the slope of a load that goes as H⁻³.

    References
    ----------
    .. [1] Hoem & Røsholm (2016), Eq. 7.4.

    Examples
    --------
    >>> stiffness_N_m(500.0, 2e-5)
    75000000.0
    """
    return 3.0 * load_N / film_m


def uniform_pressure_damping_N_s_m(
    viscosity_Pa_s: float, length_m: float, width_m: float, film_m: float
) -> float:
    """Return 3 η A²/(H³ (Z/L + L/Z)), the source's damping.

    It takes the pressure as uniform over the whole area A = L Z, which makes it 3 times (a strip) to 3.56
    times (a square) what Reynolds' equation gives.

    References
    ----------
    .. [1] Hoem & Røsholm (2016), Eq. 7.5.

    Examples
    --------
    >>> round(uniform_pressure_damping_N_s_m(0.01, 0.02, 0.02, 2e-5))
    300000
    """
    shape = width_m / length_m + length_m / width_m
    return 3.0 * viscosity_Pa_s * (length_m * width_m) ** 2 / (film_m**3 * shape)


def damping_N_s_m(viscosity_Pa_s: float, length_m: float, width_m: float, film_m: float) -> float:
    """Return the damping of a rectangular plate from Reynolds' equation, by its series.

    η a b³/H³ (1 − 192/π⁵ (b/a) Σ tanh(n π a/(2 b))/n⁵), n odd, a the longer side.

    Examples
    --------
    >>> round(damping_N_s_m(0.01, 0.02, 0.02, 2e-5), 3)
    84346.209
    """
    a, b = max(length_m, width_m), min(length_m, width_m)
    series = float(np.sum(np.tanh(TERMS * np.pi * a / (2.0 * b)) / TERMS**5))
    share = 1.0 - 192.0 / np.pi**5 * (b / a) * series
    return float(viscosity_Pa_s * a * b**3 / film_m**3 * share)
