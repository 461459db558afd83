"""A record: channels of samples, their units and calibration, and windows on them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import FormatError
from autobalance.types import Array, Complex
from autobalance.value_classes import dataclass

# A record: channels of samples at even steps of time (or of angle), each with its unit and calibration.


BLOCK = 1 << 20
"""Samples processed at a time where a channel may be longer than memory."""


@dataclass(frozen=True, eq=False)
class Channel:
    """Samples of one quantity.

    Parameters
    ----------
    name : str
        As in the file, without the unit.
    unit : str or None
        As in the file.
    sample_rate_hz : float
        Samples a second [Hz].
    stored : (n,) array
        Any numeric type; may be mapped from the file rather than read.
    factor, offset : float
        Calibration: a sample is ``(stored - offset) * factor``.
    """

    name: str
    unit: str | None
    sample_rate_hz: float
    stored: NDArray[Any]
    factor: float = 1.0
    offset: float = 0.0
    header: str = ""

    def __len__(self) -> int:
        return len(self.stored)

    @property
    def duration_s(self) -> float:
        """Return the duration of the samples, their number over the rate [s]."""
        return len(self.stored) / self.sample_rate_hz

    def values(self, start: int = 0, stop: int | None = None) -> Array:
        """Return calibrated samples as float64."""
        piece = np.asarray(self.stored[start:stop], dtype=float)
        if self.factor == 1.0 and self.offset == 0.0:
            return piece
        return (piece - self.offset) * self.factor

    def blocks(self, length: int = BLOCK) -> Iterator[tuple[int, Array]]:
        """Yield (first sample, samples) of the whole channel, piece by piece."""
        for start in range(0, len(self), length):
            yield start, self.values(start, start + length)

    def is_called(self, name: str) -> bool:
        """Return whether a name is this channel's name, its whole header, or its header without the unit."""
        return name in {self.name, self.header, self.header.rpartition("_")[0] or self.name}


@dataclass(frozen=True, eq=False)
class SignalRecord:
    """Channels recorded together, from one file."""

    file: str
    format: str
    channels: tuple[Channel, ...]
    notes: tuple[str, ...] = ()
    """Faults found by the reader and their repair: for ``warnings``."""
    samples_per_turn: float | None = None
    """Sample rate of a record sampled by angle, which is known only with a speed."""
    start_angle_deg: float = 0.0
    """Shaft angle at the first sample of a record sampled by angle."""

    @property
    def duration_s(self) -> float:
        """Return the duration of the longest channel [s]."""
        return max(channel.duration_s for channel in self.channels)

    def channel(self, name: str) -> Channel:
        """Return a channel by its name.

        Raises
        ------
        FormatError
            If no channel or more than one has the name.
        """
        exact = [each for each in self.channels if each.name == name]
        matching = exact or [each for each in self.channels if each.is_called(name)]
        if len(matching) == 1:
            return matching[0]
        known = ", ".join(each.name for each in self.channels)
        what = "has no channel" if not matching else "has several channels"
        why = "".join(f"; {note}" for note in self.notes if repr(name) in note)
        raise FormatError(f"{self.file} {what} {name!r}; its channels: {known}{why}")

    def calibrated(self, factors: Mapping[str, tuple[float, str | None]]) -> SignalRecord:
        """Return the record with channels multiplied by factors, with new units where these are not None."""
        factor_of = {id(self.channel(name)): value for name, value in factors.items()}

        def scaled(channel: Channel) -> Channel:
            if id(channel) not in factor_of:
                return channel
            factor, unit = factor_of[id(channel)]
            return replace(channel, factor=channel.factor * factor, unit=unit or channel.unit)

        return replace(self, channels=tuple(scaled(each) for each in self.channels))

    def at_speed(self, speed_rpm: float) -> SignalRecord:
        """Return a record sampled by angle as one sampled by time, at a constant speed."""
        if self.samples_per_turn is None:
            return self
        rate = self.samples_per_turn * speed_rpm / 60.0
        return replace(self, channels=tuple(replace(each, sample_rate_hz=rate) for each in self.channels))


# A column's header: the channel's name and its unit.


UNITS = {
    **dict.fromkeys(("g", "gn", "G"), "g"),
    **dict.fromkeys(("m/s2", "m/s²", "m/s^2", "m/s**2", "m_s2", "ms2", "ms-2"), "m/s²"),
    **dict.fromkeys(("mm/s2", "mm/s²", "mm/s^2", "mm_s2"), "mm/s²"),
    **dict.fromkeys(("mm/s", "mm_s"), "mm/s"),
    **dict.fromkeys(("m/s", "m_s"), "m/s"),
    **dict.fromkeys(("um", "µm", "μm", "micron"), "µm"),
    **{
        text: text
        for text in ("mm", "m", "V", "mV", "A", "mA", "Pa", "kPa", "bar", "N", "kN", "Nm", "s", "ms")
    },
    **{
        text: text
        for text in ("us", "Hz", "rpm", "deg", "rad", "C", "K", "N_m", "rad_s", "rad/s", "lbf", "ips")
    },
    "volt": "V",
    "volts": "V",
    "in/s": "in/s",
}
"""Units in the spellings after the last ``_`` → one spelling."""

BRACKETS = re.compile(r"^(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]$")


def named(header: str) -> tuple[str, str | None]:
    """Return a channel's name and its unit, None without one.

    Examples
    --------
    >>> named("accel_g"), named("accel [m/s2]"), named("gearbox_accel_m_s2"), named("accel_x")
    (('accel', 'g'), ('accel', 'm/s2'), ('gearbox_accel', 'm/s2'), ('accel_x', None))
    """
    text = header.strip().strip('"').strip()
    bracketed = BRACKETS.match(text)
    if bracketed and bracketed[1]:
        return bracketed[1].strip(), bracketed[2] or None
    pieces = text.split("_")
    for count in (2, 1):
        unit = "_".join(pieces[-count:])
        if len(pieces) > count and unit in UNITS:
            return "_".join(pieces[:-count]), unit.replace("_", "/") if count == 2 and "s" in unit else unit
    return text, None


def spelled(unit: str | None) -> str | None:
    """Return the standard spelling of a unit; an unknown unit is unchanged."""
    return None if unit is None else UNITS.get(unit, unit)


# Calibration: a factor, or a sensor's sensitivity as on its data sheet.


SENSITIVITY = re.compile(r"^\s*([-+.\deE]+)\s*(mV|V)\s*/\s*\(?\s*([^()]+?)\s*\)?\s*$")
VOLTS = {"mV": 1e-3, "V": 1.0}


def calibration_factor(name: str, value: float | str, unit: str | None) -> tuple[float, str | None]:
    """Return a channel's calibration factor and its new unit, None where the unit stays.

    Examples
    --------
    >>> calibration_factor("accel", "100 mV/g", "V"), calibration_factor("accel", "2.5", None)
    ((10.0, 'g'), (2.5, None))
    """
    if isinstance(value, str):
        match = SENSITIVITY.match(value)
        if match:
            size = _number(name, match[1]) * VOLTS[match[2]]
            volts = VOLTS.get(spelled(unit) or "V", 1.0)
            return volts / size, match[3]
    return _number(name, value), None


def _number(name: str, factor: float | str) -> float:
    try:
        value = float(factor)
    except ValueError:
        raise FormatError(
            f"calibration of {name!r} is {factor!r}; must be a factor, or a sensitivity as in 100mV/g"
        ) from None
    if not math.isfinite(value) or value == 0.0:
        raise FormatError(f"calibration of {name!r} is {factor}; must be a number other than 0")
    return value


# Windows as sums of cosines: values, gain, noise bandwidth, exact spectrum of a windowed sine.


COSINES: dict[str, tuple[float, ...]] = {
    "hann": (0.5, 0.5),
    "hamming": (0.54, 0.46),
    "blackman": (0.42, 0.50, 0.08),
    "flattop": (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
    "rect": (1.0,),
}
"""a of w[n] = Σ (−1)^k a_k cos(2πkn/N): periodic windows, as a Fourier transform needs them."""

SIDELOBE = {"hann": 0.03, "hamming": 0.01, "blackman": 0.002, "flattop": 0.001, "rect": 0.25}
"""Largest side lobe relative to the main lobe, with a margin."""


def window(name: str, length: int) -> Array:
    """Return a window (length,)."""
    angle = 2.0 * np.pi * np.arange(length) / length
    values = np.zeros(length)
    for k, a in enumerate(COSINES[name]):
        values += (-1) ** k * a * np.cos(k * angle)
    return values


def gain(name: str) -> float:
    """Return a window's mean, the factor on the amplitude of a sine on a bin.

    Examples
    --------
    >>> gain("hann")
    0.5
    """
    return COSINES[name][0]


def noise_bandwidth_bins(name: str) -> float:
    """Return the width of the rectangle that passes as much white noise, N Σw²/(Σw)² [bins].

    Examples
    --------
    >>> noise_bandwidth_bins("hann")
    1.5
    """
    first, *others = COSINES[name]
    return (first**2 + 0.5 * sum(a * a for a in others)) / first**2


def half_width_bins(name: str) -> int:
    """Return the bins from a sine's frequency to the edge of its main lobe."""
    return len(COSINES[name])


def line(name: str, length: int, offset_bins: Array) -> Complex:
    """Return the transform of the windowed e^(2πi d n/N), Σ w[n] e^(2πi d n/N), at offsets d.

    Parameters
    ----------
    name : str
        The window.
    length : int
        N.
    offset_bins : array
        d: the line's frequency less the bin's, in bins; whole or broken, of any size.

    Returns
    -------
    complex array
        Of the shape of ``offset_bins``.
    """
    total = COSINES[name][0] * _dirichlet(length, offset_bins)
    for k, a in enumerate(COSINES[name][1:], 1):
        both = _dirichlet(length, offset_bins + k) + _dirichlet(length, offset_bins - k)
        total += 0.5 * (-1) ** k * a * both
    return total


def _dirichlet(length: int, d: Array) -> Complex:
    """Return Σ e^(2πi d n/N) = e^(iπd(N−1)/N) sin πd / sin(πd/N); it repeats when d grows by N."""
    d = d - length * np.round(d / length)
    whole = np.round(d)
    above = np.sin(np.pi * (d - whole)) * (1.0 - 2.0 * (whole % 2.0))  # exactly nought on a bin
    below = np.sin(np.pi * d / length)
    at_zero = below == 0.0
    ratio = np.where(at_zero, float(length), above / np.where(at_zero, 1.0, below))
    return np.asarray(ratio * np.exp(1j * np.pi * (length - 1) / length * d))
