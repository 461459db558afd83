"""Tables over several pages with a repeated heading, each row one run of text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from reportlab.platypus import Flowable

from autobalance.paper.lettering import POINTS_PER_MM, SMALLEST_PT, fitted, lines_of, width_mm
from autobalance.paper.pen import INK, RULE, Pen

HEAD_SIZE = SIZE = SMALLEST_PT
LINE_MM = 3.6
PAD_MM = 1.1
"""Room between columns: at least one space, so that programs that read the page separate the numbers."""


@dataclass(frozen=True)
class Column:
    """Heading (in lines), width [mm] and alignment of a column."""

    title: str
    width_mm: float
    align: str = "right"

    @property
    def room_mm(self) -> float:
        """Width for its text."""
        return self.width_mm - PAD_MM


def fill(columns: Sequence[Column], wide_mm: float) -> list[Column]:
    """Return columns widened in proportion to fill a width."""
    scale = wide_mm / sum(column.width_mm for column in columns)
    return [Column(column.title, column.width_mm * scale, column.align) for column in columns]


class Grid(Flowable):  # type: ignore[misc]
    """A table whose rows continue on the next page under the same heading where one is full.

    Spaces separate the cells of a row, so that a program that reads the text finds it on one line.
    """

    def __init__(
        self,
        columns: Sequence[Column],
        rows: Sequence[Sequence[str]],
        row_mm: float = 4.6,
        size: float = SIZE,
    ) -> None:
        super().__init__()
        self.columns, self.rows, self.row_mm, self.size = (
            list(columns),
            [list(row) for row in rows],
            row_mm,
            size,
        )
        self.width = sum(column.width_mm for column in columns) * POINTS_PER_MM
        self.head_mm = 1.6 + LINE_MM * max(len(column.title.split("\n")) for column in columns)
        self._cells = [
            [self._lines(c, cell) for c, cell in zip(columns, row, strict=True)] for row in self.rows
        ]
        self._high = [
            self.row_mm + LINE_MM * (max(len(lines) for lines, _ in cells) - 1) for cells in self._cells
        ]

    def _lines(self, column: Column, cell: str) -> tuple[list[str], float]:
        size = fitted(cell, self.size, column.room_mm, least=self.size)
        if width_mm(cell, size) <= column.room_mm + 1e-6:
            return [cell], size
        return lines_of(cell, self.size, column.room_mm), self.size

    @property
    def height_mm(self) -> float:
        return self.head_mm + sum(self._high)

    def wrap(self, _wide: float, _high: float) -> tuple[float, float]:
        """Return width and height [points]."""
        return self.width, self.height_mm * POINTS_PER_MM

    def split(self, _wide: float, high: float) -> list[Flowable]:
        """Return the part that fits and the rest; empty where not even two rows fit."""
        room, count = high / POINTS_PER_MM - self.head_mm, 0
        while count < len(self.rows) and self._high[count] <= room:
            room -= self._high[count]
            count += 1
        if count < min(2, len(self.rows)):
            return []
        parts = [self.rows[:count], self.rows[count:]]
        return [Grid(self.columns, rows, self.row_mm, self.size) for rows in parts if rows]

    def draw(self) -> None:
        pen = Pen(self.canv, self.height_mm)
        wide = sum(column.width_mm for column in self.columns)
        titles = [column.title.split("\n") for column in self.columns]
        most = max(len(lines) for lines in titles)
        for k in range(most):
            cells = [lines[k - most + len(lines)] if k >= most - len(lines) else "" for lines in titles]
            self._row(pen, 2.9 + LINE_MM * k, cells, [HEAD_SIZE] * len(cells), INK)
        pen.line(0.0, self.head_mm - 0.4, wide, self.head_mm - 0.4, INK, 0.2)
        down = self.head_mm
        for lined, high in zip(self._cells, self._high, strict=True):
            for k in range(max(len(lines) for lines, _ in lined)):
                row = [lines[k] if k < len(lines) else "" for lines, _ in lined]
                self._row(pen, down + 0.7 * self.row_mm + LINE_MM * k, row, [size for _, size in lined], INK)
            down += high
            pen.line(0.0, down - 0.1, wide, down - 0.1, RULE, 0.12)

    def _row(self, pen: Pen, base: float, cells: Sequence[str], sizes: Sequence[float], colour: str) -> None:
        """Write one line of a row, each cell followed by as many spaces as fit before the next."""
        starts, left = [], 0.0
        for column, cell, size in zip(self.columns, cells, sizes, strict=True):
            free = column.room_mm - width_mm(cell, size)
            starts.append(left + (free if column.align == "right" else 0.0))
            left += column.width_mm
        filled, pieces = [k for k, cell in enumerate(cells) if cell], []
        if not filled:
            return
        for k, following in zip(filled, [*filled[1:], None], strict=True):
            text = cells[k]
            if following is not None:
                end = starts[k] + width_mm(text, sizes[k])
                text += " " * max(1, math.floor((starts[following] - end) / width_mm(" ", sizes[k]) + 1e-6))
            pieces.append((starts[k], text, sizes[k]))
        pen.run(base, pieces, colour)


def table(
    wide_mm: float, columns: Sequence[Column], rows: Sequence[Sequence[Any]], row_mm: float = 4.6
) -> Grid:
    """Return a table as wide as its room; cells become text in the sheet's letters."""
    from autobalance.paper.lettering import safe

    return Grid(fill(columns, wide_mm), [[safe(cell) for cell in row] for row in rows], row_mm)
