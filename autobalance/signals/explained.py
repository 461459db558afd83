"""Sines and orders of a record with their possible causes, and orders of two records side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np

from autobalance.declare import NotNegative, Positive
from autobalance.signals.analysis import Analysis, uncertain_ratio
from autobalance.signals.sources import Source, candidates, natural_sources
from autobalance.signals.spectra import Band, band_levels
from autobalance.types import Complex
from autobalance.value_classes import dataclass

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


def explained(analysis: Analysis, sources: Sequence[Source], other: Analysis | None = None) -> Explained:
    """Return a record's sines and orders with their possible causes, beside those of another record."""
    resolution = analysis.channel.sample_rate_hz / len(analysis.channel)
    return Explained(
        resolution,
        _peaks(analysis, sources, resolution),
        _orders(analysis, sources),
        band_levels(analysis.channel),
        None if other is None else _compared(analysis, other),
    )


def _peaks(analysis: Analysis, sources: Sequence[Source], resolution: float) -> list[Peak]:
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


def _orders(analysis: Analysis, sources: Sequence[Source]) -> list[OrderFigures]:
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


def _compared(first: Analysis, second: Analysis) -> list[ComparedOrder]:
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
