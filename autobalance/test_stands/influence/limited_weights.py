"""Influence coefficients from readings with trial weights, and correction weights under limits."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from autobalance.declare import POSITIVE, keys_of, made
from autobalance.errors import AutobalanceError, JobError
from autobalance.toml_files.keys import read
from autobalance.types import Array, Complex
from autobalance.units import wrapped_deg
from autobalance.value_classes import dataclass

# Influence coefficients: effect of a unit unbalance in each plane on each reading, by trial weights.
#
# Readings and weights are complex: amplitude and phase of a reading, size and angle of a weight. Readings
# may be of any sensors at any speeds, in any unit; the rotor may be flexible. M readings, N planes, N ≤ M.


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


# Correction weights under limits: the least squares or the least worst residual, a convex cone program.
#
# A primal barrier method with Newton steps: a few dozen small linear systems, and the distance to the
# optimum is bounded by the number of cones over the barrier's weight, so the accuracy is known.


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


# Readings of a trials file taken from recorded signals: an order's amplitude and phase at each sensor.


@dataclass(frozen=True)
class Records:
    """``[records]``: how records give readings."""

    channels: Annotated[tuple[str, ...], "sensors, in the order of the readings"]
    tacho: Annotated[str, "channel with one pulse a turn, from which phases count"]
    threshold: Annotated[float | None, "level that its pulses rise through (midway)"] = None
    sample_rate: Annotated[float | None, POSITIVE, "sample rate, if the files state no rate [Hz]"] = None
    order: Annotated[float, POSITIVE, "order of the readings"] = 1.0


RECORDS_KEYS = keys_of(Records)


def with_recorded_readings(values: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the tables of a trials file with its records as numbers.

    ``initial`` and ``readings`` of a trial may name a record, or a list of them (one a speed): each gives a
    reading for every channel of ``[records]``.

    Parameters
    ----------
    values : mapping
        As TOML is parsed.
    folder : Path
        The records are relative to it.

    Raises
    ------
    JobError
        If a record cannot be read, or has no such order; it names the key.
    """
    places: list[tuple[str, Any]] = [("initial", values.get("initial"))]
    trials = values.get("trial")
    runs = trials if isinstance(trials, list) else []
    places += [
        (f"trial[{number}].readings", run.get("readings"))
        for number, run in enumerate(runs, 1)
        if isinstance(run, Mapping)
    ]
    named = [where for where, reading in places if _files(reading)]
    if not named:
        return dict(values)
    if not isinstance(values.get("records"), Mapping):
        raise JobError(
            f"records is missing; {named[0]} names a record: [records] must name its channels and tacho"
        )
    records = made(Records, read(values["records"], RECORDS_KEYS, "records"))
    if not records.channels:
        raise JobError("records.channels is an empty list; must name at least one sensor")
    changed = dict(values)
    if "initial" in values:
        changed["initial"] = _taken(values["initial"], "initial", records, folder)
    if runs:
        changed["trial"] = [
            {**run, "readings": _taken(run["readings"], f"trial[{number}].readings", records, folder)}
            if isinstance(run, Mapping) and "readings" in run
            else run
            for number, run in enumerate(runs, 1)
        ]
    return changed


def _files(reading: Any) -> list[str]:
    """Return the records that a value names; none where it is numbers."""
    if isinstance(reading, str):
        return [reading]
    named = isinstance(reading, list) and bool(reading) and all(isinstance(each, str) for each in reading)
    return list(reading) if named else []


def _taken(reading: Any, where: str, records: Records, folder: Path) -> Any:
    files = _files(reading)
    if not files:
        return reading
    return [
        list(_reading(folder / file, name, records, where)) for file in files for name in records.channels
    ]


def _reading(file: Path, channel: str, records: Records, where: str) -> tuple[float, float]:
    """Return amplitude and phase [°] of an order at a sensor."""
    from autobalance.signals.analysis import AnalysisOptions, analyse
    from autobalance.signals.formats import read as read_record

    order = records.order
    try:
        analysis = analyse(
            read_record(file, records.sample_rate),
            AnalysisOptions(
                channel=channel,
                tacho=records.tacho,
                threshold=records.threshold,
                max_order=max(order, 1.0),
                peaks=0,
            ),
        )
    except AutobalanceError as error:
        raise JobError(f"{where}: {error}") from None
    orders = () if analysis.lines is None else analysis.lines.orders.tolist()
    if analysis.lines is None or order not in orders:
        raise JobError(
            f"{where}: {file.name} has no order {order:g}; expected a half or whole one of a few turns"
        )
    value = complex(analysis.lines.amplitudes[orders.index(order)])
    if not cmath.isfinite(value):
        raise JobError(f"{where}: {file.name} has no order {order:g}: it passes half the sample rate")
    return abs(value), wrapped_deg(math.degrees(cmath.phase(value)))
