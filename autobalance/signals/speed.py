"""Orders of a record: speed, lines, maps over time."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from autobalance.signals.by_angle import TURN, Turning, by_angle, samples_per_turn
from autobalance.signals.record import Channel, gain, window
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# Orders of a record: cos and sin of every half order fitted to the samples by the shaft's own angle.
#
# x ≈ a₀ + Σ Re(c_k e^(ikθ)), k = ½, 1, 1½, …: weighted least squares with the weight dθ = θ̇ dt, over an
# even number of whole turns. There the waves are almost orthogonal, so that this is the Fourier integral by
# angle; as a fit, it is also exact where the turns hold no whole number of samples. No resampling is needed,
# hence no filter and no ends. The normal equations hold only the sums Σ w e^(imθ/2) and Σ w x e^(−imθ/2),
# which are accumulated block by block.


CYCLE = 2.0 * TURN
"""Period of the half orders: two turns."""
CHUNK = 1 << 12
"""Samples processed at a time: their waves stay in the processor's cache."""
MOST_BLOCKS = 32


@dataclass(frozen=True, eq=False)
class OrderLines:
    """Complex amplitudes A e^(iφ) by half order, from ½ on.

    ``blocks`` (b, n) are the amplitudes of equal pieces of the record, of whole cycles each; ``angles_rad``
    are the pieces' edges.
    """

    amplitudes: Complex
    blocks: Complex
    angles_rad: Array

    @property
    def orders(self) -> Array:
        """Return the orders ½, 1, … (n,)."""
        return np.asarray(0.5 * np.arange(1, len(self.amplitudes) + 1), dtype=float)

    @property
    def turns(self) -> int:
        """Return the number of whole turns of the fit."""
        return round(float(self.angles_rad[-1] - self.angles_rad[0]) / TURN)

    def standard_errors(self) -> Array:
        """Return the standard error of each amplitude's real and imaginary part, from the pieces (n,)."""
        count = len(self.blocks)
        if count < 3:
            return np.full(len(self.amplitudes), np.nan)
        spread = self.blocks - self.blocks.mean(axis=0)
        return np.asarray(np.sqrt((np.abs(spread) ** 2).sum(axis=0) / (2.0 * (count - 1) * count)))


def whole_cycles(turning: Turning) -> int:
    """Return the number of pairs of turns from angle 0 on."""
    return int(np.floor(turning.angles_rad[-1] / CYCLE + 1e-9))


def order_lines(channel: Channel, turning: Turning, max_order: float) -> OrderLines | None:
    """Return the half orders over the largest even number of whole turns; None with fewer than two.

    Parameters
    ----------
    channel : Channel
        Samples without gaps.
    turning : Turning
        The shaft's angle by the same clock.
    max_order : float
        Highest order [-].
    """
    cycles = whole_cycles(turning)
    if cycles < 1:
        return None
    edges = CYCLE * np.unique(np.round(np.linspace(0, cycles, min(cycles, MOST_BLOCKS) + 1)))
    return fit_between(channel, turning, round(2 * max_order), edges)


def fit_between(channel: Channel, turning: Turning, count: int, edges_rad: Array) -> OrderLines:
    """Return ``count`` half orders, fitted between the first and last edge and in each piece.

    Parameters
    ----------
    edges_rad : (b + 1,) array
        Angles, ascending, whole cycles apart [rad].
    """
    sums = [_sums(channel, turning, count, low, high) for low, high in pairwise(edges_rad)]
    waves, sights = np.array([s for s, _ in sums]), np.array([r for _, r in sums])
    whole = _solved(waves.sum(axis=0), sights.sum(axis=0))
    pieces = np.array([_solved(s, r) for s, r in sums])
    return OrderLines(whole, pieces, edges_rad)


def _sums(channel: Channel, turning: Turning, count: int, low: float, high: float) -> tuple[Complex, Complex]:
    """Return Σ w e^(imθ/2), m = 0 … 2n, and Σ w x e^(−imθ/2), m = 0 … n, between two angles."""
    rate = channel.sample_rate_hz
    start, stop = turning.time_s(np.array([low, high])) * rate
    # An edge on a sample belongs to the piece after it, whatever rounding says.
    first, last = (int(np.ceil(edge - 1e-6)) for edge in (start, stop))
    last = min(last, len(channel))
    waves, sights = np.zeros(2 * count + 1, dtype=complex), np.zeros(count + 1, dtype=complex)
    for place in range(first, last, CHUNK):
        end = min(place + CHUNK, last)
        times = np.arange(place, end) / rate
        weights = turning.speed_rad_s(times) / rate
        both = np.stack([weights, weights * channel.values(place, end)])
        wave = np.exp(0.5j * turning.angle_rad(times))
        powers = np.ones((2 * count + 1, len(times)), dtype=complex)
        for m in range(2 * count):
            np.multiply(powers[m], wave, out=powers[m + 1])
        sums = both @ powers.real.T + 1j * (both @ powers.imag.T)
        waves += sums[0]
        sights += np.conj(sums[1, : count + 1])
    return waves, sights


def _solved(waves: Complex, sights: Complex) -> Complex:
    """Return the amplitudes (n,), the solution of the normal equations."""
    n = len(sights) - 1
    m = np.arange(n + 1)
    apart, together = waves[np.abs(m[:, None] - m)], waves[m[:, None] + m]
    flip = np.where(m[:, None] >= m, 1.0, -1.0)
    # cos cos, sin sin and sin(row) cos(column), from sums and differences of the angles.
    cos_cos = 0.5 * (together.real + apart.real)
    sin_sin = 0.5 * (apart.real - together.real)
    sin_cos = 0.5 * (together.imag + flip * apart.imag)
    matrix = np.block([[cos_cos, sin_cos.T[:, 1:]], [sin_cos[1:], sin_sin[1:, 1:]]])
    right = np.concatenate([sights.real, -sights.imag[1:]])
    solution = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
    return np.asarray(solution[1 : n + 1] - 1j * solution[n + 1 :])


# Speed of the shaft from the record itself: the comb of orders in its spectrum.
#
# Pieces of the record are compared with combs of orders at every possible speed; the best course through
# them, without jumps, is a first speed. Then the phases of the strong orders correct the angle.


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


# Spectra over time: the waterfall in hertz, the map in orders, and cuts through it with phase.


MOST_ROWS = 400
WATERFALL_BINS = 1024
MAP_TURNS = 16
"""Turns in a row of the order map: its lines are 1/16 of an order apart."""


@dataclass(frozen=True, eq=False)
class Map:
    """Amplitudes (rows, columns); each row is a time (and speed), each column a frequency or order."""

    times_s: Array
    speeds_rpm: Array | None
    columns: Array
    amplitudes: Array


@dataclass(frozen=True, eq=False)
class OrderCut:
    """One order along the record: complex amplitudes (n,) at speeds (n,)."""

    order: float
    times_s: Array
    speeds_rpm: Array
    amplitudes: Complex


def waterfall(channel: Channel, window_name: str, top_hz: float, turning: Turning | None = None) -> Map:
    """Return amplitude spectra of pieces of the record, overlapping by half unless it is very long.

    Parameters
    ----------
    top_hz : float
        Highest frequency of the map [Hz].
    turning : Turning or None
        Source of each row's speed.
    """
    rate = channel.sample_rate_hz
    length = min(
        len(channel), 1 << int(np.round(np.log2(max(16.0, WATERFALL_BINS * rate / max(top_hz, 1.0)))))
    )
    steps = max(1, min(MOST_ROWS, 2 * (len(channel) - length) // length + 1))
    starts = np.round(np.linspace(0, len(channel) - length, steps)).astype(int)
    weights = window(window_name, length) * (2.0 / (length * gain(window_name)))
    columns = fft.rfftfreq(length, 1.0 / rate)
    kept = columns <= top_hz
    rows = np.zeros((steps, int(kept.sum())))
    for row, start in enumerate(starts):
        rows[row] = np.abs(fft.rfft(channel.values(start, start + length) * weights))[kept]
    rows[:, 0] *= 0.5
    times = (starts + 0.5 * length) / rate
    speeds = None
    if turning is not None:
        within = np.clip(times, turning.start_s, turning.end_s)
        speeds = turning.speed_rad_s(within) * (60.0 / TURN)
    return Map(times, speeds, columns[kept], rows)


def order_map(channel: Channel, turning: Turning, max_order: float) -> Map | None:
    """Return spectra by angle, orders by columns, speeds by rows; None where the record is too short.

    The record is read once, in blocks; only the map and one block are in memory.
    """
    turns = int(np.floor(turning.angles_rad[-1] / TURN + 1e-9))
    of_row = min(MAP_TURNS, turns - turns % 2)
    if of_row < 2:
        return None
    per_turn = samples_per_turn(max_order)
    length = of_row * per_turn
    rows = int(max(1, min(MOST_ROWS, 2 * (turns - of_row) // of_row + 1)))
    starts = np.round(np.linspace(0, turns - of_row, rows)).astype(int) * per_turn
    columns = np.arange(round(max_order * of_row) + 1) / of_row
    weights = window("hann", length) * (2.0 / (length * gain("hann")))
    amplitudes = np.zeros((rows, len(columns)))
    held, at, row = np.zeros(0), 0, 0
    for piece in by_angle(channel, turning, per_turn, max_order, turns):
        held = np.concatenate([held, piece])
        while row < rows and starts[row] + length <= at + len(held):
            values = held[starts[row] - at : starts[row] - at + length]
            amplitudes[row] = np.abs(fft.rfft(values * weights))[: len(columns)]
            row += 1
        drop = min((starts[row] if row < rows else at + len(held)) - at, len(held))
        held, at = held[drop:], at + drop
    amplitudes[:, 0] *= 0.5
    middles = turning.time_s((starts / per_turn + 0.5 * of_row) * TURN)
    return Map(middles, turning.speed_rad_s(middles) * (60.0 / TURN), columns, amplitudes)


def order_cuts(channel: Channel, turning: Turning, max_order: float) -> list[OrderCut]:
    """Return every half order along the record, each point fitted over whole cycles."""
    cycles = whole_cycles(turning)
    if cycles < 1:
        return []
    edges = CYCLE * np.unique(np.round(np.linspace(0, cycles, min(cycles, MOST_ROWS) + 1)))
    lines = fit_between(channel, turning, round(2 * max_order), edges)
    ends = turning.time_s(edges)
    speeds = np.diff(edges) / np.diff(ends) * (60.0 / TURN)
    middles = 0.5 * (ends[1:] + ends[:-1])
    return [
        OrderCut(float(order), middles, speeds, lines.blocks[:, place])
        for place, order in enumerate(lines.orders)
    ]


# Crossings of orders with frequencies, at the speeds 60 f/order.


@dataclass(frozen=True)
class Crossing:
    """Speed at which an order coincides with a frequency."""

    order: float
    frequency_hz: float
    speed_rpm: float


def crossings(frequencies_hz: Sequence[float], max_order: float) -> list[Crossing]:
    """Return the crossings of frequencies with whole and half orders, by frequency, then order.

    Examples
    --------
    >>> [round(c.speed_rpm) for c in crossings([115.0], 12.0) if c.order == 4.0]
    [1725]
    """
    orders = [0.5 * k for k in range(1, round(2 * max_order) + 1)]
    return [Crossing(order, f, 60.0 * f / order) for f in frequencies_hz for order in orders]
