"""Equal steps of a linear train under given torques, however stiff its shafts are.

A step of M ẍ + C ẋ + K x = f is e^{A h} y + ∫ e^{A (h − s)} b(s) ds, y the angles and their rates. The
torques are polynomials through the Gauss points of the step. Their integrals with the exponential are exact,
because a sum of weights at the points would miss modes that swing many times in a step.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.linalg import expm

from autobalance.types import Array

GAUSS_PLACES = tuple(0.5 + 0.5 * np.polynomial.legendre.leggauss(4)[0])


def exact_steps(
    mass: Array,
    damping: Array,
    stiffness: Array,
    torque_at: Callable[[Array], Array],
    start: Array,
    time_s: Array,
) -> Array:
    """Return angles and rates (n, 2 q) at equally spaced times (n,).

    Parameters
    ----------
    mass : (q,) float
        Inertias [kg·m²].
    damping, stiffness : (q, q) float
        [N·m·s/rad, N·m/rad].
    torque_at : callable
        Times (k,) [s] → torques (k, q) [N·m].
    start : (2 q,) float
        Angles [rad] and rates [rad/s] at the first time.

    References
    ----------
    Hochbruck and Ostermann 2010, Acta Numerica 19, 209–286: exponential quadrature rules.
    """
    count, step = len(mass), float(time_s[1] - time_s[0])
    root = np.sqrt(mass)
    # angles in units that make both halves of the matrix as large as the fastest frequency: without that the
    # exponential of a stiff train loses its digits
    fastest = math.sqrt(max(float(np.linalg.eigvalsh(stiffness / np.outer(root, root))[-1]), step**-2))
    scale = np.concatenate([fastest * root, root])
    matrix = np.block(
        [
            [np.zeros((count, count)), fastest * np.eye(count)],
            [-stiffness / np.outer(root, root) / fastest, -damping / np.outer(root, root)],
        ]
    )
    through, weights = _through_a_step(matrix * step)
    forced = np.zeros((len(time_s) - 1, 2 * count))
    for place, weight in zip(GAUSS_PLACES, weights, strict=True):
        forced += step * (torque_at(time_s[:-1] + place * step) / root) @ weight[:, count:].T
    state = np.zeros((len(time_s), 2 * count))
    state[0] = here = start * scale
    for row, added in enumerate(forced, 1):
        state[row] = here = through @ here + added
    return np.asarray(state / scale)


def _through_a_step(matrix: Array) -> tuple[Array, list[Array]]:
    """Return e^A and, for each Gauss point, ∫₀¹ e^{A (1 − u)} ℓ(u) du of its polynomial ℓ."""
    size, points = len(matrix), len(GAUSS_PLACES)
    whole = np.zeros(((points + 1) * size, (points + 1) * size))
    whole[:size, :size] = matrix
    for k in range(points):  # columns of blocks: ∫ e^{A (1 − u)} u^k/k! du
        whole[k * size : (k + 1) * size, (k + 1) * size : (k + 2) * size] = np.eye(size)
    top = expm(whole)[:size]
    integrals = [math.factorial(k) * top[:, (k + 1) * size : (k + 2) * size] for k in range(points)]
    coefficients = np.linalg.inv(np.vander(GAUSS_PLACES, increasing=True))  # (power, point)
    weights = [
        np.asarray(sum(coefficients[k, point] * integrals[k] for k in range(points)))
        for point in range(points)
    ]
    return top[:, :size], weights
