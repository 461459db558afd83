"""Correction weights under limits: the least squares or the least worst residual, a convex cone program.

A primal barrier method with Newton steps: a few dozen small linear systems, and the distance to the optimum
is bounded by the number of cones over the barrier's weight, so the accuracy is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from autobalance.test_stands.influence.influence_coefficients import least_squares
from autobalance.types import Array, Complex

Goal = Literal["least_squares", "least_worst"]

GAP = {"least_squares": 1e-11, "least_worst": 1e-8}
"""Distance to the optimum of the sum of squares or the worst, with readings scaled to a largest of 1."""
GROWTH = 8.0
"""Factor on the barrier's weight from one centre to the next."""
NEWTON_STEPS = 60
DECREMENT = 1e-9
"""Half the squared Newton decrement at a sufficient centre."""


@dataclass(frozen=True, eq=False)
class Cones:
    """Second-order cones |B x + c| ≤ d·x + e: B (k, 2, n), c (k, 2), d (k, n), e (k,)."""

    B: Array
    c: Array
    d: Array
    e: Array

    def slack(self, x: Array) -> tuple[Array, Array, Array]:
        """Return (d·x + e)² − |B x + c|², positive inside, with both its parts: (k,), (k, 2), (k,)."""
        inner = self.B @ x + self.c
        bound = self.d @ x + self.e
        return bound**2 - (inner**2).sum(axis=1), inner, bound


def limited_weights(
    influence: Complex, initial: Complex, reading_weights: Array, limits_g_mm: Array, goal: Goal
) -> Complex:
    """Return the weights (N,) [g·mm] that minimize the residual within limits.

    Parameters
    ----------
    influence : (M, N) complex
        Reading per g·mm added.
    initial : (M,) complex
        Readings to reduce.
    reading_weights : (M,) float
        v, importance of each reading.
    limits_g_mm : (N,) float
        Largest size of each plane's weight; inf: no limit.
    goal : str
        ``least_squares``: Σ (v_i |r_i|)²; ``least_worst``: max v_i |r_i|.

    Returns
    -------
    (N,) complex
        Optimal to 1e-8 of the largest v_i |initial_i| for the worst residual, 1e-11 of its square
        for the sum.
    """
    free = least_squares(influence, initial, reading_weights)
    scale = float(np.abs(reading_weights * initial).max())
    if scale == 0.0:
        return np.zeros_like(free)
    left = np.abs(reading_weights * (initial + influence @ free)).max()
    within = (np.abs(free) <= limits_g_mm).all()
    if within and (goal == "least_squares" or left <= GAP[goal] * scale):
        return free
    rows = reading_weights[:, None] * influence / scale
    lengths = np.linalg.norm(rows, axis=0)
    start = reading_weights * initial / scale
    x = _solve(rows / lengths, start, limits_g_mm * lengths, goal)
    solution: Complex = (x[0::2] + 1j * x[1::2]) / lengths
    return solution


def _solve(matrix: Complex, start: Complex, limits: Array, goal: Goal) -> Array:
    """Return real and imaginary parts of the scaled weights, alternating (2 N,)."""
    planes = matrix.shape[1]
    worst = goal == "least_worst"
    size = 2 * planes + (1 if worst else 0)
    readings = np.zeros((len(start), 2, size))
    readings[:, :, : 2 * planes] = _real(matrix)
    offset = np.stack([start.real, start.imag], axis=1)
    cones = _limits(limits, size)
    hessian, gradient = np.zeros((size, size)), np.zeros(size)
    x = np.zeros(size)
    if worst:
        bound = np.zeros((len(start), size))
        bound[:, -1] = 1.0
        cones = _joined(Cones(readings, offset, bound, np.zeros(len(start))), cones)
        gradient[-1] = 1.0
        x[-1] = 2.0
    else:
        flat = readings.reshape(-1, size)
        hessian, gradient = 2.0 * flat.T @ flat, 2.0 * flat.T @ offset.ravel()
    return _barrier(hessian, gradient, cones, x, GAP[goal])[: 2 * planes]


def _real(matrix: Complex) -> Array:
    """Return complex coefficients as real ones (M, 2, 2 N), with real and imaginary columns alternating."""
    real = np.zeros((matrix.shape[0], 2, 2 * matrix.shape[1]))
    real[:, 0, 0::2], real[:, 0, 1::2] = matrix.real, -matrix.imag
    real[:, 1, 0::2], real[:, 1, 1::2] = matrix.imag, matrix.real
    return real


def _limits(limits: Array, size: int) -> Cones:
    """Return |w_j| ≤ limit_j for the planes with a limit."""
    which = np.flatnonzero(np.isfinite(limits))
    B = np.zeros((len(which), 2, size))
    for row, plane in enumerate(which):
        B[row, 0, 2 * plane] = B[row, 1, 2 * plane + 1] = 1.0
    return Cones(B, np.zeros((len(which), 2)), np.zeros((len(which), size)), limits[which])


def _joined(a: Cones, b: Cones) -> Cones:
    return Cones(
        np.concatenate([a.B, b.B]),
        np.concatenate([a.c, b.c]),
        np.concatenate([a.d, b.d]),
        np.concatenate([a.e, b.e]),
    )


def _barrier(hessian: Array, gradient: Array, cones: Cones, x: Array, gap: float) -> Array:
    """Return the minimum of ½ xᵀHx + gᵀx inside the cones, from a point strictly inside."""
    weight, last = 1.0, 2.0 * len(cones.e) / gap
    while True:
        x = _centre(weight * hessian, weight * gradient, cones, x)
        if weight >= last:
            return x
        weight = min(GROWTH * weight, last)


def _centre(hessian: Array, gradient: Array, cones: Cones, x: Array) -> Array:
    """Return the minimum of a quadratic − Σ log(slack), by damped Newton steps."""
    for _ in range(NEWTON_STEPS):
        slack, inner, bound = cones.slack(x)
        slopes = 2.0 * (bound[:, None] * cones.d - np.einsum("ki,kin->kn", inner, cones.B)) / slack[:, None]
        curved = cones.B / np.sqrt(slack)[:, None, None]
        lines = cones.d / np.sqrt(slack)[:, None]
        H = (
            hessian
            + slopes.T @ slopes
            + 2.0 * np.einsum("kin,kim->nm", curved, curved)
            - 2.0 * lines.T @ lines
        )
        g = hessian @ x + gradient - slopes.sum(axis=0)
        step = -np.linalg.lstsq(H, g, rcond=None)[0]
        decrement = float(-g @ step)
        if decrement <= 2.0 * DECREMENT:
            return x
        x = x + _length(cones, x, step, decrement) * step
    return x


def _length(cones: Cones, x: Array, step: Array, decrement: float) -> float:
    """Return the length of a step: the damped step of self-concordant functions, never out of a cone."""
    length = 1.0 / (1.0 + np.sqrt(decrement)) if decrement > 0.0625 else 1.0
    while True:
        slack, _, bound = cones.slack(x + length * step)
        if (slack > 0.0).all() and (bound >= 0.0).all():
            return float(length)
        length *= 0.5
