"""The shaft's angle from a tacho's pulses: placed between samples, repaired, evened, smoothed."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from autobalance.declare import PERCENT, UNWRITTEN, Count, NotNegative
from autobalance.errors import FormatError
from autobalance.signals.by_angle import TURN, Turning
from autobalance.signals.record import BLOCK, Channel
from autobalance.types import Array
from autobalance.value_classes import dataclass

HYSTERESIS = 0.15
"""Smallest fall of a signal before its next rise, as a share of the way from threshold to lower extreme."""
NEIGHBOURS = 5
"""Intervals on each side from which the length of one is estimated."""
LONGEST_WINDOW = 401
MORE_SCATTER = 1.6
"""Largest ratio of a wide smoothing's scatter to the narrowest's; rounding to samples is not white noise."""
ERROR_WINDOW = 11
PATTERN_TURNS = 4
"""Smallest turns for the separation of an encoder's own pattern from the shaft's motion."""


@dataclass(frozen=True, eq=False)
class TachoPulses:
    """Pulses of a tacho and their faults.

    ``times_s`` are repaired; ``smooth_s`` lack the encoder's pattern and are as smooth as the scatter allows.
    """

    times_s: Annotated[Array, UNWRITTEN]
    smooth_s: Annotated[Array, UNWRITTEN]
    per_turn: Annotated[int, UNWRITTEN]
    found: Count
    missing: Count
    extra: Count
    jitter: Annotated[NotNegative, PERCENT]
    """Standard deviation of the intervals' error over the interval."""
    pattern: Annotated[NotNegative, PERCENT]
    """Standard deviation of the encoder's own pattern over the interval; 0 without one."""
    repeats: Annotated[int, UNWRITTEN] = 0
    """Number of pulses after which the missing ones recur; 0 where they do not."""

    def turning(self) -> Turning:
        """Return the shaft's angle, 0 at the first pulse."""
        angles = np.arange(float(len(self.smooth_s))) * (TURN / self.per_turn)
        return Turning(self.smooth_s, angles)

    def speed_uncertainty_rpm(self, mean_rpm: float) -> float:
        """Return the standard uncertainty of the mean speed, from the scatter of its end pulses."""
        intervals = len(self.times_s) - 1
        return mean_rpm * self.jitter / intervals


def pulses(channel: Channel, per_turn: int, threshold: float | None = None) -> TachoPulses | str:
    """Return a tacho's pulses; for fewer than three a message, as the record is worth more than its orders.

    Parameters
    ----------
    channel : Channel
        The tacho.
    per_turn : int
        Pulses of a whole turn, those of missing teeth counted.
    threshold : float or None
        Default: midway between the extremes.

    Raises
    ------
    FormatError
        If ``per_turn`` is not positive.
    """
    if per_turn < 1:
        raise FormatError(f"tacho {channel.name!r} has {per_turn} pulses a turn; must be ≥ 1")
    raw = crossings_s(channel, threshold)
    if len(raw) < 3:
        low, high = _extremes(channel)
        level = 0.5 * (low + high) if threshold is None else threshold
        return (
            f"tacho {channel.name!r} has {len(raw) or 'no'} pulses; expected at least 3; "
            f"it goes from {low:.6g} to {high:.6g}, the threshold is {level:.6g}"
        )
    mended, missing, extra = mend(raw)
    return _evened(mended, per_turn, len(raw), missing, extra, _repeats(raw))


def _extremes(channel: Channel) -> tuple[float, float]:
    low, high = np.inf, -np.inf
    for _, piece in channel.blocks():
        low, high = min(low, float(np.nanmin(piece))), max(high, float(np.nanmax(piece)))
    return low, high


def crossings_s(channel: Channel, threshold: float | None = None) -> Array:
    """Return the times at which a channel rises through a threshold, interpolated linearly [s]."""
    low, high = _extremes(channel)
    level = 0.5 * (low + high) if threshold is None else threshold
    if not low < level < high:
        return np.zeros(0)
    ready = level - HYSTERESIS * (level - low)
    crossings: list[Array] = []
    armed, last = bool(channel.values(0, 1)[0] < level), np.nan
    for start in range(0, len(channel), BLOCK):
        piece = np.concatenate([[last], channel.values(start, start + BLOCK)])
        rises = np.flatnonzero((piece[:-1] < level) & (piece[1:] >= level))
        fresh, armed = _armed_rises(piece, rises, ready, armed)
        share = (level - piece[fresh]) / (piece[fresh + 1] - piece[fresh])
        crossings.append((start - 1 + fresh + share) / channel.sample_rate_hz)
        last = float(piece[-1])
    return np.concatenate(crossings)


def _armed_rises(
    piece: Array, rises: NDArray[np.intp], ready: float, armed: bool
) -> tuple[NDArray[np.intp], bool]:
    """Return the rises after a fall well below the threshold, and whether such a fall is at the end."""
    below = np.concatenate([[0], np.cumsum(piece < ready)])  # how often, before each sample
    before = np.concatenate([[0], below[rises + 1]])
    fell = np.diff(before) > 0
    if len(rises):
        fell[0] |= armed
        after = bool(below[-1] > below[rises[-1] + 1])
        # A rise that did not count leaves the state as it was: not armed.
        return rises[fell], after
    return rises, armed or bool(below[-1] > 0)


def mend(times_s: Array) -> tuple[Array, int, int]:
    """Return pulses without doubled ones and with missing ones added, and the number of each."""
    kept, extra = _without_extra(times_s)
    whole, missing = _with_missing(kept)
    return whole, missing, extra


def _expected(intervals: Array) -> Array:
    """Return the expected length of each interval: the median of its neighbours."""
    count = len(intervals)
    reach = min(NEIGHBOURS, (count - 1) // 2)
    if reach < 1:
        return np.full(count, np.median(intervals))
    from numpy.lib.stride_tricks import sliding_window_view

    middle = np.median(sliding_window_view(intervals, 2 * reach + 1), axis=1)
    slope = (middle[-1] - middle[0]) / max(len(middle) - 1, 1) if len(middle) > 1 else 0.0
    front = np.maximum(middle[0] - slope * np.arange(reach, 0, -1), 0.5 * middle[0])
    back = np.maximum(middle[-1] + slope * np.arange(1, reach + 1), 0.5 * middle[-1])
    return np.concatenate([front, middle, back])


def _without_extra(times: Array) -> tuple[Array, int]:
    """Return the pulses without those that split an interval, and the number of these."""
    removed = 0
    while len(times) > 3:
        intervals = np.diff(times)
        expected = _expected(intervals)
        pairs = intervals[:-1] + intervals[1:]
        shorter = np.minimum(intervals[:-1], intervals[1:])
        usual = 0.5 * (expected[:-1] + expected[1:])
        split = (pairs < 1.4 * usual) & (shorter < 0.65 * usual)
        if not split.any():
            break
        error = np.where(split, np.abs(pairs - usual) / usual, np.inf)
        chosen, last = [], -3
        for place in np.flatnonzero(split):
            if place - last > 2:
                chosen.append(int(place))
                last = int(place)
            elif error[place] < error[chosen[-1]]:
                chosen[-1] = last = int(place)
        times = np.delete(times, np.array(chosen) + 1)
        removed += len(chosen)
    return times, removed


def _with_missing(times: Array) -> tuple[Array, int]:
    """Return the pulses with those missing from intervals of multiple length, and the number of these."""
    intervals = np.diff(times)
    counts = np.maximum(np.round(intervals / _expected(intervals)), 1.0).astype(int)
    missing = int((counts - 1).sum())
    if not missing:
        return times, 0
    numbers = np.concatenate([[0], np.cumsum(counts)])
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(numbers, times)(np.arange(numbers[-1] + 1))), missing


def _repeats(times: Array) -> int:
    """Return the number of pulses, missing ones counted, after which gaps recur; 0 where they do not."""
    intervals = np.diff(times)
    counts = np.maximum(np.round(intervals / _expected(intervals)), 1.0).astype(int)
    numbers = np.concatenate([[0], np.cumsum(counts)])
    gaps = numbers[np.flatnonzero(counts > 1)]
    steps = np.diff(gaps)
    even = len(steps) >= PATTERN_TURNS and float(np.mean(steps == np.median(steps))) > 0.8
    return int(np.median(steps)) if even else 0


def _evened(
    times: Array, per_turn: int, count: int, missing: int, extra: int, repeats: int = 0
) -> TachoPulses:
    """Return the pulses without the pattern of each turn, smoothed."""
    offsets, pattern = _pattern(times, per_turn)
    clean = times - offsets
    return TachoPulses(
        times, _smoothed(clean), per_turn, count, missing, extra, _interval_error(clean), pattern, repeats
    )


def _interval_error(times: Array) -> float:
    """Return the standard deviation of intervals about their neighbours' moving cubic, over the interval."""
    from scipy.signal import savgol_filter

    intervals = np.diff(times)
    width = min(ERROR_WINDOW, len(intervals) - 1 + len(intervals) % 2)
    if width < 5:
        return 0.0
    return float(np.std(intervals / savgol_filter(intervals, width, 3) - 1.0))


def _pattern(times: Array, per_turn: int) -> tuple[Array, float]:
    """Return the delay of each pulse by the encoder's pattern [s], and the pattern's size over the interval.

    A pulse's place is compared with the turn around it: the mean of the N pulses centred on it, which holds
    every place once and so is free of the pattern.
    """
    count = len(times)
    none = np.zeros(count), 0.0
    if per_turn == 1 or count < PATTERN_TURNS * per_turn:
        return none
    k = np.arange(count)
    local = np.convolve(times, _centred(per_turn), "valid")
    reach = (count - len(local)) // 2
    interval = np.convolve(np.diff(times), np.full(per_turn, 1.0 / per_turn), "same")
    inner = slice(reach, reach + len(local))
    late = (times[inner] - local) / interval[np.minimum(k[inner], count - 2)]
    place = k[inner] % per_turn
    totals = np.bincount(place, late, per_turn) / np.bincount(place, minlength=per_turn)
    scatter = late - totals[place]
    doubt = float(np.std(scatter)) / np.sqrt(len(late) / per_turn)
    size = float(np.std(totals))
    if size < 3.0 * doubt or size < 1e-4:
        return none
    totals -= totals[0]  # angle 0 stays at the first pulse
    return totals[k % per_turn] * np.append(interval, interval[-1]), size


def _centred(per_turn: int) -> Array:
    """Return weights of one turn around a pulse, symmetric also where their number is even."""
    if per_turn % 2:
        return np.full(per_turn, 1.0 / per_turn)
    weights = np.full(per_turn + 1, 1.0 / per_turn)
    weights[[0, -1]] *= 0.5
    return weights


def _smoothed(times: Array) -> Array:
    """Return the pulses smoothed as far as their scatter allows.

    The scatter is the residual of a cubic through the nearest neighbours. A wider window is taken as long as
    its residual is not much more than that: the shaft's own motion is kept.
    """
    count = len(times)
    if count < 8:
        return times
    best, least, width = times, -1.0, 5
    while width <= min(count, LONGEST_WINDOW):
        smooth, left = _cubic_fit(times, width)
        least = left if least < 0.0 else least
        if left > MORE_SCATTER * least:
            break
        best, width = smooth, 2 * width + 1
    return best


def _cubic_fit(times: Array, width: int) -> tuple[Array, float]:
    """Return pulses smoothed by a moving cubic, and a pulse's standard deviation from it."""
    from scipy.signal import savgol_coeffs, savgol_filter

    smooth = savgol_filter(times - times[0], width, 3) + times[0]
    centre = float(savgol_coeffs(width, 3)[width // 2])
    inner = slice(width // 2, len(times) - width // 2)
    rest = (times - smooth)[inner]
    # Of white noise the fit leaves the share 1 − h of the variance, h its own weight in its value.
    return np.asarray(smooth), float(np.sqrt(np.mean(rest**2) / (1.0 - centre)))
