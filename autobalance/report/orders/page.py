"""``orders.html``: the record and its spectrum to zoom into, and what was found, on one page."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from importlib import resources
from typing import Any

import numpy as np

from autobalance.report.orders.text import SHOWN_SHARE
from autobalance.report.page.html import SOURCE
from autobalance.signal.analysis import Analysis
from autobalance.signal.record import Channel
from autobalance.signal.sines import amplitude_spectrum
from autobalance.types import Array
from autobalance.wording import escape

Values = dict[str, Any]

MOST_POINTS = 1 << 18
"""Of a curve on the page; neighbours are put together, least and greatest, where a record has more."""
SPECTRUM_SAMPLES = 1 << 21
SIZES = "<style>.curve canvas{width:100%;height:320px;display:block;touch-action:none;cursor:grab}.curve output{color:var(--soft);font-size:13px}</style>"  # noqa: E501


def orders_page(analysis: Analysis, values: Values) -> str:
    """Return the whole page; it needs no other file and asks for none."""
    name = escape(values["record"]["file"])
    data = json.dumps(
        {"record": _record_curve(analysis), "spectrum": _spectrum_curve(analysis, values)}, allow_nan=False
    )
    data = data.replace("<", "\\u003c")  # no text can end the script element
    script = _asset("orders.js").replace("</script", r"<\/script")
    sections = (
        _curve("record", f"The record: {analysis.channel.name}"),
        _curve("spectrum", "Its amplitude spectrum"),
        _peaks(values),
        _orders(values),
        _others(values),
    )
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{SOURCE}">
<title>Orders – {name}</title>
<style>{_asset("page.css")}</style>{SIZES}
</head>
<body>
<header class="top">
<p class="kicker"><b>Orders</b><span>{name}</span></p>
<div class="verdict"><h1>{_headline(values)}</h1>{_warnings(values)}</div>
</header>
<main>{"".join(sections)}</main>
<footer><p>autobalance {escape(values["autobalance"]["version"])}. This page holds
everything it shows and asks the network for nothing.</p></footer>
<script type="application/json" id="orders-data">{data}</script>
<script>{script}</script>
</body>
</html>
"""


def _asset(name: str) -> str:
    return (resources.files("autobalance.report") / "assets" / name).read_text(encoding="utf-8")


def _headline(values: Values) -> str:
    speed = values["speed"]["mean_rpm"]
    rows = [row for row in values["orders"] if row["amplitude"] is not None]
    if speed is None or not rows:
        peaks = values["spectrum"]["peaks"]
        return f"{peaks[0]['frequency_hz']:.5g} Hz is the strongest sine" if peaks else "No sine stands out"
    best = max(rows, key=lambda row: row["amplitude"])
    return f"{speed:.5g} 1/min; order {best['order']:g} is the strongest"


def _warnings(values: Values) -> str:
    return "".join(f'<p class="reason">{escape(text)}</p>' for text in values["warnings"])


def _curve(name: str, title: str) -> str:
    return (
        f'<section class="curve"><h2>{escape(title)}</h2>'
        '<p class="lead">Wheel or + − zooms, dragging or arrows move, '
        f'a double click or 0 shows all. <output></output></p><canvas data-curve="{name}" tabindex="0" '
        f'aria-label="{escape(title)}"></canvas></section>'
    )


def _encoded(values: Array) -> str:
    return base64.b64encode(np.asarray(values, dtype="<f4").tobytes()).decode()


def _record_curve(analysis: Analysis) -> Values:
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
    """Return least and greatest of neighbours, block by block."""
    low, high = [], []
    block = max(few, (1 << 20) // few * few)
    for _, piece in channel.blocks(block):
        rows = np.pad(piece, (0, -len(piece) % few), "edge").reshape(-1, few)
        low.append(rows.min(axis=1))
        high.append(rows.max(axis=1))
    return np.concatenate(low), np.concatenate(high)


def _spectrum_curve(analysis: Analysis, values: Values) -> Values:
    channel = analysis.channel
    f, size = amplitude_spectrum(
        channel.values(0, SPECTRUM_SAMPLES), channel.sample_rate_hz, analysis.question.window
    )
    few = max(1, -(-len(f) // MOST_POINTS))
    rows = np.pad(size, (0, -len(size) % few), "edge").reshape(-1, few)
    marks = [
        {
            "at": peak["frequency_hz"],
            "value": peak["amplitude"],
            "text": f"{peak['order']:.4g}" if peak["order"] is not None else f"{peak['frequency_hz']:.5g}",
        }
        for peak in values["spectrum"]["peaks"]
    ]
    return {
        "low": _encoded(rows.min(axis=1)), "high": _encoded(rows.max(axis=1)), "first": 0.0,
        "step": float(f[1]) * few, "unit": "Hz", "x": "frequency [Hz]", "y": "amplitude", "log": True,
        "least": float(max(size.max(), 1e-30)) * 1e-7, "marks": marks,
    }  # fmt: skip


def _table(title: str, heads: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    if not rows:
        return ""
    head = "".join(f"<th>{escape(each)}</th>" for each in heads)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return (
        f'<section><h2>{escape(title)}</h2><div class="scroll"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div></section>"
    )


def _peaks(values: Values) -> str:
    rows = [
        (
            f"{peak['frequency_hz']:.5f}",
            f"{peak['amplitude']:.6g}",
            f"{peak['phase_deg']:.2f}",
            "" if peak["order"] is None else f"{peak['order']:.5g}",
            "; ".join(peak["sources"] or ()),
        )
        for peak in values["spectrum"]["peaks"]
    ]
    return _table("Sines", ("frequency [Hz]", "amplitude", "phase [°]", "order", "may be"), rows)


def _orders(values: Values) -> str:
    known = [row for row in values["orders"] if row["amplitude"] is not None]
    least = SHOWN_SHARE * max((row["amplitude"] for row in known), default=0.0)
    rows = [
        (f"{row['order']:g}", f"{row['amplitude']:.6g}", f"{row['phase_deg']:.2f}", "; ".join(row["sources"]))
        for row in known
        if row["amplitude"] >= least
    ]
    return _table("Orders", ("order", "amplitude", "phase [°]", "may be"), rows)


def _others(values: Values) -> str:
    modes = [
        (f"{each['frequency_hz']:.4f}", f"{each['damping_ratio']:.5f}") for each in values["natural_modes"]
    ]
    bearing = values["bearing"]
    lines = [
        (
            each["name"],
            f"{each['order']:.4f}",
            f"{each['frequency_hz']:.4f}",
            f"{each['amplitude']:.4g}" if each["found"] else "–",
        )
        for each in (bearing or {}).get("envelope", ())
    ]
    return _table("Natural frequencies", ("frequency [Hz]", "damping ratio"), modes) + _table(
        "Bearing, in the envelope", ("defect", "order", "frequency [Hz]", "amplitude"), lines
    )
