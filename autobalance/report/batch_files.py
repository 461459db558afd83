"""The table of a batch as CSV, workbook, page and lines for people."""

from __future__ import annotations

import csv
import html
import io
import math
from collections import Counter
from typing import Any

Values = dict[str, Any]

BINS = 20
WIDTH, HEIGHT = 640, 160
NEWEST = 10


def results_csv(values: Values) -> bytes:
    """Return one line a row, in the list's order, without times: the same however it was run."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    rows = values["results"]
    writer.writerow(rows[0])
    for row in rows:
        writer.writerow(["" if cell is None else cell for cell in row.values()])
    return text.getvalue().encode()


def results_workbook(values: Values) -> bytes:
    """Return the table and the summary as a workbook."""
    import xlsxwriter

    buffer = io.BytesIO()
    with xlsxwriter.Workbook(buffer, {"in_memory": True, "strings_to_formulas": False}) as book:
        bold = book.add_format({"bold": True})
        table = book.add_worksheet("Results")
        rows = values["results"]
        table.write_row(0, 0, list(rows[0]), bold)
        for number, row in enumerate(rows, 1):
            table.write_row(number, 0, ["" if cell is None else cell for cell in row.values()])
        table.freeze_panes(1, 2)
        table.autofilter(0, 0, len(rows), len(rows[0]) - 1)
        summary = book.add_worksheet("Summary")
        lines: list[tuple[str, Any]] = [
            (key, values[key]) for key in ("rows", "within", "above", "failed", "lost", "taken_over")
        ]
        lines += [("", ""), ("Reason", "Rows"), *reasons(values)]
        lines += [("", ""), ("Capability", ""), *capability(values).items()]
        for number, (name, value) in enumerate(lines):
            summary.write_row(number, 0, [name, "" if value is None else value])
        summary.set_column(0, 0, 60)
    return buffer.getvalue()


def reasons(values: Values) -> list[tuple[str, int]]:
    """Return the messages of rows that are not within, most frequent first."""
    said = Counter(row["message"] or row["outcome"] for row in values["results"] if row["exit_code"] != 0)
    return sorted(said.items(), key=lambda item: (-item[1], item[0]))


def capability(values: Values) -> dict[str, float | None]:
    """Return mean, standard deviation and P_pk of the share used of the permissible value.

    P_pk = (1 − mean)/(3 s): there is an upper limit only (ISO 22514-2, of the sample as a whole).
    """
    shares = [row["worst_share"] for row in values["results"] if row["worst_share"] is not None]
    if len(shares) < 2:
        return {"mean": shares[0] if shares else None, "standard_deviation": None, "p_pk": None}
    mean = sum(shares) / len(shares)
    deviation = math.sqrt(sum((share - mean) ** 2 for share in shares) / (len(shares) - 1))
    index = (1.0 - mean) / (3.0 * deviation) if deviation > 0.0 else None
    return {"mean": mean, "standard_deviation": deviation, "p_pk": index}


def summary_page(values: Values) -> bytes:
    """Return counts, reasons, histogram, capability and the table as one page."""
    rows = values["results"]
    head = "".join(f"<th>{html.escape(key)}</th>" for key in rows[0])
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(_cell(cell))}</td>" for cell in row.values()) + "</tr>"
        for row in rows
    )
    why = "".join(f"<tr><td>{count}</td><td>{html.escape(text)}</td></tr>" for text, count in reasons(values))
    able = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{_cell(value)}</td></tr>"
        for name, value in capability(values).items()
    )
    page = f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>Batch</title>
<style>body{{font:14px sans-serif;margin:2em}}table{{border-collapse:collapse;margin:0 0 1.5em}}
td,th{{border:1px solid #bbb;padding:2px 6px;text-align:left}}</style>
<h1>Batch: {values["within"]} of {values["rows"]} within tolerance</h1>
<p>{values["above"]} above, {values["failed"]} failed, {values["lost"]} lost</p>
<h2>Reasons</h2><table><tr><th>rows</th><th>reason</th></tr>{why}</table>
<h2>Share used of the permissible value</h2>{_histogram(values)}
<table>{able}</table>
<h2>Results</h2><table><tr>{head}</tr>{body}</table></html>
"""
    return page.encode()


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _histogram(values: Values) -> str:
    """Return a histogram of the greatest share used as SVG; the line is the permissible value."""
    shares = [row["worst_share"] for row in values["results"] if row["worst_share"] is not None]
    if not shares:
        return "<p>none</p>"
    top = max(1.0, *shares)
    counts = Counter(min(int(share / top * BINS), BINS - 1) for share in shares)
    most, step = max(counts.values()), WIDTH / BINS
    bars = "".join(
        f'<rect x="{place * step:.1f}" y="{HEIGHT * (1 - count / most):.1f}" width="{step - 1:.1f}" '
        f'height="{HEIGHT * count / most:.1f}" fill="#567"/>'
        for place, count in sorted(counts.items())
    )
    limit = WIDTH / top
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT + 20}" width="{WIDTH}" role="img" aria-label="histogram">{bars}'
        f'<line x1="{limit:.1f}" x2="{limit:.1f}" y1="0" y2="{HEIGHT}" stroke="#c00"/>'
        f'<text x="0" y="{HEIGHT + 15}">0</text><text x="{WIDTH}" y="{HEIGHT + 15}" text-anchor="end">'
        f"{top:.3g}</text></svg>"
    )


def batch_text(values: Values) -> str:
    """Return the counts and the reasons as lines."""
    lines = [
        f"{values['rows']} rows: {values['within']} within tolerance, {values['above']} above, "
        f"{values['failed']} failed, {values['lost']} lost; {values['taken_over']} taken over",
    ]
    for text, count in reasons(values)[:NEWEST]:
        lines.append(f"{count:6d}  {text}")
    return "\n".join(lines)
