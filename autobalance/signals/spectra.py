"""Averaged spectra, levels of vibration, and quantities by integration."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from scipy import fft, signal

from autobalance.declare import NotNegative, Positive
from autobalance.errors import FormatError
from autobalance.signals.record import Channel, SignalRecord, spelled, window
from autobalance.signals.sines import Sine, find_sines
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Averaged spectra and their derivatives: Welch with scatter, bands of RMS, velocity and displacement.


STANDARD_GRAVITY = 9.80665
ACCELERATION = {"g": STANDARD_GRAVITY, "m/s²": 1.0, "mm/s²": 1e-3}
VELOCITY = {"m/s": 1.0, "mm/s": 1e-3, "in/s": 0.0254, "ips": 0.0254}
DISPLACEMENT = {"m": 1.0, "mm": 1e-3, "µm": 1e-6}
"""Unit → its size in SI units, by quantity: the second, first and zeroth time derivative of displacement."""
BANDS_HZ = ((10.0, 1000.0), (2.0, 1000.0))
"""Bands of ISO 20816: from 10 Hz; from 2 Hz for machines below 600 1/min."""


@dataclass(frozen=True, eq=False)
class Welch:
    """A power spectral density with its scatter.

    ``density`` and ``scatter`` (the mean's standard error, from the segments) in unit²/Hz.
    """

    frequencies_hz: Array
    density: Array
    scatter: Array
    segments: int


def welch(
    channel: Channel, window_name: str = "hann", length: int | None = None, least_hz: float = 0.0
) -> Welch:
    """Return the mean power spectral density of segments that overlap by half.

    Parameters
    ----------
    length : int or None
        Samples of a segment; default an eighth of the record, 2¹⁶ at most.
    least_hz : float
        Instead of ``length``: the lowest frequency that must be distinguished from 0.
    """
    rate, count = channel.sample_rate_hz, len(channel)
    if length is None:
        length = max(min(count // 8, 1 << 16), int(8 * rate / least_hz) if least_hz > 0.0 else 0, 16)
    length = min(length, count)
    weights = window(window_name, length)
    scale = 2.0 / (rate * float((weights**2).sum()))
    starts = range(0, count - length + 1, max(1, length // 2))
    total, squares = np.zeros(length // 2 + 1), np.zeros(length // 2 + 1)
    for start in starts:
        piece = channel.values(start, start + length)
        density = scale * np.abs(fft.rfft((piece - piece.mean()) * weights)) ** 2
        total += density
        squares += density**2
    segments = len(starts)
    total[0] *= 0.5
    if length % 2 == 0:
        total[-1] *= 0.5
    mean = total / segments
    variance = np.maximum(squares / segments - mean**2, 0.0)
    # Halves that overlap are not independent: of n of them, about 0.75 n are, under a Hann window.
    scatter = np.sqrt(variance / max(0.75 * segments, 1.0))
    return Welch(fft.rfftfreq(length, 1.0 / rate), mean, scatter, segments)


def band_rms(spectrum: Welch, low_hz: float, high_hz: float, derivative: int = 0) -> float:
    """Return the RMS between two frequencies of the signal's derivative of this order (−1: integral)."""
    f = spectrum.frequencies_hz
    inside = (f >= max(low_hz, 1e-12)) & (f <= high_hz)
    power = spectrum.density[inside] * (2.0 * np.pi * f[inside]) ** (2 * derivative)
    return float(np.sqrt(power.sum() * (f[1] - f[0])))


def quantity(unit: str | None) -> tuple[int, float] | None:
    """Return a unit's order of time derivative of displacement, and its size in SI units, or None."""
    for times, units in ((2, ACCELERATION), (1, VELOCITY), (0, DISPLACEMENT)):
        if unit in units:
            return times, units[unit]
    return None


def integrated(values: Array, sample_rate_hz: float, low_hz: float, times: int = 1) -> Array:
    """Return a signal integrated over time, without its part below a frequency.

    Each wave is divided by (2πif)ⁿ; below ``low_hz`` a half cosine over an octave removes it, since noise
    there would drown the rest. The record is continued beyond its ends by linear prediction, fading out, so
    that its waves do not break off: without noise they are right to 1e-3, to 1e-2 at the very ends.

    Parameters
    ----------
    values : (n,) array
        Samples.
    low_hz : float
        Lowest frequency kept whole [Hz]; its half and below is removed.
    times : int
        1: acceleration to velocity, 2: to displacement, −1: velocity to acceleration.
    """
    centred = np.asarray(values - values.mean(), dtype=float)
    room = int(LED_ON * sample_rate_hz / low_hz)
    stride = max(1, round(sample_rate_hz / (MAX_SAMPLES_PER_PERIOD * low_hz)))
    before, after = _led_on(centred[::-1], room, stride)[::-1], _led_on(centred, room, stride)
    padded = np.concatenate([before, centred, after])
    f = fft.rfftfreq(len(padded), 1.0 / sample_rate_hz)
    octave = np.clip(np.log2(np.maximum(f, 1e-12) / (0.5 * low_hz)), 0.0, 1.0)
    factor = np.zeros(len(f), dtype=complex)
    factor[1:] = (0.5 - 0.5 * np.cos(np.pi * octave[1:])) / (2j * np.pi * f[1:]) ** times
    whole = fft.irfft(fft.rfft(padded) * factor, len(padded))
    return np.asarray(whole[room : room + len(values)])


LED_ON = 4.0
"""Periods of the lowest frequency by which a record is continued beyond each end."""
MAX_SAMPLES_PER_PERIOD = 1000.0
"""Most samples per period of the lowest frequency used in the prediction. With more, only every so many are
predicted from each other, since neighbours are too similar to show slow waves."""
PREDICTED_BY = 60
"""Samples from which the next one is predicted; ``LEARNT_FROM`` samples give the coefficients."""
LEARNT_FROM = 8000


def _led_on(values: Array, count: int, stride: int) -> Array:
    """Return the continuation of a signal by linear prediction, fading out by half a cosine.

    ``stride`` interleaved signals are continued one by one, all by one recursion, since they hold the
    same waves.
    """
    rows = min(len(values) // stride, LEARNT_FROM)
    order = min(PREDICTED_BY, rows // 3)
    if order < 1 or not values.any():
        return np.zeros(count)
    learnt = values[len(values) - rows * stride :].reshape(rows, stride)
    recursion = _recursion(learnt, order)
    after = -(-count // stride)
    ahead = np.zeros((after, stride))
    for place in range(stride):
        state = signal.lfiltic([1.0], recursion, learnt[: -len(recursion) : -1, place])
        ahead[:, place], _ = signal.lfilter([1.0], recursion, ahead[:, place], zi=state)
    fade = 0.5 + 0.5 * np.cos(np.pi * (np.arange(count) + 0.5) / count)
    return np.asarray(ahead.reshape(-1)[:count] * fade, dtype=float)


def _recursion(values: Array, order: int) -> Array:
    """Return 1, a₁ … of the prediction error filter of signals (n, k) by Burg's method, always stable."""
    forward, backward = values[1:].copy(), values[:-1].copy()
    least = 1e-20 * float((values**2).sum())
    coefficients = np.array([1.0])
    for _ in range(order):
        power = float((forward**2).sum() + (backward**2).sum())
        if power <= least:
            break
        k = -2.0 * float((forward * backward).sum()) / power
        coefficients = np.concatenate([coefficients, [0.0]]) + k * np.concatenate([[0.0], coefficients[::-1]])
        forward, backward = (forward + k * backward)[1:], (backward + k * forward)[:-1]
    return coefficients


# Levels of vibration: acceleration, velocity and displacement in the usual bands.


LevelQuantity = Literal["displacement", "velocity", "acceleration"]
QUANTITIES: tuple[LevelQuantity, ...] = ("displacement", "velocity", "acceleration")
UNITS = {"displacement": ("µm", 1e6), "velocity": ("mm/s", 1e3), "acceleration": ("m/s²", 1.0)}
MIN_PERIODS = 4.0
"""Periods of a band's lowest frequency that a record must hold."""


@dataclass(frozen=True)
class Band:
    """RMS of a quantity in a band."""

    quantity: LevelQuantity
    unit: str
    low_hz: NotNegative
    high_hz: Positive
    rms: NotNegative


def band_levels(channel: Channel) -> list[Band]:
    """Return RMS of acceleration, velocity and displacement in the usual bands; empty for unknown units."""
    known = quantity(spelled(channel.unit))
    if known is None:
        return []
    times, size = known
    levels = []
    for low, high in BANDS_HZ:
        if high > 0.5 * channel.sample_rate_hz or low * channel.duration_s < MIN_PERIODS:
            continue
        spectrum = welch(channel, least_hz=low)
        for wanted, name in enumerate(QUANTITIES):
            unit, scale = UNITS[name]
            rms = band_rms(spectrum, low, high, wanted - times) * size * scale
            levels.append(Band(name, unit, low, high, rms))
    return levels


# Piecewise work on records longer than memory or patience.


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


# A channel as another quantity: acceleration, velocity or displacement, by integration over time.


Quantity = Literal["acceleration", "velocity", "displacement"]
DERIVED_QUANTITIES: dict[str, tuple[int, str, float]] = {
    "acceleration": (2, "m/s²", 1.0),
    "velocity": (1, "mm/s", 1e3),
    "displacement": (0, "µm", 1e6),
}
"""Order of the time derivative of displacement, unit of the result, and its number per SI unit."""
LOWEST_HZ = 2.0
"""Lowest frequency kept whole: below, integration would drown all in noise."""


def as_quantity(record: SignalRecord, target: Quantity, tacho: str | None) -> SignalRecord:
    """Return a record with all channels of motion converted to one quantity; the tacho and others stay.

    Raises
    ------
    FormatError
        If no channel is of acceleration, velocity or displacement, or one is too long to be integrated whole.
    """
    known = [each for each in record.channels if quantity(spelled(each.unit)) is not None]
    known = [each for each in known if tacho is None or not each.is_called(tacho)]
    if not known:
        units = ", ".join(f"{each.name} [{each.unit or 'no unit'}]" for each in record.channels)
        raise FormatError(f"{record.file} has no channel of acceleration, velocity or displacement: {units}")
    ids = {id(each) for each in known}
    channels = tuple(_as(each, target) if id(each) in ids else each for each in record.channels)
    return replace(record, channels=channels)


def _as(channel: Channel, target: Quantity) -> Channel:
    if len(channel) > MAX_WHOLE:
        raise FormatError(f"{channel.name} has {len(channel)} samples; up to {MAX_WHOLE} can be integrated")
    spelled_as = quantity(spelled(channel.unit))
    assert spelled_as is not None  # asked before
    times, size = spelled_as
    order, unit, scale = DERIVED_QUANTITIES[target]
    values = channel.values() * (size * scale)
    if times != order:
        values = integrated(values, channel.sample_rate_hz, LOWEST_HZ, times - order)
    return replace(channel, unit=unit, stored=values, factor=1.0, offset=0.0)
