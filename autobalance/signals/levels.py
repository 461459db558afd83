"""Levels of vibration: acceleration, velocity and displacement in the usual bands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from autobalance.declare import NotNegative, Positive
from autobalance.signals.header import spelled
from autobalance.signals.record import Channel
from autobalance.signals.spectra import BANDS_HZ, band_rms, quantity, welch

Quantity = Literal["displacement", "velocity", "acceleration"]
QUANTITIES: tuple[Quantity, ...] = ("displacement", "velocity", "acceleration")
UNITS = {"displacement": ("µm", 1e6), "velocity": ("mm/s", 1e3), "acceleration": ("m/s²", 1.0)}
MIN_PERIODS = 4.0
"""Periods of a band's lowest frequency that a record must hold."""


@dataclass(frozen=True)
class Band:
    """RMS of a quantity in a band."""

    quantity: Quantity
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
