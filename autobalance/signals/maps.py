"""Spectra over time: the waterfall in hertz, the map in orders, and cuts through it with phase."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft

from autobalance.signals.by_angle import by_angle, samples_per_turn
from autobalance.signals.order_lines import CYCLE, fit_between, whole_cycles
from autobalance.signals.record import Channel
from autobalance.signals.turning import TURN, Turning
from autobalance.signals.windows import gain, window
from autobalance.types import Array, Complex

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
    weights = window("hann", length) * (2.0 / (length * gain("hann")))
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
