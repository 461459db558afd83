"""Influence coefficients: effect of a unit unbalance in each plane on each reading, by trial weights.

Readings and weights are complex: amplitude and phase of a reading, size and angle of a weight. Readings may
be of any sensors at any speeds, in any unit; the rotor may be flexible. M readings, N planes, N ≤ M.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from autobalance.types import Array, Complex


@dataclass(frozen=True, eq=False)
class Trial:
    """A run with a trial weight in one plane: the weight [g·mm] as a complex number, the readings (M,).

    ``left_on``: the weight stays on the rotor for the following runs.
    """

    plane: int
    weight_g_mm: complex
    readings: Complex
    left_on: bool = False


def changes(initial: Complex, trials: Sequence[Trial]) -> list[Complex]:
    """Return the change of the readings by each trial weight alone, each (M,).

    The reference is the last run whose weight was left on, else the initial readings.
    """
    coefficients, without = [], initial
    for trial in trials:
        coefficients.append(trial.readings - without)
        without = trial.readings if trial.left_on else without
    return coefficients


def influence_coefficients(initial: Complex, trials: Sequence[Trial], planes: int) -> Complex:
    """Return the influence coefficients α, (M, N) complex, reading per g·mm added.

    α_ij = Δ_i/w_j [1]_; where a plane has several trials, the least-squares fit Σ w̄ Δ/Σ|w|².

    Parameters
    ----------
    initial : (M,) complex
        Readings of the rotor without trial weights.
    trials : sequence of Trial
        In the order of their runs; at least one for each plane.
    planes : int
        Number of planes, N.

    References
    ----------
    .. [1] T. P. Goodman, A least-squares method for computing balance corrections, J. Eng. Ind. 86 (1964).

    Examples
    --------
    >>> influence_coefficients(np.array([1.0 + 0j]), [Trial(0, 2.0, np.array([1.0 + 4.0j]))], 1)
    array([[0.+2.j]])
    """
    products = np.zeros((len(initial), planes), dtype=complex)
    squares = np.zeros(planes)
    for trial, change in zip(trials, changes(initial, trials), strict=True):
        products[:, trial.plane] += np.conj(trial.weight_g_mm) * change
        squares[trial.plane] += abs(trial.weight_g_mm) ** 2
    return np.asarray(products / squares, dtype=complex)


def left_on_g_mm(trials: Sequence[Trial], planes: int) -> Complex:
    """Return the sum of the weights left on in each plane, (N,) complex [g·mm]."""
    total = np.zeros(planes, dtype=complex)
    for trial in trials:
        if trial.left_on:
            total[trial.plane] += trial.weight_g_mm
    return total


def condition(influence: Complex, reading_weights: Array) -> tuple[float, Array]:
    """Return σ_max/σ_min of the weighted coefficients, columns scaled to length 1, and the planes' shares.

    Shares (N,) are the magnitudes of the weakest combination of weights: large for planes that the readings
    barely distinguish.
    """
    weighted = reading_weights[:, None] * influence
    lengths = np.linalg.norm(weighted, axis=0)
    if not lengths.all():
        return math.inf, (lengths == 0.0).astype(float)
    _, sizes, right = np.linalg.svd(weighted / lengths, full_matrices=False)
    ratio = math.inf if sizes[-1] == 0.0 else float(sizes[0] / sizes[-1])
    return ratio, np.abs(right[-1])


def least_squares(influence: Complex, initial: Complex, reading_weights: Array) -> Complex:
    """Return the weights (N,) [g·mm] that minimize Σ (v_i |initial_i + (α w)_i|)², without limits."""
    rows: Complex = reading_weights[:, None] * influence
    lengths = np.linalg.norm(rows, axis=0)
    scaled, *_ = np.linalg.lstsq(rows / lengths, -reading_weights * initial, rcond=None)
    solution: Any = scaled / lengths
    return np.asarray(solution, dtype=complex)
