"""The report of `batch`, and its page."""

from __future__ import annotations

import csv
import io
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import INLINE, Count, NotNegative, Ordinal, Positive, Sha256, Values, encoded, record
from autobalance.report.page.templates import rendered
from autobalance.report.records.answers import Head
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.solid.formats.table import endings

# The report of `batch`.


@record
class RowNumbers:
    """Numbers of a row's report in the table; None of a row that has no report."""

    mass_g: Positive | None = None
    initial_g_mm: NotNegative | None = None
    residual_g_mm: NotNegative | None = None
    permissible_g_mm: Positive | None = None
    worst_share: NotNegative | None = None
    removed_g: float | None = None
    cuts: Count | None = None
    solid_sha256: Sha256 | None = None


@record
class RowFigures:
    """A row of the table."""

    row: Ordinal
    name: str
    job: str
    crank: str
    exit_code: Count
    outcome: Outcome | Literal["error", "lost"]
    message: Annotated[str, "the reason, or the error; one line"]
    numbers: Annotated[RowNumbers, INLINE]
    settings: Annotated[Mapping[str, Any], INLINE, "further columns: keys of the job, as the list has them"]


@record
class BatchReport(Head):
    """Many jobs, a row each."""

    command: Literal["batch"] = "batch"
    rows: Count
    within: Count
    above: Count
    failed: Count
    lost: Count
    taken_over: Count
    results: Sequence[RowFigures]
    seconds: Positive

    @property
    def reasons(self) -> list[str]:
        """Why rows are not within tolerance, one each."""
        return [row.message or row.outcome for row in self.results if row.exit_code != 0]

    @property
    def worst_shares(self) -> list[float]:
        """Largest share used of the permissible value, of each row that has a residual."""
        shares = [row.numbers.worst_share for row in self.results]
        return [share for share in shares if share is not None]


# The table of a batch as CSV, workbook, page and lines for people.


NEWEST_ROWS = 10
OWN_WORDS = re.compile(
    rf"\S*/\S*|\S+(?:{'|'.join(map(re.escape, (*endings(), '.toml', '.xlsx')))})\b"
    r"|[-+±]?\d[\d.,]*(?:[eE][-+]?\d+)?",
    re.IGNORECASE,
)
"""Files and numbers of a message, which differ from row to row."""


def rows_of(report: BatchReport) -> list[Values]:
    """Return the rows of the table by column: those of the list behind the others."""
    return [encoded(row) for row in report.results]


def results_csv(report: BatchReport) -> bytes:
    """Return one line a row, in the order of the list, without times: the same in every run."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    rows = rows_of(report)
    writer.writerow(rows[0])
    for row in rows:
        writer.writerow(["" if cell is None else cell for cell in row.values()])
    return text.getvalue().encode()


def results_workbook(report: BatchReport) -> bytes:
    """Return the table and the summary as a workbook."""
    import xlsxwriter

    buffer = io.BytesIO()
    with xlsxwriter.Workbook(buffer, {"in_memory": True, "strings_to_formulas": False}) as book:
        bold = book.add_format({"bold": True})
        table = book.add_worksheet("Results")
        rows = rows_of(report)
        table.write_row(0, 0, list(rows[0]), bold)
        for number, row in enumerate(rows, 1):
            table.write_row(number, 0, ["" if cell is None else cell for cell in row.values()])
        table.freeze_panes(1, 2)
        table.autofilter(0, 0, len(rows), len(rows[0]) - 1)
        summary = book.add_worksheet("Summary")
        lines: list[tuple[str, Any]] = [
            ("rows", report.rows),
            ("within", report.within),
            ("above", report.above),
            ("failed", report.failed),
            ("lost", report.lost),
            ("taken_over", report.taken_over),
            ("", ""),
            ("Reason", "Rows"),
            *((text, count) for text, count, _ in grouped(report.reasons)),
            ("", ""),
            ("Capability", ""),
            *capability(report.worst_shares).items(),
        ]
        for number, (name, value) in enumerate(lines):
            summary.write_row(number, 0, [name, "" if value is None else value])
        summary.set_column(0, 0, 60)
    return buffer.getvalue()


def grouped(reasons: Iterable[str]) -> list[tuple[str, int, str]]:
    """Return (reason, rows, example) of reasons that differ only in numbers, names and files.

    Examples
    --------
    >>> grouped(["a.stl does not exist", "b.stl does not exist"])
    [('… does not exist', 2, 'a.stl does not exist')]
    """
    first: dict[str, str] = {}
    counts: Counter[str] = Counter()
    for why in reasons:
        reason = OWN_WORDS.sub("…", why)
        first.setdefault(reason, why)
        counts[reason] += 1
    return sorted(((text, count, first[text]) for text, count in counts.items()), key=lambda x: (-x[1], x[0]))


def capability(shares: Sequence[float]) -> dict[str, float | None]:
    """Return mean, standard deviation and P_pk of the shares used of the permissible value.

    P_pk = (1 − mean)/(3 s): there is an upper limit only (ISO 22514-2, of the sample as a whole).
    """
    if len(shares) < 2:
        return {"mean": shares[0] if shares else None, "standard_deviation": None, "p_pk": None}
    mean = sum(shares) / len(shares)
    deviation = math.sqrt(sum((share - mean) ** 2 for share in shares) / (len(shares) - 1))
    index = (1.0 - mean) / (3.0 * deviation) if deviation > 0.0 else None
    return {"mean": mean, "standard_deviation": deviation, "p_pk": index}


def batch_text(report: BatchReport) -> str:
    lines = [
        f"{report.rows} rows: {report.within} within tolerance, {report.above} above, "
        f"{report.failed} failed, {report.lost} lost; {report.taken_over} taken over",
    ]
    for text, count, example in grouped(report.reasons)[:NEWEST_ROWS]:
        lines.append(f"{count:6d}  {example if count == 1 else text}")
    return "\n".join(lines)


# The summary page of a batch: reasons by frequency, a histogram, capability, and the table.


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
