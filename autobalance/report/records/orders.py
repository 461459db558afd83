"""The report of `orders`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.records import ABSENT, INLINE, Absent, Count, NotNegative, Positive, record
from autobalance.report.records.head import Head
from autobalance.signal.bearing import Defect
from autobalance.signal.crossings import Crossing
from autobalance.signal.modes import Mode

Quantity = Literal["displacement", "velocity", "acceleration"]


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
    """What a record holds."""

    file: str | None
    format: str
    duration_s: NotNegative
    channels: Sequence[ChannelFigures]


@record
class TachoPulses:
    """What is odd about the pulses of a tacho."""

    found: Count
    missing: Count
    extra: Count
    jitter_percent: NotNegative
    pattern_percent: NotNegative


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
class Peak:
    """A sine of the spectrum."""

    frequency_hz: NotNegative
    amplitude: NotNegative
    phase_deg: float
    order: NotNegative | None
    sources: Sequence[str] | None


@record
class Spectrum:
    """Sines of a record."""

    window: str
    resolution_hz: Positive
    gain: Positive
    noise_bandwidth_bins: Positive
    peaks: Sequence[Peak]


@record
class OrderFigures:
    """An order's amplitude and phase; None where the record is too short for it."""

    order: Positive
    amplitude: NotNegative | None
    phase_deg: float | None
    uncertainty: NotNegative | None
    sources: Sequence[str]


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
class CircleFigures:
    """The two circles of an order in two directions."""

    order: Positive
    forward: NotNegative
    backward: NotNegative
    verdict: str


@record
class Band:
    """RMS of a quantity in a band."""

    quantity: Quantity
    unit: str
    low_hz: NotNegative
    high_hz: Positive
    rms: NotNegative


@record
class ComparedOrder:
    """An order in two records."""

    order: Positive
    a: NotNegative
    b: NotNegative
    ratio: float | None
    uncertainty: NotNegative | None
    absent: Annotated[Sequence[Literal["a", "b"]], "records in which it is below the noise"]


@record
class RecordAnalysis:
    """What was found in a record."""

    record: RecordFigures
    channel: str
    speed: TurningSpeed
    spectrum: Spectrum
    orders: Sequence[OrderFigures]
    natural_frequencies_hz: Sequence[float]
    natural_modes: Sequence[Mode]
    crossings: Sequence[Crossing]
    bearing: BearingFigures | None
    axes: CircleFigures | None
    bands: Sequence[Band]
    comparison: Sequence[ComparedOrder] | None
    record_b: RecordFigures | None
    warnings: Sequence[str]


@record
class OrdersReport(Head):
    """Spectrum, orders, natural frequencies and sources of a recorded signal."""

    command: Literal["orders"] = "orders"
    job_set: Sequence[str] | Absent = ABSENT
    input: Mapping[str, Any]
    found: Annotated[RecordAnalysis, INLINE]
