"""The table of a batch as CSV, workbook, page and lines for people."""

from __future__ import annotations

import csv
import io
import math
import re
from collections import Counter
from typing import Any

from autobalance.types import Values

NEWEST_ROWS = 10
OWN_WORDS = re.compile(
    r"\S*/\S*|\S+\.(?:stl|obj|ply|off|3mf|glb|step|stp|toml|xlsx)\b|[-+±]?\d[\d.,]*(?:[eE][-+]?\d+)?"
)
"""Files and numbers of a message, which differ from row to row."""


def results_csv(values: Values) -> bytes:
    """Return one line a row, in the order of the list, without times: the same in every run."""
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
        lines += [
            ("", ""),
            ("Reason", "Rows"),
            *((text, count) for text, count, _ in grouped_reasons(values)),
        ]
        lines += [("", ""), ("Capability", ""), *capability(values).items()]
        for number, (name, value) in enumerate(lines):
            summary.write_row(number, 0, [name, "" if value is None else value])
        summary.set_column(0, 0, 60)
    return buffer.getvalue()


def grouped_reasons(values: Values) -> list[tuple[str, int, str]]:
    """Return (reason, rows, example) of reasons that differ only in numbers, names and files.

    Examples
    --------
    >>> rows = [{"exit_code": 3, "message": f"{name}.stl does not exist"} for name in ("a", "b")]
    >>> grouped_reasons({"results": rows})
    [('… does not exist', 2, 'a.stl does not exist')]
    """
    first: dict[str, str] = {}
    counts: Counter[str] = Counter()
    for row in values["results"]:
        if row["exit_code"] != 0:
            why = row["message"] or row["outcome"]
            reason = OWN_WORDS.sub("…", why)
            first.setdefault(reason, why)
            counts[reason] += 1
    return sorted(((text, count, first[text]) for text, count in counts.items()), key=lambda x: (-x[1], x[0]))


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


def batch_text(values: Values) -> str:
    lines = [
        f"{values['rows']} rows: {values['within']} within tolerance, {values['above']} above, "
        f"{values['failed']} failed, {values['lost']} lost; {values['taken_over']} taken over",
    ]
    for text, count, example in grouped_reasons(values)[:NEWEST_ROWS]:
        lines.append(f"{count:6d}  {example if count == 1 else text}")
    return "\n".join(lines)
