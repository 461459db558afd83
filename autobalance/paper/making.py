"""Instructions for the cuts of a plate, beside the drawing where they fit, else as a table below."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate, pairwise
from typing import Any

from reportlab.platypus import Flowable

from autobalance.paper.cuts import Column, table
from autobalance.paper.pen import INK, RULE, SMALLEST_PT, Pen, fitted, lines_of, safe
from autobalance.paper.rim_strips import WebSide
from autobalance.report.balance import kinds
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.balanced import Cut
from autobalance.value_classes import dataclass
from autobalance.wording import NO_VALUE, degrees

SAME_STEP_DEG = 0.05
FEWEST_ALIKE = 3
"""Fewest equal holes on a circle that share one instruction."""
SIZE, LINE_MM, GAP_MM = SMALLEST_PT, 3.5, 1.2
CUT_MM = 15.0
SHARES = (0.23, 0.29, 0.24, 0.24)
"""Widths of the columns beside a view: angles, z and radius, x and y, walls."""


@dataclass(frozen=True)
class Making:
    """A cut, or several equal ones: instruction, angles from the zero, coordinates, wall, depth left.

    ``first`` has the first angle, ccw and cw, for a column too narrow for both ends.
    """

    label: str
    what: str
    ccw: str
    cw: str
    first: tuple[str, str]
    radius: str
    x: str
    y: str
    z: str
    wall: str
    left: str


def makings(items: Sequence[Cut], zero: Zero, cheeks: Mapping[int, WebSide], u: DisplayUnits) -> list[Making]:
    """Return the instructions, one for holes that are equal and evenly spaced."""
    return [_making(run, zero, cheeks, u) for run in _runs(items, zero, u)]


def _runs(items: Sequence[Cut], zero: Zero, u: DisplayUnits) -> list[list[Cut]]:
    """Return cuts one by one, and holes that differ only in their angle, at even steps, together."""
    groups: dict[Any, list[Cut]] = {}
    for place, item in enumerate(items):
        groups.setdefault(_group_key(item, u) or place, []).append(item)
    runs: list[list[Cut]] = []
    for group in groups.values():
        runs += _even(sorted(group, key=lambda item: zero.ccw(float(item.angle_deg))))
    return sorted(runs, key=lambda run: next(place for place, item in enumerate(items) if item in run))


def _group_key(item: Cut, u: DisplayUnits) -> tuple[Any, ...] | None:
    if item.kind != "drill" or item.hole is None or item.is_deepened:
        return None
    hole = item.hole
    sizes = (u.mm(each) for each in (hole.diameter_mm, item.depth_mm, hole.entry_radius_mm))
    return (item.web, *sizes, u.mm(item.position_mm[2]), round(float(hole.inward[2]), 3))


def _even(group: Sequence[Cut]) -> list[list[Cut]]:
    """Return runs of three or more at even steps; the others one by one."""
    runs: list[list[Cut]] = []
    start = 0
    while start < len(group):
        end = start + 1
        while end < len(group) and (
            end == start + 1 or abs(_step(group, end) - _step(group, start + 1)) < SAME_STEP_DEG
        ):
            end += 1
        end = end if end - start >= FEWEST_ALIKE else start + 1
        runs.append(list(group[start:end]))
        start = end
    return runs


def _step(group: Sequence[Cut], place: int) -> float:
    return (group[place].angle_deg - group[place - 1].angle_deg) % 360.0


def _making(run: Sequence[Cut], zero: Zero, cheeks: Mapping[int, WebSide], u: DisplayUnits) -> Making:
    item = run[0]
    cheek = next((cheeks[web] for web in item.all_webs if web in cheeks), None)
    z = NO_VALUE if cheek is None else f"{u.mm(abs(item.position_mm[2] - cheek.z_mm))} {cheek.letter}"
    walls = [each.wall_left_mm for each in run if each.wall_left_mm is not None]
    left = [each.depth_left_mm for each in run if each.depth_left_mm is not None]
    angles = [kinds.angle_deg(each) for each in run]
    known = [zero.ccw(angle) for angle in angles if angle is not None]
    what = _instruction(zero.counted(item), u)
    label, ccw, cw = f"{item.of_kind.piece} {item.number}", NO_VALUE, NO_VALUE
    if known:
        ccw, cw = degrees(known[0]), degrees(-known[0])
    alone, first = len(run) == 1, (ccw, cw)
    if not alone:
        numbers = [int(each.number) for each in run]
        hole = item.only_hole  # nothing else is listed together
        diameter, depth = u.mm(hole.diameter_mm, u.diameter_digits), u.mm(item.depth_mm)
        name = f" ({hole.drill})" if hole.drill else ""
        what = f"Drill {len(run)} × ⌀{diameter}{name}, {depth} deep"
        what += f", at {degrees(known[0])} … {degrees(known[-1])} every {_step(run, 1):.1f}°"
        first = (f"{ccw} …", f"{cw} …")
        label = f"cuts {_numbers(numbers)}"
        cw = f"{degrees(-known[0])} … {degrees(-known[-1])}"
        ccw = f"{degrees(known[0])} … {degrees(known[-1])}"
    return Making(
        label, what, ccw, cw, first,
        u.mm(item.shown_radius_mm),
        u.mm(item.position_mm[0]) if alone else NO_VALUE,
        u.mm(item.position_mm[1]) if alone else NO_VALUE,
        z,
        u.mm(min(walls)) if walls else NO_VALUE,
        u.mm(min(left)) if left else NO_VALUE,
    )  # fmt: skip


def _numbers(numbers: Sequence[int]) -> str:
    numbers = sorted(numbers)
    in_row = all(two == one + 1 for one, two in pairwise(numbers))
    return f"{numbers[0]}-{numbers[-1]}" if in_row else ", ".join(map(str, numbers))


def _instruction(item: Cut, u: DisplayUnits) -> str:
    text = item.of_kind.instruction(item.item, u)
    if item.hole is not None and (old := item.hole.deepened_from_mm):
        text += f"; deepen the existing hole of {u.mm(old)}: {u.mm(old + item.depth_mm)} in all"
    if (rim := item.new_rim) is not None:
        text += f"; from radius {u.mm(rim.rim_radius_mm)} to {u.mm(rim.new_radius_mm)}"
    if (face := item.new_face) is not None and item.of_kind.adds_metal:
        text += f"; height {u.mm(face.face_height_mm)} to {u.mm(face.new_height_mm)}"
    return text


class SideTable:
    """The cuts of a plate in a narrow column beside its view."""

    def __init__(self, rows: Sequence[Making], u: DisplayUnits, wide_mm: float) -> None:
        self.rows, self.u, self.wide_mm = rows, u, wide_mm
        texts = [None, *(row.what for row in rows)]  # the instruction of the row above is not repeated
        self.texts = [
            [] if row.what == above else lines_of(safe(row.what), SIZE, wide_mm - CUT_MM)
            for above, row in zip(texts, rows, strict=False)
        ]
        lines = sum(2 + len(text) for text in self.texts)
        self.high_mm = 2.0 * LINE_MM + 2.4 + lines * LINE_MM + GAP_MM * len(rows)

    def _ends_mm(self, x: float) -> list[float]:
        """Return the right ends of the columns."""
        wide = self.wide_mm - CUT_MM
        return [x + CUT_MM + wide * share for share in accumulate(SHARES)]

    def draw(self, pen: Pen, x: float, down: float) -> None:
        """Draw heading and rows; the corner of the box is at (x, down)."""
        heads = ("ccw, cw", "z, radius", "x, y", "wall, left")
        ends = self._ends_mm(x)
        pen.text(x, down + 2.9, "cut", SIZE)
        pen.text(x, down + 2.9 + LINE_MM, f"({self.u.length})", SIZE)
        for k, head in enumerate(heads):
            end = ends[k]
            for line, text in enumerate(head.split(", ")):
                pen.text(end, down + 2.9 + LINE_MM * line, text, SIZE, align="right")
        down += 2.0 * LINE_MM + 1.4
        pen.line(x, down, x + self.wide_mm, down, INK, 0.2)
        down += 1.0
        for row, lines in zip(self.rows, self.texts, strict=True):
            pairs = (row.first, (row.z, row.radius), (row.x, row.y), (row.wall, row.left))
            base = down + 2.7
            size = fitted(row.label, SIZE, CUT_MM - 0.5)
            pen.text(x, base, row.label, size, bold=True)
            for line in range(2):
                cells = [pair[line] for pair in pairs]
                for k, cell in enumerate(cells):
                    pen.text(ends[k], base + LINE_MM * line, cell, SIZE, align="right")
            for line, text in enumerate(lines):
                pen.text(x + CUT_MM, base + LINE_MM * (2 + line), text, SIZE)
            down += LINE_MM * (2 + len(lines)) + GAP_MM
            pen.line(x, down - 0.5, x + self.wide_mm, down - 0.5, RULE, 0.12)


def making_table(rows: Sequence[Making], u: DisplayUnits, wide_mm: float, zero: Zero) -> Flowable:
    """Return the instructions of a plate as a table over the width of the page."""
    columns = [
        Column("cut", 13.0, "left"),
        Column("what to do", 48.0, "left"),
        Column(f"ccw from\n{zero.name}", 17.0),
        Column(f"cw from\n{zero.name}", 17.0),
        Column(f"radius\n{u.length}", 12.0),
        Column(f"x\n{u.length}", 12.5),
        Column(f"y\n{u.length}", 12.5),
        Column(f"z from\ncheek {u.length}", 17.0),
        Column(f"wall left\n{u.length}", 14.5),
        Column(f"depth left\n{u.length}", 16.0),
    ]
    cells = [
        [row.label, row.what, row.ccw, row.cw, row.radius, row.x, row.y, row.z, row.wall, row.left]
        for row in rows
    ]
    return table(wide_mm, columns, cells)
