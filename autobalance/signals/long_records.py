"""Piecewise work on records longer than memory or patience."""

from __future__ import annotations

import numpy as np
from scipy import signal

from autobalance.signals.record import Channel
from autobalance.signals.sines import Sine, find_sines
from autobalance.types import Array

MAX_WHOLE = 1 << 24
"""Largest number of samples of a record transformed whole: 5 minutes at 50 kHz."""
PIECE = 1 << 22
MODE_SAMPLES = 1 << 22
SAME_BINS = 0.5


def sines_of(
    channel: Channel, window_name: str, most: int, whole: int = MAX_WHOLE, piece: int = PIECE
) -> list[Sine]:
    """Return the sines of a whole record; of one of more than ``whole`` samples, those of pieces combined.

    Then an amplitude is the RMS over the pieces, and the phase that of the strongest piece, extrapolated to
    the first sample.
    """
    if most == 0:
        return []
    if len(channel) <= whole:
        return find_sines(channel.values(), channel.sample_rate_hz, window_name, most)
    rate = channel.sample_rate_hz
    starts = range(0, len(channel) - piece + 1, piece)
    seen = [
        (sine, start / rate)
        for start in starts
        for sine in find_sines(channel.values(start, start + piece), rate, window_name, most)
    ]
    groups: list[list[tuple[Sine, float]]] = []
    for sine, start in sorted(seen, key=lambda each: each[0].frequency_hz):
        last = groups[-1][-1][0].frequency_hz if groups else -np.inf
        if sine.frequency_hz - last > SAME_BINS * rate / piece:
            groups.append([])
        groups[-1].append((sine, start))
    sines = [_together(group, len(starts)) for group in groups]
    return sorted(sines, key=lambda sine: -sine.amplitude)[:most]


def _together(group: list[tuple[Sine, float]], pieces: int) -> Sine:
    power = np.array([sine.amplitude**2 for sine, _ in group])
    frequency = float(power @ [sine.frequency_hz for sine, _ in group] / power.sum())
    best, start = max(group, key=lambda each: each[0].amplitude)
    phase = best.phase_rad - 2.0 * np.pi * best.frequency_hz * start
    return Sine(frequency, float(np.sqrt(power.sum() / pieces)), float(np.angle(np.exp(1j * phase))))


def thinned(channel: Channel, length: int) -> tuple[Array, float]:
    """Return the first samples of a channel, decimated where they are very many, and their rate [Hz]."""
    fewer = -(-length // MODE_SAMPLES)
    values = channel.values(0, length)
    if fewer == 1:
        return values, channel.sample_rate_hz
    return np.asarray(signal.resample_poly(values, 1, fewer)), channel.sample_rate_hz / fewer
