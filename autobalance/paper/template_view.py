"""Templates on the page, 1:1, as many beside each other as fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

from reportlab.platypus import Flowable

from autobalance.paper.cuts import Occupied, spread_between
from autobalance.paper.drawing import Drawings
from autobalance.paper.pen import (
    ACCENT,
    GONE,
    INK,
    POINTS_PER_MM,
    RULE,
    SMALLEST_PT,
    SOFT,
    Pen,
    badge_width_mm,
    fitted,
    width_mm,
)
from autobalance.paper.rim_strips import LAP_MM, FlatSide, Strip, templates, tile_range, tiles_of
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.wording import degrees

ABOVE_MM, BELOW_MM = 11.5, 8.0
APART_MM, ROW_MM = 5.0, 4.8
BORDER_MM = 6.0
BESIDE_MM = 4.0
TITLE = SIZE = SMALLEST_PT


class Template(Protocol):
    """One template of a row."""

    wide_mm: float
    high_mm: float

    def draw(self, pen: Pen, left: float, down: float) -> None:
        """Draw the template with its upper left corner at (left, down)."""


class TemplateRow(Flowable):  # type: ignore[misc]
    """Templates beside each other."""

    def __init__(self, tiles: Sequence[Template]) -> None:
        super().__init__()
        self.tiles = tiles
        self.high_mm = max(tile.high_mm for tile in tiles)

    def wrap(self, wide: float, _high: float) -> tuple[float, float]:
        """Return width and height [points]."""
        return wide, (self.high_mm + 3.0) * POINTS_PER_MM

    def draw(self) -> None:
        pen, left = Pen(self.canv, self.high_mm + 3.0), 0.0
        for tile in self.tiles:
            tile.draw(pen, left, 0.0)
            left += tile.wide_mm + BESIDE_MM


def template_rows(
    report: BalancedReport, drawings: Drawings | None, u: DisplayUnits, wide_mm: float, zero: Zero
) -> list[TemplateRow]:
    """Return all templates in rows, in order."""
    round_, flat = templates(report, drawings)
    tiles: list[Template] = []
    for number, strip in enumerate(round_, 1):
        tiles += [StripTile(strip, number, k, u, wide_mm, zero) for k in range(tiles_of(strip, wide_mm))]
    tiles += [FlatTile(side, len(round_) + k, u, wide_mm, zero) for k, side in enumerate(flat, 1)]
    rows: list[list[Template]] = []
    for tile in tiles:
        wide = sum(each.wide_mm + BESIDE_MM for each in rows[-1]) if rows else math.inf
        if wide + tile.wide_mm > wide_mm + 1e-6:
            rows.append([])
        rows[-1].append(tile)
    return [TemplateRow(row) for row in rows]


class _Tile:
    """Common parts of round and flat templates: edges of the web, holes, numbers."""

    def __init__(
        self, title: str, z_mm: tuple[float, float], long_mm: float, wide_mm: float, numbers: Sequence[int]
    ) -> None:
        self.title, self.z_mm, self.long_mm = title, z_mm, long_mm
        self.wide_mm = min(wide_mm, max(long_mm + 2.0 * BORDER_MM, width_mm(title, TITLE) + 1.0))
        self.apart = max([APART_MM, *(badge_width_mm(str(number)) + 0.6 for number in numbers)])
        self.rows = max(1, math.ceil(len(numbers) * self.apart / (self.wide_mm - 5.0)))
        self.above_mm = ABOVE_MM + ROW_MM * (self.rows - 1)
        self.high_mm = self.above_mm + (z_mm[1] - z_mm[0]) + BELOW_MM
        self.named = Occupied()

    def begin(self, pen: Pen, left: float, down: float) -> None:
        """Write the title and draw the edges of the web."""
        self.left, self.down = left, down
        self.x0, self.x1 = left + BORDER_MM, left + BORDER_MM + self.long_mm
        self.top, self.bottom = self.y(self.z_mm[1]), self.y(self.z_mm[0])
        pen.text(left, down + 3.0, self.title, fitted(self.title, TITLE, self.wide_mm))
        for y in (self.top, self.bottom):
            pen.line(self.x0, y, self.x1, y, INK, 0.25)

    def y(self, z_mm: float) -> float:
        """Return the page's coordinate of a z."""
        return self.down + self.above_mm + self.z_mm[1] - z_mm

    def mark(self, pen: Pen, x: float, name: str) -> None:
        """Draw a line to lay on an edge or mark of the web, with its name."""
        pen.line(x, self.top - 1.5, x, self.bottom + 4.6, ACCENT, 0.35, (4.0, 1.0))
        size = SMALLEST_PT
        wide = width_mm(name, size)
        place = min(max(x - 0.5 * wide, self.left), self.left + self.wide_mm - wide)
        if self.named.take((place - 0.5, self.bottom + 4.4, place + wide + 0.5, self.bottom + 7.0)):
            pen.text(place, self.bottom + 6.6, name, size, ACCENT)

    def holes(self, pen: Pen, here: Sequence[tuple[float, Cut]]) -> None:
        """Draw holes with their crosses, and their numbers above."""
        for x, item in here:
            y, r = self.y(float(item.position_mm[2])), 0.5 * item.only_hole.diameter_mm
            pen.circle(x, y, r, GONE, 0.3)
            pen.line(x - r - 1.5, y, x + r + 1.5, y, INK, 0.12)
            pen.line(x, y - r - 1.5, x, y + r + 1.5, INK, 0.12)
        low, high = self.left + 2.5, max(self.left + self.wide_mm - 2.5, self.left + 2.5)
        ordered = sorted(here, key=lambda pair: pair[0])
        places: list[tuple[float, float, Cut]] = []
        for row in range(self.rows):
            members = ordered[row :: self.rows]
            spread = spread_between([x for x, _ in members], self.apart, low, high)
            down = self.down + 7.0 + ROW_MM * row
            places += [(place, down, item) for place, (_, item) in zip(spread, members, strict=True)]
            for place, (x, item) in zip(spread, members, strict=True):
                pen.line(place, down, x, self.y(float(item.position_mm[2])), SOFT, 0.1)
        for place, down, item in places:
            pen.badge(place, down, item.number)
        angles = [self.angle(item) for _, _, item in places]
        wide = max([0.0, *(width_mm(text, SIZE) for text in angles)])
        if self.rows == 1 and _apart([place for place, _, _ in places], self.apart + 1.5 + wide):
            for (place, down, _), text in zip(places, angles, strict=True):
                pen.text(place + 0.5 * self.apart + 0.2, down + 0.9, text, SIZE)

    def angle(self, item: Cut) -> str:
        """Return the text beside the number of a hole."""
        raise NotImplementedError


def _apart(places: Sequence[float], least: float) -> bool:
    ordered = sorted(places)
    return all(two - one >= least for one, two in pairwise(ordered))


class StripTile(_Tile):
    """One length of a strip round the rim, angles along it, z across, a cross at each hole."""

    def __init__(
        self, strip: Strip, number: int, tile: int, u: DisplayUnits, wide_mm: float, zero: Zero
    ) -> None:
        self.strip, self.tile, self.zero = strip, tile, zero
        self.tiles = tiles_of(strip, wide_mm)
        self.start_mm, end_mm = tile_range(strip, tile, wide_mm)
        part = f", part {tile + 1} of {self.tiles}: marks on marks" if self.tiles > 1 else ""
        title = (
            f"Template {number}: web {strip.items[0].web}, round radius {u.mm(strip.radius_mm)} "
            f"{u.length}, +z edge up{part}"
        )
        self.end_mm = end_mm
        here = [int(item.number) for item in strip.items if self.start_mm <= self._along(item) <= end_mm]
        super().__init__(title, strip.z_mm, end_mm - self.start_mm, wide_mm, here)

    def _along(self, item: Cut) -> float:
        """Return the distance of a hole along the strip [mm]."""
        turned = self._turned(float(item.angle_deg))
        return math.radians(self.strip.last_deg - turned) * self.strip.radius_mm

    def _x(self, angle_deg: float) -> float:
        """Return the page's coordinate of an angle: outside of the rim up, angles grow to the left."""
        return self.x0 + math.radians(self.strip.last_deg - angle_deg) * self.strip.radius_mm - self.start_mm

    def _is_here(self, x: float) -> bool:
        return self.x0 - 0.01 <= x <= self.x1 + 0.01

    def draw(self, pen: Pen, left: float, down: float) -> None:
        self.begin(pen, left, down)
        for x, first in ((self.x0, self.tile == 0), (self.x1, self.tile == self.tiles - 1)):
            if first:
                pen.line(x, self.top, x, self.bottom, INK, 0.25)
        self._laps(pen)
        self._angles(pen)
        for name, angle in self.strip.marks:
            if self._is_here(self._x(angle)):
                self.mark(pen, self._x(angle), name)
        here = [item for item in self.strip.items if self.start_mm <= self._along(item) <= self.end_mm]
        self.holes(pen, [(self._x(self._turned(float(item.angle_deg))), item) for item in here])

    def angle(self, item: Cut) -> str:
        """Return the angle of a hole from the sheet's zero."""
        return degrees(float(item.angle_deg) - self.zero.angle_deg)

    def _laps(self, pen: Pen) -> None:
        """Draw the marks that overlap the marks of the neighbouring lengths."""
        for x, inner in ((self.x0, self.tile > 0), (self.x1, self.tile < self.tiles - 1)):
            for place in (x, x + (LAP_MM if x == self.x0 else -LAP_MM)) if inner else ():
                for y in (self.top, self.bottom):
                    pen.line(place - 2.0, y, place + 2.0, y, ACCENT, 0.3)
                    pen.line(place, y - 2.0, place, y + 2.0, ACCENT, 0.3)

    def _angles(self, pen: Pen) -> None:
        strip, zero = self.strip, self.zero.angle_deg
        step = next(
            s for s in (1, 2, 5, 10, 15, 30, 90) if math.radians(s) * strip.radius_mm >= 9.0 or s == 90
        )
        low, high = strip.first_deg - zero, strip.last_deg - zero
        for mark in range(math.ceil(low / step), math.floor(high / step) + 1):
            x = self._x(mark * step + zero)
            if self._is_here(x):
                pen.line(x, self.top - 1.0, x, self.bottom + 1.0, RULE, 0.12)
                if all(abs(x - self._x(angle)) > 4.0 for _, angle in strip.marks):
                    pen.text(x, self.bottom + 3.6, f"{mark * step % 360}°", SIZE, INK, align="centre")

    def _turned(self, angle_deg: float) -> float:
        """Return an angle in the strip's count, maybe beyond 360."""
        return self.strip.first_deg + (angle_deg - self.strip.first_deg) % 360.0


class FlatTile(_Tile):
    """A template for a flat side of a web, to lay on its corners."""

    def __init__(self, side: FlatSide, number: int, u: DisplayUnits, wide_mm: float, zero: Zero) -> None:
        self.side, self.u, self.zero = side, u, zero
        web = side.items[0].web
        first = self._angle(side.items[0])
        title = f"Template {number}: web {web}, flat side at {first}, lay on its corners, +z edge up"
        long = min(side.long_mm, wide_mm - 2.0 * BORDER_MM)
        # a side longer than the page shows the part with its holes, from the corner if that part reaches it
        self.from_mm = max(0.0, max(side.along_mm) + BORDER_MM - long)
        super().__init__(title, side.z_mm, long, wide_mm, [int(item.number) for item in side.items])

    def _angle(self, item: Cut) -> str:
        return degrees(float(item.angle_deg) - self.zero.angle_deg)

    def draw(self, pen: Pen, left: float, down: float) -> None:
        self.begin(pen, left, down)
        # seen from outside with +z up the outline, which runs counter-clockwise, goes to the left
        for along in (0.0, self.side.long_mm):
            x = self._x(along)
            if self.x0 - 0.01 <= x <= self.x1 + 0.01:
                pen.line(x, self.top, x, self.bottom, INK, 0.25)
                self.mark(pen, x, "corner")
        places = [(self._x(a), item) for a, item in zip(self.side.along_mm, self.side.items, strict=True)]
        self.holes(pen, places)

    def _x(self, along_mm: float) -> float:
        return self.x1 - (along_mm - self.from_mm)

    def angle(self, item: Cut) -> str:
        """Return the distance of a hole from the right corner."""
        along = next(a for a, each in zip(self.side.along_mm, self.side.items, strict=True) if each is item)
        return self.u.mm(along)
