"""``orders.html``: the record and its spectrum to zoom into, and the findings, on one page."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING

import numpy as np

from autobalance.report.page.templates import rendered
from autobalance.signals.analysis import SignalAnalysis
from autobalance.signals.record import Channel
from autobalance.signals.show import shown_orders
from autobalance.signals.sines import amplitude_spectrum
from autobalance.types import Array, Values

if TYPE_CHECKING:
    from autobalance.signals.answer import OrdersReport, RecordAnalysis

MOST_POINTS = 1 << 18
"""Most points of a curve; longer records are thinned to smallest and largest of neighbours."""
SPECTRUM_SAMPLES = 1 << 21


def orders_page(analysis: SignalAnalysis, report: OrdersReport) -> str:
    """Return the whole page; it needs no other file."""
    values = report.found
    return rendered(
        "orders.html",
        file=values.record.file,
        headline=_headline(values),
        warnings=values.warnings,
        channel=analysis.channel.name,
        sines=_sines(values),
        orders=[
            (f"{row.order:g}", f"{row.amplitude:.6g}", f"{row.phase_deg:.2f}", "; ".join(row.sources))
            for row in shown_orders(values.orders)
        ],
        modes=[(f"{each.frequency_hz:.4f}", f"{each.damping_ratio:.5f}") for each in values.natural_modes],
        bearing=_bearing(values),
        version=report.autobalance.version,
        curves={"record": _record_curve(analysis), "spectrum": _spectrum_curve(analysis, values)},
    )


def _headline(values: RecordAnalysis) -> str:
    speed = values.speed.mean_rpm
    sizes = {row.order: row.amplitude for row in values.orders if row.amplitude is not None}
    if speed is None or not sizes:
        peaks = values.spectrum.peaks
        return f"{peaks[0].frequency_hz:.5g} Hz is the strongest sine" if peaks else "No sine stands out"
    return f"{speed:.5g} 1/min; order {max(sizes, key=sizes.__getitem__):g} is the strongest"


def _encoded(values: Array) -> str:
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode()


def _record_curve(analysis: SignalAnalysis) -> Values:
    channel = analysis.channel
    few = max(1, -(-len(channel) // MOST_POINTS))
    low, high = _extremes(channel, few)
    unit = f" [{channel.unit}]" if channel.unit else ""
    step = few / channel.sample_rate_hz
    return {
        "low": _encoded(low), "high": _encoded(high), "first": 0.0, "step": step, "unit": "s",
        "x": "time [s]", "y": f"{channel.name}{unit}",
    }  # fmt: skip


def _extremes(channel: Channel, few: int) -> tuple[Array, Array]:
    """Return the least and the largest of each ``few`` samples of a channel."""
    low, high = [], []
    block = max(few, (1 << 20) // few * few)
    for _, piece in channel.blocks(block):
        rows = np.pad(piece, (0, -len(piece) % few), "edge").reshape(-1, few)
        low.append(rows.min(axis=1))
        high.append(rows.max(axis=1))
    return np.concatenate(low), np.concatenate(high)


def _spectrum_curve(analysis: SignalAnalysis, values: RecordAnalysis) -> Values:
    channel = analysis.channel
    f, size = amplitude_spectrum(
        channel.values(0, SPECTRUM_SAMPLES), channel.sample_rate_hz, analysis.question.window
    )
    few = max(1, -(-len(f) // MOST_POINTS))
    rows = np.pad(size, (0, -len(size) % few), "edge").reshape(-1, few)
    marks = [
        {
            "at": peak.frequency_hz,
            "value": peak.amplitude,
            "text": f"{peak.order:.4g}" if peak.order is not None else f"{peak.frequency_hz:.5g}",
        }
        for peak in values.spectrum.peaks
    ]
    return {
        "low": _encoded(rows.min(axis=1)), "high": _encoded(rows.max(axis=1)), "first": 0.0,
        "step": float(f[1]) * few, "unit": "Hz", "x": "frequency [Hz]", "y": "amplitude", "log": True,
        "least": float(max(size.max(), 1e-30)) * 1e-7, "marks": marks,
    }  # fmt: skip


def _sines(values: RecordAnalysis) -> list[tuple[str, ...]]:
    return [
        (
            f"{peak.frequency_hz:.5f}",
            f"{peak.amplitude:.6g}",
            f"{peak.phase_deg:.2f}",
            "" if peak.order is None else f"{peak.order:.5g}",
            "; ".join(peak.sources or ()),
        )
        for peak in values.spectrum.peaks
    ]


def _bearing(values: RecordAnalysis) -> list[tuple[str, ...]]:
    return [
        (
            each.name,
            f"{each.order:.4f}",
            f"{each.frequency_hz:.4f}",
            f"{each.amplitude:.4g}" if each.found else "–",
        )
        for each in (() if values.bearing is None else values.bearing.envelope)
    ]
