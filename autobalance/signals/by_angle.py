"""The shaft's angle as a function of time, and resampling by it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field
from typing import ClassVar

import numpy as np
from scipy import signal
from scipy.interpolate import CubicSpline

from autobalance.declare import NotNegative, Positive, derived
from autobalance.signals.record import Channel
from autobalance.types import Array
from autobalance.value_classes import dataclass

# The shaft's angle as a smooth function of time, with its speed.


TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Turning:
    """Angle θ(t) between two instants; a cubic spline, so that the speed has no steps and no corners.

    Parameters
    ----------
    times_s : (k,) array
        Ascending, k ≥ 2 [s].
    angles_rad : (k,) array
        Ascending [rad]; 0 is the origin of phases.
    """

    times_s: Array
    angles_rad: Array
    _spline: CubicSpline = field(init=False, repr=False)

    def __post_init__(self) -> None:
        spline = (
            CubicSpline(self.times_s, self.angles_rad, bc_type="natural")
            if len(self.times_s) < 4
            else CubicSpline(self.times_s, self.angles_rad)
        )
        object.__setattr__(self, "_spline", spline)

    @classmethod
    def steady(cls, speed_rpm: float, duration_s: float) -> Turning:
        """Return a constant speed from angle 0 at the first sample."""
        return cls(np.array([0.0, duration_s]), np.array([0.0, TURN * speed_rpm / 60.0 * duration_s]))

    @property
    def start_s(self) -> float:
        """Return the first time with a known angle [s]."""
        return float(self.times_s[0])

    @property
    def end_s(self) -> float:
        """Return the last time with a known angle [s]."""
        return float(self.times_s[-1])

    @property
    def turns(self) -> float:
        """Return the number of turns, not rounded."""
        return float(self.angles_rad[-1] - self.angles_rad[0]) / TURN

    def angle_rad(self, times_s: Array) -> Array:
        """Return the angles at times (n,) [rad]."""
        return np.asarray(self._spline(times_s))

    def speed_rad_s(self, times_s: Array) -> Array:
        """Return the speeds at times (n,) [rad/s]."""
        return np.asarray(self._spline(times_s, 1))

    def time_s(self, angles_rad: Array) -> Array:
        """Return the times of angles (n,), by Newton's method from the nearest known ones [s]."""
        times = np.interp(angles_rad, self.angles_rad, self.times_s)
        for _ in range(4):
            speed = np.maximum(self.speed_rad_s(times), 1e-9)
            times = np.clip(times - (self.angle_rad(times) - angles_rad) / speed, self.start_s, self.end_s)
        return times

    def speeds_rpm(self) -> Array:
        """Return the speeds at the known angles and midway between them [1/min]."""
        middle = 0.5 * (self.times_s[1:] + self.times_s[:-1])
        return self.speed_rad_s(np.sort(np.concatenate([self.times_s, middle]))) * 60.0 / TURN

    @property
    def mean_rpm(self) -> float:
        """Return the mean speed over time [1/min]."""
        return 60.0 * self.turns / (self.end_s - self.start_s)


# Computed order tracking: resampling from even steps of time to even steps of the shaft's angle.
#
# Each value is Σ x[n] h(t − n/f_s), with h a sinc under a Kaiser window whose cut-off follows the speed. It
# is flat to the highest order wanted, and 120 dB down from the order on that would fold back onto it. One
# filter thus does both anti-aliasing and interpolation. If the shaft turns slowly for the sample rate, a
# first filter reduces that rate.


STOP_DB = 120.0
KAISER = 0.1102 * (STOP_DB - 8.7)
LENGTH = (STOP_DB - 8.0) / (2.285 * TURN)
"""Kaiser's estimate: number of such a filter's taps, times the width of its flank over the sample rate."""
TABLE = 1 << 13
"""Steps of the filter's table from its middle to its end, read by straight lines."""
MIN_SAMPLES_PER_PERIOD = 8
"""Smallest samples per turn over the highest order: room for the flank, even while the speed varies."""
BLOCK_TURNS = 32
POINTS = 1 << 14


def samples_per_turn(max_order: float) -> int:
    """Return a power of two that leaves the filter a wide flank above the highest order."""
    return 1 << int(np.ceil(np.log2(MIN_SAMPLES_PER_PERIOD * max(max_order, 1.0))))


def by_angle(
    channel: Channel, turning: Turning, per_turn: int, max_order: float, turns: int
) -> Iterator[Array]:
    """Yield a channel's values at angles 0, 2π/N, … of whole turns, block by block.

    Parameters
    ----------
    channel : Channel
        Samples without gaps.
    turning : Turning
        The shaft's angle by the same clock.
    per_turn : int
        N, values per turn.
    max_order : float
        Orders up to here are kept, to 1e-5; those from N less this on are gone.
    turns : int
        Number of turns.
    """
    for first in range(0, turns, BLOCK_TURNS):
        last = min(first + BLOCK_TURNS, turns)
        yield _resampled(channel, turning, per_turn, max_order, first, last)


def _resampled(
    channel: Channel, turning: Turning, per_turn: int, max_order: float, first: int, last: int
) -> Array:
    angles = np.arange(float(first * per_turn), float(last * per_turn)) * (TURN / per_turn)
    times = turning.time_s(angles)
    speeds = turning.speed_rad_s(times[:: max(1, per_turn // 16)]) / TURN
    slow, fast = float(speeds.min()), float(speeds.max())
    if last - first > 1 and (per_turn - max_order) * slow < 3.0 * max_order * fast:
        half = (first + last) // 2
        pieces = ((first, half), (half, last))
        return np.concatenate([_resampled(channel, turning, per_turn, max_order, *each) for each in pieces])
    pass_hz = max_order * fast
    stop_hz = max((per_turn - max_order) * slow, 1.5 * pass_hz)
    reach = LENGTH / (stop_hz - pass_hz) * 2.0 + 4.0 / channel.sample_rate_hz
    values, rate, start = _thinned(channel, times[0] - reach, times[-1] + reach, pass_hz, stop_hz)
    stop_hz = min(stop_hz, rate - pass_hz)
    return _interpolated(values, rate, times - start, pass_hz, stop_hz)


def _thinned(
    channel: Channel, start_s: float, end_s: float, pass_hz: float, stop_hz: float
) -> tuple[Array, float, float]:
    """Return a piece of a channel at the least sufficient sample rate: values, their rate and first time."""
    rate = channel.sample_rate_hz
    fewer = max(1, int(rate / (2.0 * stop_hz)))
    reach = int(np.ceil(LENGTH * rate / (rate / fewer - 2.0 * pass_hz) / 2.0)) if fewer > 1 else 0
    low, high = int(np.floor(start_s * rate)) - reach - fewer, int(np.ceil(end_s * rate)) + reach + fewer
    values = _extended(channel, low, high)
    if fewer == 1:
        return values, rate, low / rate
    taps = signal.firwin(2 * reach + 1, 0.5 * rate / fewer, window=("kaiser", KAISER), fs=rate)
    kept = signal.upfirdn(taps, values, down=fewer)
    # Output m stands at input m·fewer − reach; those at the ends saw less than the whole filter.
    skip = -(-2 * reach // fewer)
    kept = kept[skip : len(values) // fewer]
    return np.asarray(kept), rate / fewer, (low + skip * fewer - reach) / rate


def _extended(channel: Channel, low: int, high: int) -> Array:
    """Return samples of a channel, continued by point reflection at its first and last sample."""
    count = len(channel)
    inside = channel.values(max(low, 0), min(high, count))
    before, after = max(0, -low), max(0, high - count)
    if not before and not after:
        return inside
    room = len(inside) - 1
    padded = np.pad(inside, (min(before, room), min(after, room)), "reflect", reflect_type="odd")
    short = before - min(before, room), after - min(after, room)
    return np.pad(padded, short, "edge")


def _interpolated(values: Array, rate: float, times_s: Array, pass_hz: float, stop_hz: float) -> Array:
    """Return the values of a band-limited signal at times between its samples."""
    cut = (pass_hz + stop_hz) / rate  # of half the rate
    half = max(4, int(np.ceil(LENGTH * rate / (stop_hz - pass_hz) / 2.0)))
    place = np.arange(TABLE + 2) * (half / TABLE)
    table = cut * np.sinc(cut * place)
    table *= np.i0(KAISER * np.sqrt(np.maximum(1.0 - (place / half) ** 2, 0.0))) / np.i0(KAISER)
    slopes = np.diff(table, append=0.0)
    samples = np.zeros(len(times_s))
    offsets = np.arange(-half + 1, half + 1)
    for first in range(0, len(times_s), POINTS):
        at = times_s[first : first + POINTS] * rate
        whole = np.floor(at).astype(np.intp)
        distance = np.abs((at - whole)[:, None] - offsets[None, :]) * (TABLE / half)
        index = distance.astype(np.intp)
        weights = table[index] + slopes[index] * (distance - index)
        reading = np.clip(whole[:, None] + offsets[None, :], 0, len(values) - 1)
        samples[first : first + POINTS] = (values[reading] * weights).sum(axis=1)
    return samples


# Motion in a plane, from two axes: one circle with the shaft's rotation and one against it.


ROTATING_BELOW = 0.2
RECIPROCATING_ABOVE = 0.8


@dataclass(frozen=True)
class WhirlCircles:
    """Radii of the two circles of X + iY at an order; forward is from X to Y."""

    schema_name: ClassVar[str] = "circle_figures"

    order: Positive
    forward: NotNegative
    backward: NotNegative

    @derived
    def verdict(self) -> str:
        """Return rotating, reciprocating or mixed.

        A turning force draws one circle; a force in a fixed direction two equal ones.

        Examples
        --------
        >>> circles(1.0, 1.0 + 0j, -1j).verdict, circles(1.0, 1.0 + 0j, 0j).verdict
        ('rotating', 'reciprocating')
        """
        small, large = sorted((self.forward, self.backward))
        if large == 0.0 or small < ROTATING_BELOW * large:
            return "rotating"
        return "reciprocating" if small > RECIPROCATING_ABOVE * large else "mixed"


def circles(order: float, x: complex, y: complex) -> WhirlCircles:
    """Return the circles of X = Re(x e^(ikθ)) and Y = Re(y e^(ikθ)).

    X + iY = f e^(ikθ) + b e^(−ikθ), f = (x + iy)/2, b̄ = (x − iy)/2.
    """
    return WhirlCircles(order, abs(x + 1j * y) / 2.0, abs(x - 1j * y) / 2.0)
