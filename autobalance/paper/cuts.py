"""Cuts on paper: values, tables, labels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from reportlab.platypus import Flowable

from autobalance.paper.drawing import MIN_AXIAL_COMPONENT
from autobalance.paper.pen import INK, POINTS_PER_MM, RULE, SMALLEST_PT, Pen, fitted, lines_of, width_mm
from autobalance.paper.tolerances import press_fit, retention
from autobalance.report.balance import kinds
from autobalance.report.balance.zero import FROM_CRANKPIN, Zero
from autobalance.report.display_units import DisplayUnits, plain
from autobalance.report.records.balanced import Cut
from autobalance.types import Array
from autobalance.value_classes import dataclass
from autobalance.wording import NO_VALUE, degrees

# Tables over several pages with a repeated heading, each row one run of text.


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
    from autobalance.paper.pen import safe

    return Grid(fill(columns, wide_mm), [[safe(cell) for cell in row] for row in rows], row_mm)


# Tables of the cuts, one line each, and of their slugs.


def cut_table(
    items: Sequence[Cut], u: DisplayUnits, wide_mm: float, zero: Zero, done: Mapping[int, str]
) -> Flowable:
    """Return a table of every cut, angles in both senses, depths with and without the point."""
    return table(wide_mm, *_columns_and_rows(items, u, zero, done))


def _columns_and_rows(
    items: Sequence[Cut], u: DisplayUnits, zero: Zero, done: Mapping[int, str]
) -> tuple[list[Column], list[list[str]]]:
    """Return the columns of cuts or pads and a row for each; with the time of those done, if any is."""
    columns = [Column("No", 7.5), *cut_columns(u, zero)]
    rows = [cut_row(item, u, zero) for item in items]
    if done:
        columns.append(Column("done", 19.0))
        for row, item in zip(rows, items, strict=True):
            row.append(done.get(int(item.number), ""))
    return columns, rows


def pad_table(
    items: Sequence[Cut], u: DisplayUnits, wide_mm: float, zero: Zero, done: Mapping[int, str]
) -> Flowable:
    """Return a table of every pad: as for cuts, with a height, without tool and point."""
    columns, rows = _columns_and_rows(items, u, zero, done)
    of_tools = [f"diameter\n{u.length}", f"with point\n{u.length}"]
    shown = [k for k, column in enumerate(columns) if column.title not in of_tools]
    titles = {"cut": "pad", f"depth\n{u.length}": f"height\n{u.length}"}
    heads = [replace(columns[k], title=titles.get(columns[k].title, columns[k].title)) for k in shown]
    return table(wide_mm, heads, [[row[k] for k in shown] for row in rows])


def cut_columns(u: DisplayUnits, zero: Zero) -> list[Column]:
    """Return the columns of a cut, without its number."""
    from_crankpin = zero.angle_deg != 0.0
    return [
        Column("cut", 17.5, "left"),
        Column("how", 24.0, "left"),
        Column("where", 10.0, "left"),
        Column(f"{zero.name}\nccw" if from_crankpin else "angle\nccw", 13.0),
        Column("\ncw" if from_crankpin else "angle\ncw", 12.0),
        *([Column("(crankpin 1\nccw", 12.0), Column("\ncw)", 11.5)] if from_crankpin else []),
        Column(f"radius\n{u.length}", 11.5),
        Column(f"z\n{u.length}", 12.5),
        Column(f"diameter\n{u.length}", 13.0),
        Column(f"depth\n{u.length}", 11.5),
        Column("with point\n" + u.length, 14.5),
        Column(f"mass\n{u.mass}", 11.0 if u.is_metric else 12.5),
        *([] if u.is_metric else [Column("\ng", 11.5)]),
    ]


def cut_row(item: Cut, u: DisplayUnits, zero: Zero = FROM_CRANKPIN) -> list[str]:
    """Return the cells of a cut: number, kind, place, angles, radius, z, sizes, mass.

    Where angles count from a keyway, those from crankpin 1, as in the report, follow in brackets.
    """
    ccw = kinds.angle_deg(item)
    point = None if item.hole is None else item.hole.point_mm
    depth, mass = float(item.depth_mm), item.removed_mass_g
    if item.of_kind.adds_metal:
        depth, mass = abs(depth), abs(mass)
    own = from_crankpin = [NO_VALUE, NO_VALUE]
    if ccw is not None:
        own = [degrees(ccw - zero.angle_deg), degrees(zero.angle_deg - ccw)]
        from_crankpin = [f"({degrees(ccw)}", f"{degrees(-ccw)})"]
    return [
        str(item.number),
        item.of_kind.noun,
        how(item),
        webs_of(item),
        *own,
        *(from_crankpin if zero.angle_deg != 0.0 else []),
        u.mm(item.shown_radius_mm, u.length_digits - 1),
        u.mm(item.position_mm[2], u.length_digits - 1),
        u.mm(item.diameter_mm, u.diameter_digits),
        u.mm(depth),
        u.mm(depth + float(point)) if point else NO_VALUE,
        u.g(mass),
        *([] if u.is_metric else [plain(mass, 2)]),
    ]


def how(item: Cut) -> str:
    """Return the kind's name and the side of the tool: ``drill from +z``."""
    if item.of_kind.adds_metal:
        return item.of_kind.verb
    word, side = str(item.kind), side_of(item)
    return f"{word} {side}" if side else word


def side_of(item: Cut) -> str:
    """Return the side from which the tool enters; empty where a face or a rim is cut all over."""
    if item.hole is not None:
        inward = item.hole.inward
        if abs(inward[2]) < MIN_AXIAL_COMPONENT:
            return "from the rim"
        return "from -z" if inward[2] > 0.0 else "from +z"
    if item.pocket is not None and item.pocket.face_z_mm is not None:
        return "from -z" if item.position_mm[2] > item.pocket.face_z_mm else "from +z"
    up = 0.0 if item.new_face is None else item.new_face.normal[2]
    if abs(up) > MIN_AXIAL_COMPONENT:
        return "from +z" if up > 0.0 else "from -z"
    return ""


def webs_of(item: Cut) -> str:
    """Return the webs: ``web 2``, ``web 1, 2``, of many in a row ``web 1-8``."""
    webs = list(item.all_webs)
    if len(webs) > 3 and webs == list(range(webs[0], webs[-1] + 1)):
        return f"web {webs[0]}-{webs[-1]}"
    return f"web {', '.join(map(str, webs))}" if webs else NO_VALUE


def slug_table(items: Sequence[Cut], u: DisplayUnits, wide_mm: float) -> Flowable:
    """Return a table of the slugs: sizes, mass, density, fit and retention."""
    columns = [
        Column("slug", 13.0, "left"),
        Column(f"bore\n{u.length}", 22.0),
        Column(f"slug's diameter\n{u.length}", 26.0),
        Column(f"length\n{u.length}", 14.0),
        Column(f"mass\n{u.mass}", 13.0),
        Column("kg/m³", 12.0),
        Column("fit", 12.0, "left"),
        Column("retention", 75.0, "left"),
    ]
    rows = []
    for item in items:
        if item.hole is None or item.slug is None:
            continue
        fit = press_fit(item.hole.diameter_mm)
        rows.append(
            [
                f"cut {item.number}",
                " to ".join(u.mm(value) for value in fit.bore_mm),
                " to ".join(u.mm(value) for value in fit.slug_mm),
                u.mm(item.slug.length_mm),
                u.g(item.slug.slug_mass_g),
                f"{item.slug.density_kg_m3:.0f}",
                fit.name,
                retention(item),
            ]
        )
    return table(wide_mm, columns, rows)


# Places of numbers without overlap: spread along a circle or a line, or left out.


Box = tuple[float, float, float, float]
"""Left, top, right, bottom [mm]."""


def spread(wanted: Sequence[float], apart: float) -> list[float]:
    """Return places on a line, nearest to those wanted (least squares), ``apart`` or more from each other.

    With the k-th place shifted by k times the distance, keeping their order becomes isotonic regression.

    Examples
    --------
    >>> spread([0.0, 0.0, 10.0], 2.0)
    [-1.0, 1.0, 10.0]
    """
    order = sorted(range(len(wanted)), key=lambda k: wanted[k])
    blocks: list[list[float]] = []  # mean, count
    for place, k in enumerate(order):
        blocks.append([wanted[k] - place * apart, 1.0])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            mean, count = blocks.pop()
            first = blocks[-1]
            first[0] = (first[0] * first[1] + mean * count) / (first[1] + count)
            first[1] += count
    levels = np.repeat([block[0] for block in blocks], [int(block[1]) for block in blocks])
    places = [0.0] * len(wanted)
    for place, k in enumerate(order):
        places[k] = float(levels[place]) + place * apart
    return places


def spread_between(wanted: Sequence[float], apart: float, low: float, high: float) -> list[float]:
    """Return places as ``spread`` does, all between two ends if there is room for them."""
    places = spread([min(max(each, low), high) for each in wanted], apart)
    order = sorted(range(len(places)), key=lambda k: places[k])
    for place, k in enumerate(order):
        places[k] = max(places[k], low + place * apart)
    for place, k in enumerate(reversed(order)):
        places[k] = min(places[k], high - place * apart)
    return places


def spread_on_circle(wanted_rad: Sequence[float], apart_rad: float) -> list[float]:
    """Return angles on a circle, ``apart`` or more all around if there is room for them.

    The circle is cut open in the widest gap; places beyond the gap are pushed back.
    """
    if not wanted_rad:
        return []
    turns = np.mod(np.asarray(wanted_rad), 2.0 * math.pi)
    ordered = np.sort(turns)
    gaps = np.diff(np.append(ordered, ordered[0] + 2.0 * math.pi))
    start = float(ordered[(int(np.argmax(gaps)) + 1) % len(ordered)])
    widest = float(gaps.max())
    along = np.mod(turns - start, 2.0 * math.pi)
    along[along > 2.0 * math.pi - 1e-9] = 0.0
    room = 0.5 * max(0.0, widest - apart_rad)
    last = 2.0 * math.pi - widest
    places = spread_between(along.tolist(), apart_rad, -room, last + room)
    return [start + each for each in places]


def rings_for(count: int, radius_mm: float, apart_mm: float) -> int:
    """Return the number of rings on which that many labels have room."""
    return max(1, math.ceil(count * apart_mm / (0.97 * 2.0 * math.pi * radius_mm)))


class Occupied:
    """Boxes of text on a drawing."""

    def __init__(self) -> None:
        self._boxes: list[Box] = []

    def take(self, box: Box) -> bool:
        """Occupy a box unless it overlaps another; return whether it was free."""
        free = not any(_overlap(box, other) for other in self._boxes)
        if free:
            self._boxes.append(box)
        return free

    def add(self, box: Box) -> None:
        """Occupy a box, even over others."""
        self._boxes.append(box)


def _overlap(one: Box, two: Box) -> bool:
    return one[0] < two[2] and two[0] < one[2] and one[1] < two[3] and two[1] < one[3]


def directions(angles_rad: Sequence[float]) -> Array:
    """Return unit vectors (n, 2) on the page, right and down, of rotor angles with crankpin 1 up."""
    turn = np.asarray(angles_rad, dtype=np.float64)
    return np.stack([-np.sin(turn), -np.cos(turn)], axis=1)
