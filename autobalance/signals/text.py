"""The words and tables of a record."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from autobalance.signals.answer import BearingFigures, RecordAnalysis, TurningSpeed
    from autobalance.signals.axes import Circles
    from autobalance.signals.explained import ComparedOrder, OrderFigures
    from autobalance.signals.levels import Band

SHOWN_PEAKS = 10
SHOWN_SHARE = 0.01
"""Orders below this share of the largest are left out of the summary; the JSON lists every one."""


def orders_text(values: RecordAnalysis) -> str:
    parts = [_record(values), _speed(values.speed), _peaks(values), _orders(values), _modes(values)]
    parts += [_crossings(values), _bearing(values.bearing), _axes(values.axes), _bands(values.bands)]
    parts.append(_comparison(values.comparison))
    return "\n\n".join("\n".join(lines) for lines in parts if lines)


def _record(values: RecordAnalysis) -> list[str]:
    record = values.record
    lines = [f"{record.file} ({record.format}), {record.duration_s:.6g} s"]
    for each in record.channels:
        unit = f" [{each.unit}]" if each.unit else ""
        mark = "  <- this one" if each.name == values.channel else ""
        lines.append(f"  {each.name}{unit}, {each.samples} samples at {each.sample_rate_hz:.8g} Hz{mark}")
    return lines


def _speed(speed: TurningSpeed) -> list[str]:
    if speed.mean_rpm is None:
        return []
    doubt = "" if speed.uncertainty_rpm is None else f" ± {speed.uncertainty_rpm:.2g}"
    line = f"speed ({speed.source})  mean {speed.mean_rpm:.6g}{doubt} 1/min"
    least, greatest = speed.least_rpm, speed.greatest_rpm
    if least is not None and greatest is not None and greatest > 1.00001 * least:
        line += f", from {least:.6g} to {greatest:.6g}"
    pulses = speed.pulses
    if pulses is None:
        return [line]
    return [
        line,
        f"  {pulses.found} pulses, {pulses.missing} missing, {pulses.extra} too many, "
        f"jitter {100.0 * pulses.jitter:.2g} %",
    ]


def _peaks(values: RecordAnalysis) -> list[str]:
    peaks = values.spectrum.peaks
    if not peaks:
        return ["no sine stands out of the spectrum"]
    lines = ["frequency [Hz]    amplitude   phase [°]   order"]
    for peak in peaks[:SHOWN_PEAKS]:
        order = "" if peak.order is None else f"{peak.order:.4g}"
        lines.append(f"{peak.frequency_hz:14.5f} {peak.amplitude:12.6g} {peak.phase_deg:11.2f}   {order}")
    if len(peaks) > SHOWN_PEAKS:
        lines.append(f"and {len(peaks) - SHOWN_PEAKS} more in the JSON")
    return lines


def _orders(values: RecordAnalysis) -> list[str]:
    rows = shown_orders(values.orders)
    if not rows:
        return []
    lines = ["order    amplitude   phase [°]   may be"]
    for row in rows:
        first, *others = row.sources
        lines.append(f"{row.order:5g} {row.amplitude:12.6g} {row.phase_deg:11.2f}   {first}")
        lines += [" " * 33 + other for other in others]
    return lines


def shown_orders(orders: Sequence[OrderFigures]) -> list[OrderFigures]:
    """Return the orders that are known and no less than ``SHOWN_SHARE`` of the largest."""
    known = [(row, row.amplitude) for row in orders if row.amplitude is not None]
    least = SHOWN_SHARE * max((amplitude for _, amplitude in known), default=0.0)
    return [row for row, amplitude in known if amplitude >= least]


def _modes(values: RecordAnalysis) -> list[str]:
    if not values.natural_modes:
        return []
    lines = ["natural frequency [Hz]   damping ratio"]
    return lines + [f"{each.frequency_hz:22.4f} {each.damping_ratio:15.5f}" for each in values.natural_modes]


def _crossings(values: RecordAnalysis) -> list[str]:
    if not values.crossings:
        return []
    lines = ["crossings: frequency [Hz] at order: speed [1/min]"]
    frequencies = sorted({each.frequency_hz for each in values.crossings})
    for f in frequencies:
        causes = [f"{c.order:g}: {c.speed_rpm:.0f}" for c in values.crossings if c.frequency_hz == f]
        lines.append(f"{f:10.4g}  " + ", ".join(causes))
    return lines


def _bearing(bearing: BearingFigures | None) -> list[str]:
    if bearing is None:
        return []
    lines = ["bearing        order   frequency [Hz]   in the envelope"]
    for each in bearing.envelope:
        seen = f"{each.amplitude:.4g}" if each.found else "nothing"
        lines.append(f"{each.name:12s} {each.order:7.4f} {each.frequency_hz:16.4f}   {seen}")
    return lines


def _axes(axes: Circles | None) -> list[str]:
    if axes is None:
        return []
    return [
        f"order {axes.order:g} in the plane: forward {axes.forward:.5g}, "
        f"backward {axes.backward:.5g}: {axes.verdict}"
    ]


def _bands(bands: Sequence[Band]) -> list[str]:
    return [
        f"RMS {each.low_hz:g} to {each.high_hz:g} Hz  {each.quantity} {each.rms:.4g} {each.unit}"
        for each in bands
    ]


def _comparison(rows: Sequence[ComparedOrder] | None) -> list[str]:
    if not rows:
        return []
    lines = ["order            a            b        a/b"]
    for row in rows:
        ratio = "" if row.ratio is None else f"{row.ratio:10.4f}"
        if row.absent:
            ratio = f"absent in {' and '.join(row.absent)}"
        doubt = "" if row.uncertainty is None else f" ± {row.uncertainty:.2g}"
        lines.append(f"{row.order:5g} {row.a:12.5g} {row.b:12.5g} {ratio}{doubt}")
    return lines
