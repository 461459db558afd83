"""The report of `orders`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from autobalance.declare import ABSENT, INLINE, Absent, Count, NotNegative, Ordinal, Pair, Positive, record
from autobalance.report.records.answers import Head
from autobalance.signals.bearing import Defect
from autobalance.signals.by_angle import Circles
from autobalance.signals.explained import ComparedOrder, OrderFigures, Peak
from autobalance.signals.modes import Mode
from autobalance.signals.spectra import Band
from autobalance.signals.speed import Crossing
from autobalance.signals.tacho import TachoPulses


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
    axes: Circles | None
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
