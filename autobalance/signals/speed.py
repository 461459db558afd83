"""Speed of the shaft from the record itself: the comb of orders in its spectrum.

Pieces of the record are compared with combs of orders at every possible speed; the best course through
them, without jumps, is a first speed. Then the phases of the strong orders correct the angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from autobalance.signals.order_lines import CYCLE, fit_between, whole_cycles
from autobalance.signals.record import Channel
from autobalance.signals.turning import TURN, Turning
from autobalance.types import Array

PIECE_S = 1.0
LEAST_HZ, MOST_HZ = 3.0, 400.0
ORDER_WEIGHTS = {
    0.5: 0.25,
    1.0: 1.0,
    1.5: 0.25,
    2.0: 0.7,
    2.5: 0.2,
    3.0: 0.4,
    4.0: 0.4,
    5.0: 0.2,
    6.0: 0.25,
    8.0: 0.2,
}
"""Order → weight of its amplitude for a speed, falling, or half the speed would fit as well."""
PER_OCTAVE = 240
MOST_PIECES = 600
JUMP_COST = 0.03
"""Loss of the course's score for a step of the speed's grid from piece to piece."""
ROUNDS = 4
STANDS_OUT = 8.0


@dataclass(frozen=True, eq=False)
class RecordSpeed:
    """Angle from the record itself, and the standard uncertainty of its mean speed [1/min]."""

    turning: Turning
    uncertainty_rpm: float


def speed_of_record(channel: Channel) -> RecordSpeed | None:
    """Return the speed by a record's orders; None where it shows no comb of them.

    A comb of order 1, 2, 3 at a speed is one of ½, 1, 1½ at its double: the one with a strong first order is
    taken.
    """
    rough = _rough_course(channel)
    if rough is None:
        return None
    times, frequencies = rough
    angles = (
        np.concatenate([[0.0], np.cumsum(0.5 * (frequencies[1:] + frequencies[:-1]) * np.diff(times))]) * TURN
    )
    turning = Turning(times, angles)
    scatter = moved = np.inf
    for _ in range(ROUNDS):
        corrected = _corrected(channel, turning)
        if corrected is None:
            return None
        moved = abs(corrected[0].mean_rpm - turning.mean_rpm)
        turning, scatter = corrected
    duration = turning.end_s - turning.start_s
    ends_rpm = float(scatter) * np.sqrt(2.0) / TURN / duration * 60.0
    return RecordSpeed(turning, max(ends_rpm, moved))


def _rough_course(channel: Channel) -> tuple[Array, Array] | None:
    """Return times over the whole record and the frequencies of order 1 there, None if too short."""
    rate = channel.sample_rate_hz
    length = min(len(channel), int(PIECE_S * rate))
    if length < 64:
        return None
    count = max(1, min(MOST_PIECES, 4 * (len(channel) - length) // length + 1))
    starts = np.round(np.linspace(0, len(channel) - length, count)).astype(int)
    padded = fft.next_fast_len(4 * length)
    least, most = max(LEAST_HZ, 3.0 * rate / length), min(MOST_HZ, 0.2 * rate)
    if most <= least:
        return None
    grid = least * 2.0 ** (np.arange(int(np.log2(most / least) * PER_OCTAVE) + 1) / PER_OCTAVE)
    weights = np.hanning(length)
    scores, clear = np.zeros((count, len(grid))), 0
    for row, start in enumerate(starts):
        piece = channel.values(start, start + length)
        size = np.abs(fft.rfft((piece - piece.mean()) * weights, padded))
        clear += bool(size.max() > STANDS_OUT * np.median(size) > 0.0)
        scores[row] = _comb(size, grid * (padded / rate))
    if clear < 0.5 * count:
        return None
    course = grid[_best_course(scores)]
    times = (starts + 0.5 * length) / rate
    ends = np.array([0.0, channel.duration_s])
    if count == 1:
        return ends, np.array([course[0], course[0]])
    # Straight on to the record's ends, half a piece away.
    front = (
        course[0] - (course[min(4, count - 1)] - course[0]) / (times[min(4, count - 1)] - times[0]) * times[0]
    )
    back = course[-1] + (course[-1] - course[-min(5, count)]) / (times[-1] - times[-min(5, count)]) * (
        ends[1] - times[-1]
    )
    edges = np.maximum([front, back], 0.5 * course.min())
    return np.concatenate([[0.0], times, ends[1:]]), np.concatenate([edges[:1], course, edges[1:]])


def _comb(size: Array, bins: Array) -> Array:
    """Return the fit of combs with order 1 at bins to a spectrum, 0 to about 1."""
    level = np.sqrt(size / size.max()) if size.max() > 0.0 else size
    places = np.arange(len(level))
    return sum(
        (
            weight * np.interp(order * bins, places, level, right=0.0)
            for order, weight in ORDER_WEIGHTS.items()
        ),
        np.zeros(len(bins)),
    )


def _best_course(scores: Array) -> NDArray[np.intp]:
    """Return each row's column on the path of the largest sum of scores less the cost of its steps."""
    rows, columns = scores.shape
    reach = 24
    total = scores[0].copy()
    came = np.zeros((rows, columns), dtype=np.intp)
    moves = np.arange(-reach, reach + 1)
    for row in range(1, rows):
        padded = np.pad(total, reach, constant_values=-np.inf)
        options = np.stack([padded[reach + m : reach + m + columns] - JUMP_COST * abs(m) for m in moves])
        best = np.argmax(options, axis=0)
        came[row] = np.arange(columns) + moves[best]
        total = options[best, np.arange(columns)] + scores[row]
    path = np.zeros(rows, dtype=np.intp)
    path[-1] = int(np.argmax(total))
    for row in range(rows - 1, 0, -1):
        path[row - 1] = came[row, path[row]]
    return path


def _corrected(channel: Channel, turning: Turning) -> tuple[Turning, float] | None:
    """Return the angle corrected by its orders' phases, and their scatter about it [rad]; None on failure."""
    cycles = whole_cycles(turning)
    if cycles < 3:
        return None
    pieces = min(cycles, max(3, int(2.0 * (turning.end_s - turning.start_s) / PIECE_S)), 400)
    edges = CYCLE * np.unique(np.round(np.linspace(0, cycles, pieces + 1)))
    top = min(8.0, 0.45 * channel.sample_rate_hz / (turning.speeds_rpm().max() / 60.0))
    if top < 1.0:
        return None
    lines = fit_between(channel, turning, int(2 * top), edges)
    strength = np.median(np.abs(lines.blocks), axis=0)
    leader = int(np.argmax(strength))
    middles = 0.5 * (edges[1:] + edges[:-1])
    # An order's amplitude c e^(i k δ) turns by kδ when the true angle is δ ahead.
    ahead = np.unwrap(np.angle(lines.blocks[:, leader])) / lines.orders[leader]
    ahead = ahead - ahead[0]
    smooth = _low_passed(ahead)
    scatter = float(np.std(ahead - smooth))
    full = np.interp(turning.angles_rad, middles, smooth)
    slope = (
        (smooth[1] - smooth[0]) / (middles[1] - middles[0]),
        (smooth[-1] - smooth[-2]) / (middles[-1] - middles[-2]),
    )
    full += np.where(turning.angles_rad < middles[0], slope[0] * (turning.angles_rad - middles[0]), 0.0)
    full += np.where(turning.angles_rad > middles[-1], slope[1] * (turning.angles_rad - middles[-1]), 0.0)
    angles = turning.angles_rad + full
    if (np.diff(angles) <= 0.0).any():
        return None
    return Turning(turning.times_s, angles - angles[0]), scatter


def _low_passed(values: Array) -> Array:
    """Return values smoothed over a few neighbours by a moving parabola."""
    from scipy.signal import savgol_filter

    width = min(7, len(values) - (len(values) + 1) % 2)
    return values if width < 5 else np.asarray(savgol_filter(values, width, 2))
