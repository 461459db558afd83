"""A record as lines to read, and as plots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.report.plots import Plot, drawn
from autobalance.signals.analysis import SignalAnalysis
from autobalance.signals.record import Channel
from autobalance.signals.sines import amplitude_spectrum
from autobalance.signals.speed import Map, OrderCut, order_cuts, order_map, waterfall
from autobalance.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from autobalance.signals.answer import (
        BearingFigures,
        ComparedOrder,
        OrderFigures,
        RecordAnalysis,
        TurningSpeed,
    )
    from autobalance.signals.by_angle import WhirlCircles
    from autobalance.signals.spectra import Band


# The words and tables of a record.


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


def _axes(axes: WhirlCircles | None) -> list[str]:
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


# Plots of a record: spectrum, orders, waterfall, order map, cuts, envelope, circles.


Files = dict[str, Plot]
SHOWN_SAMPLES = 1 << 21
CUTS = 4
POINTS = 4000
"""Most points of a curve, more than its pixels."""
PLOT_SHOWN_SHARE = 0.02
"""An order below this share of the strongest is not drawn: its phase is noise."""
DECADES = 3.0
"""Decades of amplitude that a map shows, from its largest down."""
ANGLES = np.linspace(0.0, 2.0 * np.pi, 181)
DOTTED_LINE: dict[str, Any] = {"color": "0.5", "linestyle": ":", "linewidth": 1.0}


def orders_plots(
    analysis: SignalAnalysis, values: RecordAnalysis, predicted: Sequence[tuple[float | None, float]] = ()
) -> Files:
    """Return every plot that the record allows; ``predicted`` (speed, frequency) are on the waterfall."""
    unit = f" [{analysis.channel.unit}]" if analysis.channel.unit else ""
    label = f"{analysis.channel.name}{unit}"
    drawn: Files = {"spectrum": _spectrum(analysis, values, label)}
    drawn["psd"] = _psd(analysis)
    turning = analysis.speed.turning
    top = _top_hz(analysis)
    fall = waterfall(analysis.channel, analysis.question.window, top, turning)
    drawn["waterfall"] = _waterfall(fall, label, analysis, values, predicted)
    if turning is not None and analysis.lines is not None:
        drawn["orders"] = _plot_orders(values, label)
        mapped = order_map(analysis.channel, turning, _max_order(analysis))
        if mapped is not None:
            drawn["order-map"] = _order_map(mapped, label)
        cuts = order_cuts(analysis.channel, turning, _max_order(analysis))
        strongest = _strongest(cuts)
        if len(cuts) and len(cuts[0].times_s) > 3:
            drawn |= _cuts(strongest, label, steady=analysis.speed.is_steady)
    if analysis.envelope is not None:
        drawn["envelope"] = _envelope(analysis, values, label)
    if values.axes is not None:
        drawn["full-spectrum"] = _full_spectrum(analysis, values.axes.verdict)
    return drawn


def _strongest(cuts: list[OrderCut]) -> list[OrderCut]:
    """Return the few orders that stand out of the others, the strongest first."""
    sizes = {cut.order: float(np.median(np.abs(cut.amplitudes))) for cut in cuts}
    falling = sorted(cuts, key=lambda cut: -sizes[cut.order])[:CUTS]
    return [cut for cut in falling if sizes[cut.order] > PLOT_SHOWN_SHARE * sizes[falling[0].order]]


def _max_order(analysis: SignalAnalysis) -> float:
    return analysis.question.max_order if analysis.lines is None else float(analysis.lines.orders[-1])


def _top_hz(analysis: SignalAnalysis) -> float:
    """Return the highest frequency of the waterfall, from the highest order, sines or modes."""
    half = 0.5 * analysis.channel.sample_rate_hz
    if analysis.speed.turning is None:
        highest = max(
            [sine.frequency_hz for sine in analysis.sines]
            + [mode.frequency_hz for mode in analysis.modes]
            + [0.0]
        )
        return min(half, 3.0 * highest) if highest > 0.0 else half
    fastest = float(analysis.speed.turning.speeds_rpm().max()) / 60.0
    highest = max([mode.frequency_hz for mode in analysis.modes], default=0.0)
    return min(half, max(1.05 * analysis.question.max_order * fastest, 1.5 * highest))


def _spectrum(analysis: SignalAnalysis, values: RecordAnalysis, label: str) -> Plot:
    channel = analysis.channel
    f, size = amplitude_spectrum(
        channel.values(0, SHOWN_SAMPLES), channel.sample_rate_hz, analysis.question.window
    )
    top = max([peak.frequency_hz for peak in values.spectrum.peaks] + [_top_hz(analysis)])
    shown = f <= min(1.1 * top, 0.5 * channel.sample_rate_hz)

    def draw(axes: Axes) -> None:
        x, y = _envelope_of(f[shown][1:], size[shown][1:])
        axes.semilogy(x, np.maximum(y, 1e-12 * size.max() + 1e-300), color="black", linewidth=0.8)
        peaks = values.spectrum.peaks
        axes.plot(
            [p.frequency_hz for p in peaks], [p.amplitude for p in peaks], "o", color="0.35",
            fillstyle="none", label="sines, between bins too",
        )  # fmt: skip
        axes.set_xlabel("frequency [Hz]")

    return drawn("Amplitude spectrum", label, draw)


def _psd(analysis: SignalAnalysis) -> Plot:
    """Return the power spectral density with its standard error."""
    density = analysis.power
    f, mean, off = density.frequencies_hz[1:], density.density[1:], density.scatter[1:]
    floor = 1e-12 * float(mean.max(initial=0.0)) + 1e-300

    def draw(axes: Axes) -> None:
        low, high = np.maximum(mean - off, floor), np.maximum(mean + off, floor)
        axes.fill_between(f, low, high, color="0.8", linewidth=0.0, label="± standard error")
        axes.loglog(f, np.maximum(mean, floor), color="black", linewidth=0.8)
        axes.set_xlabel("frequency [Hz]")

    unit = analysis.channel.unit or "1"
    title = f"Power spectral density, {density.segments} segments"
    return drawn(title, f"{analysis.channel.name} [({unit})²/Hz]", draw)


def _envelope_of(x: Array, y: Array) -> tuple[Array, Array]:
    """Return curves with more points than pixels reduced to the largest of neighbours."""
    few = -(-len(x) // POINTS)
    if few < 2:
        return x, y
    kept = len(x) // few * few
    return x[:kept:few], y[:kept].reshape(-1, few).max(axis=1)


def _plot_orders(values: RecordAnalysis, label: str) -> Plot:
    rows = [(row, row.amplitude) for row in values.orders if row.amplitude is not None]

    def draw(axes: Axes) -> None:
        at = [row.order for row, _ in rows]
        sizes = [amplitude for _, amplitude in rows]
        axes.bar(
            at, sizes, 0.35, color=["0.2" if order % 1.0 == 0.0 else "0.7" for order in at], edgecolor="black"
        )
        errors = [(row.order, amplitude, row.uncertainty) for row, amplitude in rows if row.uncertainty]
        if errors:
            x, y, off = zip(*errors, strict=True)
            axes.errorbar(x, y, off, fmt="none", color="black", capsize=3.0, label="± from turn to turn")
        axes.set_xlabel("order of the crank speed [-]")

    return drawn("Orders of the whole record", label, draw)


def _level(sizes: Array) -> Array:
    top = float(sizes.max()) or 1.0
    return np.asarray(np.log10(np.maximum(sizes / top, 10.0**-DECADES)))


def _colours(axes: Axes, x: Array, y: Array, sizes: Array, label: str) -> None:
    """Fill the axes with a map, dark where it is loud, a logarithmic scale beside it."""
    mesh = axes.pcolormesh(x, y, _level(sizes), cmap="Greys", shading="nearest", rasterized=True)
    figure = axes.get_figure()
    if figure is not None:
        bar = figure.colorbar(mesh, ax=axes)
        bar.set_label(f"log₁₀ of amplitude over its largest, {sizes.max():.4g} {label.partition(' ')[2]}")


def _waterfall(
    fall: Map,
    label: str,
    analysis: SignalAnalysis,
    values: RecordAnalysis,
    predicted: Sequence[tuple[float | None, float]],
) -> Plot:
    rising = fall.speeds_rpm is not None and not analysis.speed.is_steady
    speeds = fall.speeds_rpm

    def draw(axes: Axes) -> None:
        over = speeds if rising and speeds is not None else fall.times_s
        place = np.argsort(over, kind="stable")
        _colours(axes, fall.columns, over[place], fall.amplitudes[place], label)
        axes.set_xlabel("frequency [Hz]")
        for mode in values.natural_modes:
            axes.axvline(mode.frequency_hz, **DOTTED_LINE, label=f"natural {mode.frequency_hz:.4g} Hz")
        _predictions(axes, predicted, fall, rising=rising)
        if rising:
            sizes = {row.order: row.amplitude for row in values.orders if row.amplitude}
            strong = sorted(sizes, key=lambda order: -sizes[order])[:CUTS]
            ends = np.array([over.min(), over.max()])
            for order in strong:
                if sizes[order] <= PLOT_SHOWN_SHARE * sizes[strong[0]]:
                    continue
                axes.plot(order * ends / 60.0, ends, color="0.4", linestyle="--", linewidth=0.8)
                axes.annotate(f"{order:g}", (order * ends[1] / 60.0, ends[1]), fontsize="small")
        axes.set_xlim(0.0, float(fall.columns[-1]))

    return drawn("Waterfall" + (f" of {label}"), "speed [1/min]" if rising else "time [s]", draw)


def _predictions(
    axes: Axes, predicted: Sequence[tuple[float | None, float]], fall: Map, *, rising: bool
) -> None:
    """Draw computed natural frequencies: points where the speed is known, else lines."""
    top = float(fall.columns[-1])
    for f in sorted({f for speed, f in predicted if (speed is None or not rising) and f <= top}):
        axes.axvline(f, color="0.3", linestyle="-.", linewidth=0.9)
    if rising and fall.speeds_rpm is not None:
        low, high = float(fall.speeds_rpm.min()), float(fall.speeds_rpm.max())
        points = [(f, n) for n, f in predicted if n is not None and low <= n <= high and f <= top]
        if points:
            axes.plot(*zip(*points, strict=True), ".", color="0.3", markersize=3.0, label="computed")


def _order_map(order_map: Map, label: str) -> Plot:
    speeds = order_map.speeds_rpm
    if speeds is None:
        raise ValueError("an order map has speeds")
    steady = float(np.ptp(speeds)) < 0.02 * float(speeds.mean())

    def draw(axes: Axes) -> None:
        over = order_map.times_s if steady else speeds
        place = np.argsort(over, kind="stable")
        _colours(axes, order_map.columns, over[place], order_map.amplitudes[place], label)
        axes.set_xlabel("order of the crank speed [-]")

    return drawn("Order map" + f" of {label}", "time [s]" if steady else "speed [1/min]", draw)


def _cuts(cuts: list[OrderCut], label: str, *, steady: bool) -> Files:
    """Return amplitude and phase over the speed or time (Bode), and both as a polar plot."""
    x_label = "time [s]" if steady else "speed [1/min]"
    from autobalance.report.plots import STYLES

    def over(cut: OrderCut) -> Array:
        return cut.times_s if steady else cut.speeds_rpm

    def amplitudes(axes: Axes) -> None:
        for number, cut in enumerate(cuts):
            axes.plot(
                over(cut),
                np.abs(cut.amplitudes),
                label=f"order {cut.order:g}",
                **STYLES[number % len(STYLES)],
            )
        axes.set_xlabel(x_label)

    def phases(axes: Axes) -> None:
        for number, cut in enumerate(cuts):
            turned = np.degrees(np.unwrap(np.angle(cut.amplitudes)))
            axes.plot(over(cut), turned, label=f"order {cut.order:g}", **STYLES[number % len(STYLES)])
        axes.set_xlabel(x_label)

    def polar(axes: Axes) -> None:
        for number, cut in enumerate(cuts):
            path = cut.amplitudes
            axes.plot(path.real, path.imag, label=f"order {cut.order:g}", **STYLES[number % len(STYLES)])
        axes.plot(0.0, 0.0, "+", color="black")
        axes.set_xlabel(f"A cos φ, {label}")
        axes.set_aspect("equal", adjustable="datalim")

    return {
        "cuts": drawn("Order cuts", label, amplitudes),
        "cuts-phase": drawn("Phase of the orders", "phase [°]", phases),
        "cuts-polar": drawn("Order cuts, polar", f"A sin φ, {label}", polar),
    }


def _envelope(analysis: SignalAnalysis, values: RecordAnalysis, label: str) -> Plot:
    envelope = analysis.envelope
    if envelope is None:
        raise ValueError("there is no envelope")
    channel = Channel("envelope", analysis.channel.unit, envelope.sample_rate_hz, envelope.values)
    f, size = amplitude_spectrum(channel.values() - channel.values().mean(), channel.sample_rate_hz)
    marks = () if values.bearing is None else values.bearing.envelope
    top = 3.0 * max([mark.frequency_hz for mark in marks], default=channel.sample_rate_hz / 20.0)

    def draw(axes: Axes) -> None:
        shown = f <= min(top, 0.5 * channel.sample_rate_hz)
        axes.plot(*_envelope_of(f[shown], size[shown]), color="black", linewidth=0.8)
        for number, mark in enumerate(marks):
            style: dict[str, Any] = {
                "color": "0.3" if mark.found else "0.7",
                "linestyle": ("--", ":", "-.")[number % 3],
            }
            axes.axvline(mark.frequency_hz, label=f"{mark.name} {mark.order:.4g}", linewidth=1.0, **style)
        axes.set_xlabel("frequency [Hz]")

    low, high = envelope.band_hz
    return drawn(f"Envelope of {low:g} to {high:g} Hz", label, draw)


def _full_spectrum(analysis: SignalAnalysis, verdict: str) -> Plot:
    """Return the orders of X + iY with and against the shaft, the verdict in the title."""
    from autobalance.signals.speed import order_lines

    turning, names = analysis.speed.turning, analysis.question.axes
    if turning is None or names is None:
        raise ValueError("there are no axes")
    x, y = (order_lines(analysis.record.channel(name), turning, _max_order(analysis)) for name in names)
    if x is None or y is None:
        raise ValueError("too few turns")
    forward = np.abs(x.amplitudes + 1j * y.amplitudes) / 2.0
    backward = np.abs(x.amplitudes - 1j * y.amplitudes) / 2.0

    def draw(axes: Axes) -> None:
        axes.bar(x.orders, forward, 0.35, color="0.2", label="forward, X to Y")
        axes.bar(-x.orders, backward, 0.35, color="0.7", edgecolor="black", label="backward")
        axes.set_xlabel("order of the crank speed [-]")

    unit = f" [{analysis.channel.unit}]" if analysis.channel.unit else ""
    return drawn(f"Full spectrum: order 1 is {verdict}", f"radius of the circle{unit}", draw)
