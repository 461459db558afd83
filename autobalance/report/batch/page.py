"""The summary page of a batch: reasons by frequency, a histogram, capability, and the table."""

from __future__ import annotations

import html
from collections import Counter
from typing import Any

from autobalance.report.batch.files import capability, grouped_reasons

Values = dict[str, Any]

BINS = 20
WIDTH, HEIGHT = 640, 180
LEFT, BELOW = 44, 36
MOST_REASONS = 12
QUARTERS_TO = 3.0
"""Shares used up to which the histogram's axis has quarters."""
STYLE = """
body{font:14px/1.45 system-ui,sans-serif;margin:2em auto;max-width:76em;padding:0 1em}
body{color:#222;background:#fff}
table{border-collapse:collapse;margin:0 0 1.5em;font-variant-numeric:tabular-nums}
td,th{border:1px solid #bbb;padding:2px 8px;text-align:left}th{background:#eee}td.n{text-align:right}
.wide{overflow-x:auto}.bar{display:inline-block;height:.8em;background:#567;vertical-align:baseline}
svg text{font:12px system-ui,sans-serif;fill:#222}
"""
NAMES = {
    "mean": "mean of the share used",
    "standard_deviation": "standard deviation",
    "p_pk": "P_pk, upper limit 1 (1.33 is usual)",
}


def summary_page(values: Values) -> bytes:
    """Return the page; it needs nothing but itself."""
    page = f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>Batch</title><style>{STYLE}</style>
<h1>Batch: {values["within"]} of {values["rows"]} within tolerance</h1>
<p>{values["above"]} above, {values["failed"]} failed, {values["lost"]} lost.</p>
<h2>Reasons, the most frequent first</h2>{_pareto(values)}
<h2>Greatest share used of what is permitted</h2>{_histogram(values)}
{_capability(values)}
<h2>Results</h2>{_table(values)}</html>
"""
    return page.encode()


def _pareto(values: Values) -> str:
    """Return the reasons with bars, and how much of all they make together so far."""
    reasons = grouped_reasons(values)
    total = sum(count for _, count, _ in reasons)
    if not total:
        return "<p>None: every row is within tolerance.</p>"
    rows, so_far = [], 0
    for text, count, example in reasons[:MOST_REASONS]:
        so_far += count
        bar = f'<span class="bar" style="width:{12.0 * count / reasons[0][1]:.2f}em"></span>'
        shares = (
            html.escape(example)
            if count == 1
            else f"{html.escape(text)}<br><small>{html.escape(example)}</small>"
        )
        rows.append(
            f'<tr><td class="n">{count}</td><td>{bar}</td><td class="n">{100.0 * so_far / total:.0f} %</td>'
            f"<td>{shares}</td></tr>"
        )
    left = len(reasons) - MOST_REASONS
    more = f"<p>{left} reasons more, each with fewer rows.</p>" if left > 0 else ""
    head = "<tr><th>rows</th><th></th><th>together</th><th>reason</th></tr>"
    return f"<table>{head}{''.join(rows)}</table>{more}"


def _histogram(values: Values) -> str:
    """Return a histogram of the greatest share used as SVG; the dashed line is the permissible value."""
    shares = [row["worst_share"] for row in values["results"] if row["worst_share"] is not None]
    if not shares:
        return "<p>No row has a residual.</p>"
    top = 1.05 * max(1.0, *shares)
    counts = Counter(min(int(share / top * BINS), BINS - 1) for share in shares)
    most, step = max(counts.values()), WIDTH / BINS

    def up(count: float) -> float:
        return 10.0 + HEIGHT * (1.0 - count / most)

    bars = "".join(
        f'<rect x="{LEFT + place * step:.1f}" y="{up(count):.1f}" width="{step - 1:.1f}" '
        f'height="{HEIGHT * count / most:.1f}" fill="#567"><title>{count} rows</title></rect>'
        for place, count in sorted(counts.items())
    )
    limit, floor = LEFT + WIDTH / top, HEIGHT + 10
    ticks = "".join(
        f'<text x="{LEFT + WIDTH * share / top:.1f}" y="{floor + 15}" text-anchor="middle">{share:g}</text>'
        for share in _ticks(top)
    )
    return (
        f'<svg viewBox="0 0 {LEFT + WIDTH + 10} {floor + BELOW}" width="{LEFT + WIDTH + 10}" role="img" '
        f'aria-label="histogram of the greatest share used">{bars}'
        f'<path d="M{LEFT} 10V{floor}H{LEFT + WIDTH}" fill="none" stroke="#222"/>'
        f'<line x1="{limit:.1f}" x2="{limit:.1f}" y1="10" y2="{floor}" stroke="#c00" stroke-dasharray="6 4"/>'
        f'<text x="{LEFT - 6}" y="18" text-anchor="end">{most}</text>'
        f'<text x="{LEFT - 6}" y="{floor}" text-anchor="end">0</text>{ticks}'
        f'<text x="{LEFT + WIDTH / 2}" y="{floor + 32}" text-anchor="middle">'
        "share used [-]; dashed: permissible</text></svg>"
    )


def _ticks(top: float) -> list[float]:
    """Return the shares that the axis names: so few that none stands on another."""
    if top <= QUARTERS_TO:
        return [0.25 * number for number in range(int(4.0 * top) + 1)]
    step = max(1, round(top / 6.0))
    return [float(share) for share in range(0, int(top) + 1, step)]


def _capability(values: Values) -> str:
    rows = "".join(
        f'<tr><td>{NAMES[name]}</td><td class="n">{_cell(value)}</td></tr>'
        for name, value in capability(values).items()
    )
    return f"<table>{rows}</table>"


def _table(values: Values) -> str:
    rows = values["results"]
    head = "".join(f"<th>{html.escape(key)}</th>" for key in rows[0])
    body = "".join("<tr>" + "".join(_data(cell) for cell in row.values()) + "</tr>" for row in rows)
    return f'<div class="wide"><table><tr>{head}</tr>{body}</table></div>'


def _data(cell: Any) -> str:
    kind = ' class="n"' if isinstance(cell, int | float) else ""
    return f"<td{kind}>{html.escape(_cell(cell))}</td>"


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, str) and len(value) == 64:  # a digest
        return value[:12] + "…"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
