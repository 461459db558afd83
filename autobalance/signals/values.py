"""The report of a recorded signal, from its analysis."""

from __future__ import annotations

import numpy as np

from autobalance.signals.analysis import Analysis
from autobalance.signals.answer import (
    BearingFigures,
    ChannelFigures,
    RecordAnalysis,
    RecordFigures,
    Spectrum,
    TurningSpeed,
)
from autobalance.signals.explained import Explained, finite
from autobalance.signals.record import gain, noise_bandwidth_bins


def orders_values(analysis: Analysis, explained: Explained, other: Analysis | None) -> RecordAnalysis:
    """Return the report without head and input."""
    return RecordAnalysis(
        record=record_values(analysis),
        channel=analysis.channel.name,
        speed=_speed(analysis),
        spectrum=_spectrum(analysis, explained),
        orders=explained.orders,
        natural_frequencies_hz=[mode.frequency_hz for mode in analysis.modes],
        natural_modes=analysis.modes,
        crossings=analysis.crossings,
        bearing=_bearing(analysis),
        axes=analysis.circles,
        bands=explained.bands,
        comparison=explained.comparison,
        record_b=None if other is None else record_values(other),
        warnings=analysis.warnings
        + [f"second record: {each}" for each in ([] if other is None else other.warnings)],
    )


def record_values(analysis: Analysis) -> RecordFigures:
    """Return file, format, duration and channels of a record."""
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
    return TurningSpeed(
        source=speed.source,
        mean_rpm=mean,
        least_rpm=None if speeds is None else float(speeds.min()),
        greatest_rpm=None if speeds is None else float(speeds.max()),
        uncertainty_rpm=finite(speed.uncertainty_rpm),
        pulses=speed.pulses,
    )


def _spectrum(analysis: Analysis, explained: Explained) -> Spectrum:
    name = analysis.question.window
    return Spectrum(
        window=name,
        resolution_hz=explained.resolution_hz,
        gain=gain(name),
        noise_bandwidth_bins=noise_bandwidth_bins(name),
        peaks=explained.peaks,
    )


def _bearing(analysis: Analysis) -> BearingFigures | None:
    bearing = analysis.question.bearing
    if bearing is None:
        return None
    return BearingFigures(
        **bearing.orders(),
        band_hz=None if analysis.envelope is None else list(analysis.envelope.band_hz),
        envelope=analysis.defects or (),
    )


def psd_csv(analysis: Analysis) -> bytes:
    """Return the power spectral density of the record, with its standard error, as CSV."""
    unit, power = analysis.channel.unit or "1", analysis.power
    lines = [f"frequency_hz,density [{unit}^2/Hz],standard_error [{unit}^2/Hz]"]
    rows = zip(power.frequencies_hz, power.density, power.scatter, strict=True)
    lines += [f"{f:.6g},{density:.6g},{error:.3g}" for f, density, error in rows]
    return ("\n".join(lines) + "\n").encode()
