"""Rolling bearings: the orders of defects, and the envelope in which they show."""

from __future__ import annotations

import numpy as np
from scipy import fft

from autobalance.errors import FormatError
from autobalance.signals.by_angle import TURN, Turning
from autobalance.signals.record import Channel
from autobalance.signals.sines import Sine, find_sines
from autobalance.signals.sources import MAX_SLIP, BearingSource
from autobalance.types import Array
from autobalance.value_classes import dataclass

FEWEST_TURNS = 4


@dataclass(frozen=True)
class Defect:
    """A line of the envelope at (or beside) a bearing's order."""

    name: str
    order: float
    frequency_hz: float
    amplitude: float
    found: bool


@dataclass(frozen=True, eq=False)
class SignalEnvelope:
    """Magnitude of a band's signal, at its own lower sample rate, from the record's first sample on."""

    values: Array
    sample_rate_hz: float
    band_hz: tuple[float, float]


def envelope(channel: Channel, low_hz: float, high_hz: float) -> SignalEnvelope:
    """Return |x + i Hilbert(x)| of a band; only the band's part of the spectrum is transformed back.

    Raises
    ------
    FormatError
        If the band is not within the record's spectrum.
    """
    rate = channel.sample_rate_hz
    if not 0.0 <= low_hz < high_hz <= 0.5 * rate:
        raise FormatError(
            f"the band is {low_hz:g} to {high_hz:g} Hz; it must lie between 0 and "
            f"half the sample rate, {0.5 * rate:g}"
        )
    values = channel.values()
    count = len(values)
    spectrum = fft.rfft(values - values.mean())
    first, last = int(np.ceil(low_hz * count / rate)), min(int(high_hz * count / rate), count // 2)
    band = 2.0 * spectrum[max(first, 1) : last + 1]
    # Four times the band's width: the size of a sum has no end, but little beyond that.
    length = min(fft.next_fast_len(4 * max(len(band), 4)), count)
    length = max(length, len(band))
    wide = np.zeros(length, dtype=complex)
    wide[: len(band)] = band
    size = np.abs(fft.ifft(wide)) * (length / count)
    return SignalEnvelope(size, rate * length / count, (low_hz, high_hz))


def liveliest_band(channel: Channel) -> tuple[float, float]:
    """Return the band, a quarter or an eighth of the spectrum, whose envelope has the strongest peaks.

    The measure is kurtosis times power: bursts with energy, not the quietest ones. The lowest eighth is left
    out: it holds shafts and gears, not the resonances that a defect excites.
    """
    half = 0.5 * channel.sample_rate_hz
    piece = Channel(channel.name, None, channel.sample_rate_hz, channel.values(0, 1 << 20))
    bands = [(k * half / 8.0, (k + width) * half / 8.0) for width in (1, 2) for k in range(1, 8 - width)]

    def peakedness(band: tuple[float, float]) -> float:
        values = envelope(piece, *band).values
        spread = values - values.mean()
        power = float((spread**2).mean())
        return float((spread**4).mean()) / power if power > 0.0 else 0.0

    return max(bands, key=peakedness)


def defects(band_envelope: SignalEnvelope, turning: Turning, bearing: BearingSource) -> list[Defect]:
    """Return the envelope's lines at each of a bearing's orders, by the shaft's angle.

    The envelope is read at even steps of angle, so that a speed that varies does not smear its lines. The
    list is empty where the envelope is too slow for the orders, or the record too short.
    """
    fastest = float(turning.speeds_rpm().max()) / 60.0
    top = min(2.5 * max(bearing.orders().values()), 0.45 * band_envelope.sample_rate_hz / fastest)
    if top < max(bearing.orders().values()) or turning.turns < FEWEST_TURNS:
        return []
    by_turn, per_turn = _by_turn(band_envelope, turning, top)
    sines = find_sines(by_turn, per_turn, most=24)
    mean_hz = turning.mean_rpm / 60.0
    return [
        _defect(name, order, sines, by_turn, per_turn, mean_hz) for name, order in bearing.orders().items()
    ]


def _by_turn(band_envelope: SignalEnvelope, turning: Turning, top: float) -> tuple[Array, float]:
    """Return the envelope at even steps of angle, and the number of these steps per turn."""
    from autobalance.signals.by_angle import by_angle, samples_per_turn

    channel = Channel("envelope", None, band_envelope.sample_rate_hz, band_envelope.values)
    first = turning.angles_rad[0]
    turns = int((turning.angles_rad[-1] - max(first, 0.0)) / TURN)
    per_turn = samples_per_turn(top)
    return np.concatenate(list(by_angle(channel, turning, per_turn, top, turns))), float(per_turn)


def _defect(
    name: str, order: float, sines: list[Sine], values: Array, per_turn: float, mean_hz: float
) -> Defect:
    near = [
        sine
        for sine in sines
        if abs(sine.frequency_hz - order) <= max(MAX_SLIP * order, per_turn / len(values))
    ]
    if near:
        best = max(near, key=lambda sine: sine.amplitude)
        return Defect(name, order, best.frequency_hz * mean_hz, best.amplitude, True)
    angle = np.arange(len(values)) * (TURN / per_turn * order)
    weights = np.hanning(len(values))
    amplitude = 2.0 * abs(((values - values.mean()) * weights) @ np.exp(-1j * angle)) / weights.sum()
    return Defect(name, order, order * mean_hz, float(amplitude), False)
