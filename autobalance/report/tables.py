"""Tables as plain text, or as the command line draws them on a terminal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextvars import ContextVar

Rows = Sequence[Sequence[str]]

DRAWN_BY: ContextVar[Callable[[Rows], str] | None] = ContextVar("DRAWN_BY", default=None)
"""Draws tables instead of ``plain_table``; the command line sets it on a terminal, nobody else."""


def table(rows: Rows) -> str:
    """Return rows in columns: the first to the left, the others to the right of their column."""
    drawn = DRAWN_BY.get()
    return plain_table(rows) if drawn is None else drawn(rows)


def plain_table(rows: Rows) -> str:
    """Return rows in columns of plain text, two spaces apart."""
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [row[0].ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def has_heading(rows: Rows) -> bool:
    """Return whether the first row is a heading, with all others indented below it."""
    return len(rows) > 1 and not rows[0][0].startswith(" ") and all(row[0][:1] == " " for row in rows[1:])
