"""A record: channels of samples at even steps of time (or of angle), each with its unit and calibration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import FormatError
from autobalance.types import Array

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
class Record:
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

    def calibrated(self, factors: Mapping[str, tuple[float, str | None]]) -> Record:
        """Return the record with channels multiplied by factors, with new units where these are not None."""
        factor_of = {id(self.channel(name)): value for name, value in factors.items()}

        def scaled(channel: Channel) -> Channel:
            if id(channel) not in factor_of:
                return channel
            factor, unit = factor_of[id(channel)]
            return replace(channel, factor=channel.factor * factor, unit=unit or channel.unit)

        return replace(self, channels=tuple(scaled(each) for each in self.channels))

    def at_speed(self, speed_rpm: float) -> Record:
        """Return a record sampled by angle as one sampled by time, at a constant speed."""
        if self.samples_per_turn is None:
            return self
        rate = self.samples_per_turn * speed_rpm / 60.0
        return replace(self, channels=tuple(replace(each, sample_rate_hz=rate) for each in self.channels))
