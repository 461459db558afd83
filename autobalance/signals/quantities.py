"""A channel as another quantity: acceleration, velocity or displacement, by integration over time."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from autobalance.errors import FormatError
from autobalance.signals.header import spelled
from autobalance.signals.long_records import MAX_WHOLE
from autobalance.signals.record import Channel, Record
from autobalance.signals.spectra import integrated, quantity

Quantity = Literal["acceleration", "velocity", "displacement"]
DERIVED_QUANTITIES: dict[str, tuple[int, str, float]] = {
    "acceleration": (2, "m/s²", 1.0),
    "velocity": (1, "mm/s", 1e3),
    "displacement": (0, "µm", 1e6),
}
"""Order of the time derivative of displacement, unit of the result, and its number per SI unit."""
LOWEST_HZ = 2.0
"""Lowest frequency kept whole: below, integration would drown all in noise."""


def as_quantity(record: Record, target: Quantity, tacho: str | None) -> Record:
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
