"""Dry journal bearing: Coulomb friction of the whole load, and the coefficient behind a measured torque.

The journal climbs its bush until the reaction is tangent to the friction circle. The line from its centre to
the contact is at the attitude angle φ = atan μ from the load, and the moment is |F| (d/2) sin φ. The usual
|F| (d/2) μ is its small-angle form, 2 % high at μ = 0.2 and without bound above.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from autobalance.types import Array

SMALL_ANGLE_MU = 0.2
"""Coefficient of friction up to which sin φ = tan φ is within 2 %."""


def friction_moment_N_m(load_N: npt.ArrayLike, diameter_m: npt.ArrayLike, mu: npt.ArrayLike) -> Array:
    """Return the friction moment of a dry journal, |F| (d/2) μ/√(1 + μ²).

    Arrays are matched as numpy does, so that loads over a crank angle give moments over it. The mean
    moment of a load that changes belongs to the mean of |F|, not to the equivalent load of life.

    Parameters
    ----------
    load_N : (...) float
        Magnitude of the load [N].
    diameter_m : (...) float
        Of the journal [m].
    mu : (...) float
        Coefficient of friction, not negative.

    Returns
    -------
    (...) float
        Moment against the turning [N·m].

    References
    ----------
    .. [1] Hoem & Røsholm (2016), Eq. 4.9 and 4.10.

    Examples
    --------
    >>> round(float(friction_moment_N_m(25.01, 0.020, 0.7773)), 9)
    0.153487758
    """
    coefficient = np.asarray(mu, float)
    return small_angle_moment_N_m(load_N, diameter_m, coefficient / np.sqrt(1.0 + coefficient**2))


def small_angle_moment_N_m(load_N: npt.ArrayLike, diameter_m: npt.ArrayLike, mu: npt.ArrayLike) -> Array:
    """Return |F| (d/2) μ: the moment where μ is small (up to ``SMALL_ANGLE_MU``)."""
    return np.asarray(0.5 * np.asarray(load_N, float) * np.asarray(diameter_m, float) * np.asarray(mu, float))


def small_angle_mu(moment_N_m: float, load_N: float, diameter_m: float) -> float:
    """Return T/(F d/2): sin φ, which is taken for μ where it is small.

    References
    ----------
    .. [1] Hoem & Røsholm (2016), Eq. 5.1 and Table 5.5.

    Examples
    --------
    >>> round(small_angle_mu(0.1944, 25.01, 0.020), 4)
    0.7773
    """
    return 2.0 * moment_N_m / (load_N * diameter_m)


def mu_of_moment(moment_N_m: float, load_N: float, diameter_m: float) -> float | None:
    """Return the coefficient of friction tan asin(T/(F d/2)); None if no Coulomb friction explains T.

    A moment above F d/2 needs sin φ > 1: part of it does not come from the load, as in a rolling bearing.

    Examples
    --------
    >>> round(mu_of_moment(0.153487758, 25.01, 0.020), 4)
    0.7773
    >>> mu_of_moment(0.3194, 25.01, 0.020) is None
    True
    """
    sine = small_angle_mu(moment_N_m, load_N, diameter_m)
    return sine / math.sqrt((1.0 - sine) * (1.0 + sine)) if sine < 1.0 else None


def attitude_angle_rad(mu: float) -> float:
    """Return the angle between the load and the line to the contact, atan μ [rad]."""
    return math.atan(mu)
