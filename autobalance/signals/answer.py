"""The report of a recorded signal, from its analysis, and what it explains."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

import numpy as np

from autobalance.declare import ABSENT, INLINE, Absent, Count, NotNegative, Ordinal, Pair, Positive, record
from autobalance.report.records.answers import Head
from autobalance.signals.analysis import SignalAnalysis, uncertain_ratio
from autobalance.signals.bearing import Defect
from autobalance.signals.by_angle import WhirlCircles
from autobalance.signals.modes import Mode
from autobalance.signals.record import gain, noise_bandwidth_bins
from autobalance.signals.sources import OrderSource, candidates, natural_sources
from autobalance.signals.spectra import Band, band_levels
from autobalance.signals.speed import Crossing
from autobalance.signals.tacho import TachoPulses
from autobalance.types import Complex
from autobalance.value_classes import dataclass

# Sines and orders of a record with their possible causes, and orders of two records side by side.


SAME_ORDER = 1e-9
"""Largest difference of two equal orders."""
NOISE_SIGMAS = 3.0
"""Multiple of its standard error below which an order's amplitude is noise."""
ROUNDING_SHARE = 1e-10
"""Share of a record's largest order below which an amplitude is rounding: pieces of a record without noise
scatter by no more than that."""


@dataclass(frozen=True)
class Peak:
    """A sine of the spectrum."""

    frequency_hz: NotNegative
    amplitude: NotNegative
    phase_deg: float
    order: NotNegative | None
    sources: Sequence[str] | None


@dataclass(frozen=True)
class OrderFigures:
    """An order's amplitude and phase; None where the record is too short for it."""

    order: Positive
    amplitude: NotNegative | None
    phase_deg: float | None
    uncertainty: NotNegative | None
    sources: Sequence[str]


@dataclass(frozen=True)
class ComparedOrder:
    """An order in two records."""

    order: Positive
    a: NotNegative
    b: NotNegative
    ratio: float | None
    uncertainty: NotNegative | None
    absent: Annotated[Sequence[Literal["a", "b"]], "records in which it is below the noise"]


@dataclass(frozen=True, eq=False)
class Explained:
    """Sines and orders with their sources, levels in bands, and the orders beside those of another record.

    ``resolution_hz`` is the spacing of the lines of the record's spectrum.
    """

    resolution_hz: float
    peaks: list[Peak]
    orders: list[OrderFigures]
    bands: list[Band]
    comparison: list[ComparedOrder] | None


def explained(
    analysis: SignalAnalysis, sources: Sequence[OrderSource], other: SignalAnalysis | None = None
) -> Explained:
    """Return a record's sines and orders with their possible causes, beside those of another record."""
    resolution = analysis.channel.sample_rate_hz / len(analysis.channel)
    return Explained(
        resolution,
        _peaks(analysis, sources, resolution),
        _orders(analysis, sources),
        band_levels(analysis.channel),
        None if other is None else _compared(analysis, other),
    )


def _peaks(analysis: SignalAnalysis, sources: Sequence[OrderSource], resolution: float) -> list[Peak]:
    """Return the sines of a record; with a steady speed also their orders and possible causes."""
    turning = analysis.speed.turning
    mean_hz = None if turning is None or not analysis.speed.is_steady else turning.mean_rpm / 60.0
    natural = [mode.frequency_hz for mode in analysis.modes]
    peaks = []
    for sine in analysis.sines:
        order, texts = None, None
        if mean_hz is not None:
            order = sine.frequency_hz / mean_hz
            texts = candidates(order, max(2.0 * resolution / mean_hz, 2e-3 * order), sources)
            texts += natural_sources(natural, sine.frequency_hz, 2.0 * resolution)
        peaks.append(Peak(sine.frequency_hz, sine.amplitude, degrees(sine.phase_rad), order, texts))
    return peaks


def _orders(analysis: SignalAnalysis, sources: Sequence[OrderSource]) -> list[OrderFigures]:
    """Return all half orders up to the highest of the question, with their possible causes."""
    lines = analysis.lines
    known: Complex = np.zeros(0, dtype=complex) if lines is None else lines.amplitudes
    errors = np.zeros(0) if lines is None else lines.standard_errors()
    rows = []
    for place in range(round(2 * analysis.question.max_order)):
        order = 0.5 * (place + 1)
        amplitude = complex(known[place]) if place < len(known) else None
        rows.append(
            OrderFigures(
                order,
                None if amplitude is None else abs(amplitude),
                None if amplitude is None else degrees(float(np.angle(amplitude))),
                finite(float(errors[place])) if place < len(errors) else None,
                candidates(order, SAME_ORDER, sources),
            )
        )
    return rows


def _compared(first: SignalAnalysis, second: SignalAnalysis) -> list[ComparedOrder]:
    """Return orders of two records side by side; the ratio is None where one of them is noise."""
    if first.lines is None or second.lines is None:
        return []
    every = first.lines.amplitudes, second.lines.amplitudes
    floor_a, floor_b = (ROUNDING_SHARE * float(np.abs(each).max(initial=0.0)) for each in every)
    rows = []
    pairs = zip(
        first.lines.orders, first.lines.amplitudes, second.lines.amplitudes, first.lines.standard_errors(),
        second.lines.standard_errors(), strict=False,
    )  # fmt: skip
    for order, a, b, error_a, error_b in pairs:
        ratio, doubt = uncertain_ratio(complex(a), complex(b), float(error_a), float(error_b))
        noise: list[Literal["a", "b"]] = []
        noise += ["a"] if _is_noise(abs(a), float(error_a), floor_a) else []
        noise += ["b"] if _is_noise(abs(b), float(error_b), floor_b) else []
        if noise:
            ratio = doubt = None
        rows.append(ComparedOrder(float(order), abs(a), abs(b), finite(ratio), finite(doubt), noise))
    return rows


def finite(value: float | None) -> float | None:
    """Return a finite number as a float, all else as None."""
    return float(value) if value is not None and math.isfinite(value) else None


def degrees(radians: float) -> float:
    """Return an angle in (−180, 180]."""
    turned = math.degrees(radians)
    wrapped = turned - 360.0 * math.ceil((turned - 180.0) / 360.0)
    return 180.0 if wrapped <= -180.0 else wrapped


def _is_noise(amplitude: float, standard_error: float, floor: float) -> bool:
    return amplitude <= floor or (math.isfinite(standard_error) and amplitude < NOISE_SIGMAS * standard_error)


# The report of `orders`.


@record
class ChannelFigures:
    """A channel of a record."""

    name: str
    unit: str | None
    sample_rate_hz: Positive
    samples: Count
    clipped: NotNegative


@record
class RecordFigures:
    """Contents of a record."""

    file: str | None
    format: str
    duration_s: NotNegative
    channels: Sequence[ChannelFigures]


@record
class TurningSpeed:
    """The speed of the shaft, and where it is known from."""

    source: str | None
    mean_rpm: float | None
    least_rpm: float | None
    greatest_rpm: float | None
    uncertainty_rpm: NotNegative | None
    pulses: TachoPulses | None


@record
class Spectrum:
    """Sines of a record."""

    window: str
    resolution_hz: Positive
    gain: Positive
    noise_bandwidth_bins: Positive
    peaks: Sequence[Peak]


@record
class BearingFigures:
    """Orders of a rolling bearing's defects, and the envelope's lines at them."""

    bpfo: float
    bpfi: float
    ftf: float
    bsf: float
    ball_defect: float
    band_hz: Sequence[float] | None
    envelope: Sequence[Defect]


@record
class RecordAnalysis:
    """Results of the analysis of a record."""

    record: RecordFigures
    channel: str
    speed: TurningSpeed
    spectrum: Spectrum
    orders: Sequence[OrderFigures]
    natural_frequencies_hz: Sequence[float]
    natural_modes: Sequence[Mode]
    crossings: Sequence[Crossing]
    bearing: BearingFigures | None
    axes: WhirlCircles | None
    bands: Sequence[Band]
    comparison: Sequence[ComparedOrder] | None
    record_b: RecordFigures | None
    warnings: Sequence[str]


@record
class AskedBearing:
    """A rolling bearing as it was requested."""

    balls: float
    ball: float
    pitch: float
    contact: float
    speed: float


@record
class Asked:
    """The record and its request; None without a request."""

    record: str | None
    record_b: str | None
    channel: str | None
    sample_rate: Positive | None
    calibration: Mapping[str, float | str]
    speed_rpm: Positive | None
    tacho: str | None
    pulses_per_rev: Ordinal | None
    threshold: float | None
    window: str
    max_order: Positive
    peaks: Count
    natural: bool
    excitation: str | None
    frequencies: Sequence[Positive] | None
    bearing: AskedBearing | None
    band: Pair | None
    axes: Sequence[str] | None
    job: str | None
    quantity: str | None
    drive: str | None


@record
class OrdersReport(Head):
    """Spectrum, orders, natural frequencies and sources of a recorded signal."""

    command: Literal["orders"] = "orders"
    job_set: Sequence[str] | Absent = ABSENT
    input: Asked
    found: Annotated[RecordAnalysis, INLINE]


# The report of a recorded signal, from its analysis.


def orders_values(
    analysis: SignalAnalysis, explained: Explained, other: SignalAnalysis | None
) -> RecordAnalysis:
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


def record_values(analysis: SignalAnalysis) -> RecordFigures:
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


def _speed(analysis: SignalAnalysis) -> TurningSpeed:
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


def _spectrum(analysis: SignalAnalysis, explained: Explained) -> Spectrum:
    name = analysis.question.window
    return Spectrum(
        window=name,
        resolution_hz=explained.resolution_hz,
        gain=gain(name),
        noise_bandwidth_bins=noise_bandwidth_bins(name),
        peaks=explained.peaks,
    )


def _bearing(analysis: SignalAnalysis) -> BearingFigures | None:
    bearing = analysis.question.bearing
    if bearing is None:
        return None
    return BearingFigures(
        **bearing.orders(),
        band_hz=None if analysis.envelope is None else list(analysis.envelope.band_hz),
        envelope=analysis.defects or (),
    )


def psd_csv(analysis: SignalAnalysis) -> bytes:
    """Return the power spectral density of the record, with its standard error, as CSV."""
    unit, power = analysis.channel.unit or "1", analysis.power
    lines = [f"frequency_hz,density [{unit}^2/Hz],standard_error [{unit}^2/Hz]"]
    rows = zip(power.frequencies_hz, power.density, power.scatter, strict=True)
    lines += [f"{f:.6g},{density:.6g},{error:.3g}" for f, density, error in rows]
    return ("\n".join(lines) + "\n").encode()
