"""Tables as plain text, or as the command line fits them to a terminal's width."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextvars import ContextVar

from autobalance.report.wrapping import glued, longest_word, unglued, wrapped

Rows = Sequence[Sequence[str]]

DRAWN_BY: ContextVar[Callable[[Rows], str] | None] = ContextVar("DRAWN_BY", default=None)
"""Draws tables instead of ``plain_table``; the command line sets it, nobody else."""
LONGEST_NAME = 28
"""Length from which the first cell of a row is broken between words."""
GAP = 2
"""Spaces between two columns."""


def table(rows: Rows) -> str:
    """Return rows in columns: the first to the left, the others to the right of their column."""
    drawn = DRAWN_BY.get()
    return plain_table(rows) if drawn is None else drawn(rows)


def plain_table(rows: Rows) -> str:
    """Return rows in columns of plain text, two spaces apart."""
    widths = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    return "\n".join(_line(row, widths) for row in rows)


def fitted_table(rows: Rows, width: int) -> str:
    """Return rows in columns no wider than a number of characters, all cells broken between words only.

    Columns without room next to the first follow below as a separate table, with the first column again.
    """
    rows = [[glued(cell) for cell in row] for row in rows]
    natural = [max(len(row[place]) for row in rows) for place in range(len(rows[0]))]
    least = [_least(place, [row[place] for row in rows]) for place in range(len(rows[0]))]
    parts = []
    for places in _side_by_side(least, width):
        widths = _shared([natural[each] for each in places], [least[each] for each in places], width)
        parts.append("\n".join(_wrapped_row([row[each] for each in places], widths) for row in rows))
    return unglued("\n".join(parts))


def has_heading(rows: Rows) -> bool:
    """Return whether the first row is a heading, with all others indented below it."""
    return len(rows) > 1 and not rows[0][0].startswith(" ") and all(row[0][:1] == " " for row in rows[1:])


def _least(place: int, cells: Sequence[str]) -> int:
    """Return the width below which a column's names or numbers would be broken."""
    heading, *body = cells
    kept = (len(each) if _stays_whole(place, each) else longest_word(each) for each in body)
    return max(longest_word(heading), *kept) if body else longest_word(heading)


def _stays_whole(place: int, cell: str) -> bool:
    return len(cell) <= LONGEST_NAME if place == 0 else not cell.strip()[:1].isalpha()


def _side_by_side(least: Sequence[int], width: int) -> list[list[int]]:
    """Return the columns of each table, the first column in all of them."""
    tables = [[0]]
    for place in range(1, len(least)):
        together = sum(least[each] + GAP for each in tables[-1]) + least[place]
        if together > width and len(tables[-1]) > 1:
            tables.append([0])
        tables[-1].append(place)
    return tables


def _shared(natural: Sequence[int], least: Sequence[int], width: int) -> list[int]:
    """Return the widths of columns: as they are, the widest ones narrower until all fit."""
    widths = list(natural)
    while sum(widths) + GAP * (len(widths) - 1) > width:
        room = [place for place in range(len(widths)) if widths[place] > least[place]]
        if not room:
            break
        widths[max(room, key=lambda place: widths[place])] -= 1
    return widths


def _wrapped_row(row: Sequence[str], widths: Sequence[int]) -> str:
    cells = [wrapped(cell, width) for cell, width in zip(row, widths, strict=True)]
    lines = max(len(cell) for cell in cells)
    filled = [cell + [""] * (lines - len(cell)) for cell in cells]
    return "\n".join(_line([cell[line] for cell in filled], widths) for line in range(lines))


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    placed = [cells[0].ljust(widths[0])]
    placed += [cell.rjust(width) for cell, width in zip(cells[1:], widths[1:], strict=True)]
    return (" " * GAP).join(placed).rstrip()
