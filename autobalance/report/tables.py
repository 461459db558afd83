"""Tables and lines as plain text, fitted to a width."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextvars import ContextVar

# Lines broken between words, never inside a word, a number with its unit or a path.


GLUE = "\ue000"
"""Placeholder of a space at which no line is broken: a private character, which no text contains."""
UNITS = (
    "mm|mm²|mm³|cm|m|in|in²|in³|g|kg|oz|lb|g·mm|g·m|g·in|oz·in|kg·mm|g·mm²|oz·in²|kg·mm²|lb·in²|kg/m³|N|kN|N·m"
    "|rpm|krpm|s|ms|min|Hz|%|MPa|GPa|mm/s|mm/s²|MB|GB|°C|K|W|J|g·mm/mm|oz·in/in|N/mm|N/µm|µm|kg·m²"
)
NUMBER_WITH_UNIT = re.compile(rf"(?<=\d) (?=(?:{UNITS})(?![\w·/]))")
SIGN_WITH_NUMBER = re.compile(r"(?<=[±⌀×]) (?=\d)|(?<=\d) (?=×)|(?<=\bG) (?=\d)")
SETTING = re.compile(r"--set '[^']*'")
FIRST_COLUMN = re.compile(r" *(?:- |\S+(?: \S+)* {2,})(?=\S)")
"""A dash, or a label with its text some spaces behind."""
WIDEST_LABEL = 32
ESCAPE = "\x1b"
"""Begins what colours a line, which fits already."""


def glued(text: str) -> str:
    """Return a text whose numbers hold on to their units, and settings to all of their words."""
    text = SETTING.sub(lambda found: whole(found[0]), text)
    return SIGN_WITH_NUMBER.sub(GLUE, NUMBER_WITH_UNIT.sub(GLUE, text))


def whole(text: object) -> str:
    """Return a path or a command whose words no line may part."""
    return str(text).replace(" ", GLUE)


def unglued(text: str) -> str:
    """Return a text with its spaces again."""
    return text.replace(GLUE, " ")


def longest_word(cell: str) -> int:
    """Return the length of the longest word of a table's cell, with its indent."""
    indent = len(cell) - len(cell.lstrip(" "))
    return max((indent + len(word) for word in cell.split(" ") if word), default=0)


def wrapped(line: str, width: int) -> list[str]:
    """Return a line in parts of a width at most, where its words allow that; later parts keep its indent.

    Examples
    --------
    >>> wrapped("  lower both shoulders", 14)
    ['  lower both', '  shoulders']
    """
    if len(line) <= width or ESCAPE in line:
        return [line]
    label = FIRST_COLUMN.match(line)
    indent = len(line) - len(line.lstrip(" "))
    hanging = len(label[0]) if label is not None and len(label[0]) <= WIDEST_LABEL else indent
    parts: list[str] = []
    start = 0
    while len(line) - start > width - (hanging if parts else 0):
        room = width - (hanging if parts else 0)
        first = start + (indent if not parts else 0)
        space = line.rfind(" ", first + 1, start + room + 1)
        if space < 0:
            space = line.find(" ", first + 1)
        if space < 0:
            break
        parts.append(" " * hanging * bool(parts) + line[start:space].rstrip(" "))
        start = space + 1
        while line[start : start + 1] == " ":
            start += 1
    return [*parts, " " * hanging * bool(parts) + line[start:]]


def fitted(text: str, width: int) -> str:
    """Return a text with every line wrapped; lines that fit stay as they are."""
    lines = (part for line in text.split("\n") for part in wrapped(glued(line), width))
    return unglued("\n".join(lines))


# Tables as plain text, or as the command line fits them to a terminal's width.


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
