"""What was found in a record as JSON values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from autobalance.report.records.orders import (
    Band,
    BearingFigures,
    ChannelFigures,
    CircleFigures,
    ComparedOrder,
    OrderFigures,
    Peak,
    Quantity,
    RecordAnalysis,
    RecordFigures,
    Spectrum,
    TachoPulses,
    TurningSpeed,
)
from autobalance.signal.analysis import Analysis, uncertain_ratio
from autobalance.signal.header import spelled
from autobalance.signal.sources import Source, candidates, natural_sources
from autobalance.signal.spectra import BANDS_HZ, band_rms, quantity, welch
from autobalance.signal.windows import gain, noise_bandwidth_bins
from autobalance.types import Complex

Values = dict[str, Any]
BOTH: tuple[Literal["a", "b"], ...] = ("a", "b")
ABSENT = 3.0
"""Standard errors below which an order's amplitude is noise."""
QUANTITIES: tuple[Quantity, ...] = ("displacement", "velocity", "acceleration")
UNITS = {"displacement": ("µm", 1e6), "velocity": ("mm/s", 1e3), "acceleration": ("m/s²", 1.0)}


def finite(value: float | None) -> float | None:
    """Return a number, or None where there is none."""
    return float(value) if value is not None and math.isfinite(value) else None


def degrees(radians: float) -> float:
    """Return an angle in (−180, 180]."""
    turned = math.degrees(radians)
    wrapped = turned - 360.0 * math.ceil((turned - 180.0) / 360.0)
    return 180.0 if wrapped <= -180.0 else wrapped


def orders_values(analysis: Analysis, sources: Sequence[Source], other: Analysis | None) -> RecordAnalysis:
    """Return everything but the head and the input."""
    return RecordAnalysis(
        record=record_values(analysis),
        channel=analysis.channel.name,
        speed=_speed(analysis),
        spectrum=_spectrum(analysis, sources),
        orders=_orders(analysis, sources),
        natural_frequencies_hz=[mode.frequency_hz for mode in analysis.modes],
        natural_modes=analysis.modes,
        crossings=analysis.crossings,
        bearing=_bearing(analysis),
        axes=_axes(analysis),
        bands=_bands(analysis),
        comparison=None if other is None else _comparison(analysis, other),
        record_b=None if other is None else record_values(other),
        warnings=analysis.warnings
        + [f"second record: {each}" for each in ([] if other is None else other.warnings)],
    )


def record_values(analysis: Analysis) -> RecordFigures:
    """Return what a record holds."""
    record = analysis.record
    return RecordFigures(
        file=record.file,
        format=record.format,
        duration_s=record.duration_s,
        channels=[
            ChannelFigures(
                name=each.name,
                unit=each.unit,
                sample_rate_hz=each.sample_rate_hz,
                samples=len(each),
                clipped=analysis.clipped[each.name],
            )
            for each in record.channels
        ],
    )


def _speed(analysis: Analysis) -> TurningSpeed:
    speed, turning = analysis.speed, analysis.speed.turning
    speeds = None if turning is None else turning.speeds_rpm()
    mean = None if turning is None else turning.mean_rpm
    if analysis.question.speed_rpm is not None:  # as it was given, without the rounding of an angle
        mean, speeds = analysis.question.speed_rpm, np.array([analysis.question.speed_rpm])
    pulses = speed.pulses
    return TurningSpeed(
        source=speed.source,
        mean_rpm=mean,
        least_rpm=None if speeds is None else float(speeds.min()),
        greatest_rpm=None if speeds is None else float(speeds.max()),
        uncertainty_rpm=finite(speed.uncertainty_rpm),
        pulses=None
        if pulses is None
        else TachoPulses(
            found=pulses.found,
            missing=pulses.missing,
            extra=pulses.extra,
            jitter_percent=100.0 * pulses.jitter,
            pattern_percent=100.0 * pulses.pattern,
        ),
    )


def _spectrum(analysis: Analysis, sources: Sequence[Source]) -> Spectrum:
    channel, name = analysis.channel, analysis.question.window
    turning = analysis.speed.turning
    mean_hz = None if turning is None or not analysis.speed.is_steady else turning.mean_rpm / 60.0
    resolution = channel.sample_rate_hz / len(channel)
    natural = [mode.frequency_hz for mode in analysis.modes]
    peaks = []
    for sine in analysis.sines:
        order = None if mean_hz is None else sine.frequency_hz / mean_hz
        texts = None
        if order is not None and mean_hz is not None:
            texts = candidates(order, max(2.0 * resolution / mean_hz, 2e-3 * order), sources)
            texts += natural_sources(natural, sine.frequency_hz, 2.0 * resolution)
        peaks.append(
            Peak(
                frequency_hz=sine.frequency_hz,
                amplitude=sine.amplitude,
                phase_deg=degrees(sine.phase_rad),
                order=order,
                sources=texts,
            )
        )
    return Spectrum(
        window=name,
        resolution_hz=resolution,
        gain=gain(name),
        noise_bandwidth_bins=noise_bandwidth_bins(name),
        peaks=peaks,
    )


def _orders(analysis: Analysis, sources: Sequence[Source]) -> list[OrderFigures]:
    count = round(2 * analysis.question.max_order)
    lines = analysis.lines
    known: Complex = np.zeros(0, dtype=complex) if lines is None else lines.amplitudes
    errors = np.zeros(0) if lines is None else lines.standard_errors()
    rows = []
    for place in range(count):
        order = 0.5 * (place + 1)
        amplitude = complex(known[place]) if place < len(known) else None
        rows.append(
            OrderFigures(
                order=order,
                amplitude=None if amplitude is None else abs(amplitude),
                phase_deg=None if amplitude is None else degrees(float(np.angle(amplitude))),
                uncertainty=finite(float(errors[place])) if place < len(errors) else None,
                sources=candidates(order, 1e-9, sources),
            )
        )
    return rows


def _bearing(analysis: Analysis) -> BearingFigures | None:
    bearing = analysis.question.bearing
    if bearing is None:
        return None
    return BearingFigures(
        **bearing.orders(),
        band_hz=None if analysis.envelope is None else list(analysis.envelope.band_hz),
        envelope=analysis.defects or (),
    )


def _axes(analysis: Analysis) -> CircleFigures | None:
    if analysis.circles is None:
        return None
    each = analysis.circles
    return CircleFigures(order=each.order, forward=each.forward, backward=each.backward, verdict=each.verdict)


def _bands(analysis: Analysis) -> list[Band]:
    """Return RMS of acceleration, velocity and displacement in the usual bands, where the unit is known."""
    channel = analysis.channel
    known = quantity(spelled(channel.unit))
    if known is None:
        return []
    times, size = known
    rows = []
    for low, high in BANDS_HZ:
        if high > 0.5 * channel.sample_rate_hz or low * channel.duration_s < 4.0:
            continue
        spectrum = welch(channel, least_hz=low)
        for derivative, name in enumerate(QUANTITIES):
            unit, scale = UNITS[name]
            rms = band_rms(spectrum, low, high, derivative - times) * size * scale
            rows.append(Band(quantity=name, unit=unit, low_hz=low, high_hz=high, rms=rms))
    return rows


def _comparison(first: Analysis, second: Analysis) -> list[ComparedOrder]:
    """Return orders of two records side by side."""
    if first.lines is None or second.lines is None:
        return []
    rows = []
    pairs = zip(
        first.lines.orders, first.lines.amplitudes, second.lines.amplitudes, first.lines.standard_errors(),
        second.lines.standard_errors(), strict=False,
    )  # fmt: skip
    for order, a, b, error_a, error_b in pairs:
        ratio, doubt = uncertain_ratio(complex(a), complex(b), float(error_a), float(error_b))
        absent = _absent(abs(a), float(error_a)), _absent(abs(b), float(error_b))
        if any(absent):  # a ratio of noise is none
            ratio = doubt = None
        rows.append(
            ComparedOrder(
                order=float(order),
                a=abs(a),
                b=abs(b),
                ratio=finite(ratio),
                uncertainty=finite(doubt),
                absent=[name for name, none in zip(BOTH, absent, strict=True) if none],
            )
        )
    return rows


def _absent(amplitude: float, standard_error: float) -> bool:
    """Return whether an order is below the noise of its record."""
    return bool(np.isfinite(standard_error)) and amplitude < ABSENT * standard_error


def psd_csv(analysis: Analysis) -> bytes:
    """Return the power spectral density of the record by Welch's mean, with its standard error, as CSV."""
    unit = analysis.channel.unit or "1"
    spectrum = welch(analysis.channel, analysis.question.window)
    lines = [f"frequency_hz,density [{unit}^2/Hz],standard_error [{unit}^2/Hz]"]
    rows = zip(spectrum.frequencies_hz, spectrum.density, spectrum.scatter, strict=True)
    lines += [f"{f:.6g},{density:.6g},{error:.3g}" for f, density, error in rows]
    return ("\n".join(lines) + "\n").encode()
