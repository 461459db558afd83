"""Faults of a record: clipping, gaps, content up to half the sample rate; and the filling of gaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import FormatError
from autobalance.signals.record import BLOCK, Channel
from autobalance.signals.sines import find_sines
from autobalance.types import Array

MIN_CLIPPED_RUN = 3
"""Smallest run of samples at the extreme in a clipped record."""
MIN_CROWDING_RATIO = 5.0
"""Smallest ratio of samples at the extreme to those at the next level; a rounded sine has at most three."""
GUARD_FROM = 0.8
"""Share of half the sample rate above which an anti-aliasing filter should leave nothing."""
GUARD_SHARE = 0.01
MOST_HOLES = 0.5
LONGEST_MODELLED = 1 << 22
MODEL_ROUNDS = 8


def clipped_share(channel: Channel) -> float:
    """Return the share of samples at an extreme where the signal was clipped; 0 without clipping."""
    values = channel.stored
    if len(values) < 2 * MIN_CLIPPED_RUN:
        return 0.0
    count = 0
    for sign in (1.0, -1.0):
        count += _crowd(values, sign)
    return count / len(values)


def _crowd(stored: Array, sign: float) -> int:
    """Return the number of samples at the largest (sign > 0) or smallest value; 0 without clipping."""
    top = _extreme(stored, sign)
    if not np.isfinite(top):
        return 0
    total, run_found, second, beside, last = 0, False, -np.inf, 0, np.zeros(0, dtype=bool)
    for start in range(0, len(stored), BLOCK):
        piece = np.asarray(stored[start : start + BLOCK])
        at = np.concatenate([last, piece == top])
        run_found |= bool((at[2:] & at[1:-1] & at[:-2]).any())
        last = at[-2:]
        total += int((piece == top).sum())
        others = sign * piece[(piece != top) & ~np.isnan(piece.astype(float))].astype(float)
        if len(others):
            best = float(others.max())
            if best > second:
                second, beside = best, 0
            beside += int((others == second).sum())
    return total if run_found and np.isfinite(second) and total > MIN_CROWDING_RATIO * beside else 0


def _extreme(stored: Array, sign: float) -> float:
    """Return the largest (sign > 0) or smallest value, piece by piece; not finite if there is no number."""
    reduce = np.fmax.reduce if sign > 0 else np.fmin.reduce  # they pass over nan
    tops = [float(reduce(stored[start : start + BLOCK])) for start in range(0, len(stored), BLOCK)]
    return float(reduce(tops))


def filled(channel: Channel) -> tuple[Channel, str | None]:
    """Return a channel with its gaps (nan) filled, and a note on them, None without gaps.

    Raises
    ------
    FormatError
        If more than half of the samples are not numbers.
    """
    if channel.stored.dtype.kind != "f":
        return channel, None
    if all(np.isfinite(channel.stored[k : k + BLOCK]).all() for k in range(0, len(channel), BLOCK)):
        return channel, None
    holes = ~np.isfinite(channel.stored)
    count = int(holes.sum())
    if count > MOST_HOLES * len(holes):
        raise FormatError(f"channel {channel.name!r}: {count} of {len(holes)} samples are not numbers")
    places = np.flatnonzero(~holes)
    values = channel.values()
    values = np.interp(np.arange(len(values)), places, values[places])
    if len(values) <= LONGEST_MODELLED:
        values = _modelled(values, holes, channel.sample_rate_hz)
    first = int(np.argmax(holes)) / channel.sample_rate_hz
    edges = int((np.diff(holes.astype(np.int8)) == 1).sum()) + int(holes[0])
    note = (
        f"gap: channel {channel.name!r} has {count} samples that are not numbers, in {edges} places, "
        f"the first at {first:.6g} s; filled by the record's sines and straight lines"
    )
    return replace(channel, stored=values, factor=1.0, offset=0.0), note


def _modelled(values: Array, holes: NDArray[np.bool_], rate_hz: float) -> Array:
    """Return values whose gaps follow the record's own sines, and straight lines for the remainder.

    Sines found with straight lines in the gaps are a little off; with themselves there, less so.
    A gap also makes weak lines beside each sine, so that the strong ones are taken first.
    """
    times = np.arange(len(values)) / rate_hz
    sound, lost = np.flatnonzero(~holes), np.flatnonzero(holes)
    least = 3.0 * len(lost) / len(values)
    for _ in range(MODEL_ROUNDS):
        candidates = find_sines(values, rate_hz)
        if not candidates:
            break
        sines = [sine for sine in candidates if sine.amplitude > least * candidates[0].amplitude]
        least *= 0.3
        model = sum(
            (s.amplitude * np.cos(2.0 * np.pi * s.frequency_hz * times + s.phase_rad) for s in sines),
            np.zeros(len(values)),
        )
        filling = model[lost] + np.interp(lost, sound, (values - model)[sound])
        moved = float(np.abs(filling - values[lost]).max())
        values = values.copy()
        values[lost] = filling
        if moved < 1e-9 * float(np.abs(values).max()):
            break
    return values


def unguarded_share(values: Array) -> float:
    """Return the share of a signal's power in the top fifth below half the sample rate."""
    length = min(len(values), 1 << 14)
    pieces = values[: len(values) // length * length].reshape(-1, length)[:64]
    weights = np.hanning(length)
    centred = (pieces - pieces.mean(axis=1, keepdims=True)) * weights
    power = (np.abs(np.fft.rfft(centred, axis=1)) ** 2).sum(axis=0)
    total = float(power.sum())
    return float(power[int(GUARD_FROM * len(power)) :].sum()) / total if total > 0.0 else 0.0


def aliasing_note(channel: Channel) -> str | None:
    """Return a warning of content that reaches up to half the sample rate, None without such content."""
    share = unguarded_share(channel.values(0, BLOCK))
    if share < GUARD_SHARE:
        return None
    half = 0.5 * channel.sample_rate_hz
    return (
        f"aliasing: {100.0 * share:.2g} % of the power of channel {channel.name!r} lies between "
        f"{GUARD_FROM * half:.6g} and {half:.6g} Hz, half the sample rate; a filter that passes it "
        "leaves no guard band, and frequencies above half the rate fold back below it"
    )
