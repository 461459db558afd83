"""The summary page of a batch: reasons by frequency, a histogram, capability, and the table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from autobalance.report.page.templates import rendered
from autobalance.studies.batch.answer import BatchReport, capability, grouped, rows_of
from autobalance.types import Values

BINS = 20
WIDTH, HEIGHT = 640, 180
LEFT, BELOW = 44, 36
MOST_REASONS = 12
QUARTERS_TO = 3.0
"""Largest share used at which the histogram's axis has quarters."""
NAMES = {
    "mean": "mean of the share used",
    "standard_deviation": "standard deviation",
    "p_pk": "P_pk, upper limit 1 (1.33 is usual)",
}


def summary_page(report: BatchReport) -> bytes:
    """Return the page; it needs no other file."""
    reasons, shares = list(_reasons(report)), report.worst_shares
    page = rendered(
        "batch.html",
        batch=report,
        rows=rows_of(report),
        reasons=reasons[:MOST_REASONS],
        reasons_left=len(reasons) - MOST_REASONS,
        histogram=_histogram(shares),
        capability=[(NAMES[name], value) for name, value in capability(shares).items()],
        plain=_plain,
    )
    return page.encode()


def _reasons(report: BatchReport) -> Iterator[Values]:
    """Yield the reasons, each with the share of all rows up to it [%]."""
    reasons = grouped(report.reasons)
    total, so_far = sum(count for _, count, _ in reasons), 0
    for text, count, example in reasons:
        so_far += count
        share = 100.0 * so_far / total
        yield {"text": text, "rows": count, "example": example, "together_percent": share}


def _histogram(shares: Sequence[float]) -> str:
    """Return a histogram of the largest share used as SVG; empty if no row has a residual."""
    if not shares:
        return ""
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
        f'aria-label="histogram of the largest share used">{bars}'
        f'<path d="M{LEFT} 10V{floor}H{LEFT + WIDTH}" fill="none" stroke="#222"/>'
        f'<line x1="{limit:.1f}" x2="{limit:.1f}" y1="10" y2="{floor}" stroke="#c00" stroke-dasharray="6 4"/>'
        f'<text x="{LEFT - 6}" y="18" text-anchor="end">{most}</text>'
        f'<text x="{LEFT - 6}" y="{floor}" text-anchor="end">0</text>{ticks}'
        f'<text x="{LEFT + WIDTH / 2}" y="{floor + 32}" text-anchor="middle">'
        "share used [-]; dashed: permissible</text></svg>"
    )


def _ticks(top: float) -> list[float]:
    """Return the shares that the axis names: so few that none overlaps another."""
    if top <= QUARTERS_TO:
        return [0.25 * number for number in range(int(4.0 * top) + 1)]
    step = max(1, round(top / 6.0))
    return [float(share) for share in range(0, int(top) + 1, step)]


def _plain(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, str) and len(value) == 64:  # a digest
        return value[:12] + "…"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
