"""Means of a load with a constant part and a part that turns with the shaft.

On the journal they add to |F(θ)| = √(W² + R² + 2 W R cos θ), an ellipse's arc length: the means over a turn
are complete elliptic integrals of m = 4 W R/(W + R)².
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.special import ellipe, ellipkm1

Array = npt.NDArray[np.float64]


def mean_load_N(constant_N: npt.ArrayLike, rotating_N: npt.ArrayLike) -> Array:
    """Return the mean of |F| over a turn: what the friction of a dry bearing follows.

    (2/π) (W + R) E(m).

    Parameters
    ----------
    constant_N, rotating_N : (...) float
        The part that is still, and the one that turns with the shaft, not negative [N].

    Returns
    -------
    (...) float
        Mean of the magnitude [N].

    Examples
    --------
    >>> round(float(mean_load_N(1.0, 1.0)) / 2.0, 9)
    0.636619772
    """
    constant, rotating = np.asarray(constant_N, float), np.asarray(rotating_N, float)
    return np.asarray(2.0 / np.pi * (constant + rotating) * ellipe(1.0 - _apart(constant, rotating)))


def cubic_mean_load_N(constant_N: npt.ArrayLike, rotating_N: npt.ArrayLike) -> Array:
    """Return the cubic mean of |F| over a turn: the load of a ball bearing's fatigue life.

    The mean of |F|³ is (2/π) (W + R)³ (2 (2 − m) E(m) − (1 − m) K(m))/3.

    Examples
    --------
    >>> round(float(cubic_mean_load_N(1.0, 1.0)) / 2.0, 9)
    0.751501101
    """
    constant, rotating = np.asarray(constant_N, float), np.asarray(rotating_N, float)
    apart = _apart(constant, rotating)  # 1 − m
    first = apart * ellipkm1(np.maximum(apart, np.finfo(float).tiny))
    cube = 2.0 / np.pi * (2.0 * (1.0 + apart) * ellipe(1.0 - apart) - first) / 3.0
    return np.asarray((constant + rotating) * np.cbrt(cube))


def equivalent_load_N(constant_N: npt.ArrayLike, rotating_N: npt.ArrayLike) -> Array:
    """Return the equivalent load of a rolling bearing's life, (W² + W R + R²)/(W + R).

    It is within 0.42 % of (W + R) of the cubic mean. For life, never for friction: where both parts are
    of one size it is 18 % above the mean of |F|.

    References
    ----------
    .. [1] Hoem & Røsholm (2016), Eq. 4.13 and 4.14; the second bracket is misprinted there and must be
       F_w/(F_w + F_i).

    Examples
    --------
    >>> float(equivalent_load_N(1.0, 1.0)) / 2.0
    0.75
    """
    constant, rotating = np.asarray(constant_N, float), np.asarray(rotating_N, float)
    total = constant + rotating
    safe = np.where(total > 0.0, total, 1.0)
    return np.asarray((constant**2 + constant * rotating + rotating**2) / safe)


def _apart(constant: Array, rotating: Array) -> Array:
    """Return 1 − m = ((W − R)/(W + R))², 1 without any load."""
    total = constant + rotating
    safe = np.where(total > 0.0, total, 1.0)
    return np.where(total > 0.0, ((constant - rotating) / safe) ** 2, 1.0)
