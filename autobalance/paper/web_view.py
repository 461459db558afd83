"""Views of webs on a degree wheel, and of plates."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from reportlab.platypus import Flowable

from autobalance.paper.cuts import Occupied, rings_for, spread_on_circle
from autobalance.paper.drawing import MIN_AXIAL_COMPONENT, SectionDrawing
from autobalance.paper.making import Making, SideTable, makings
from autobalance.paper.pen import (
    ACCENT,
    BADGE_MM,
    CENTRE_LINE,
    GONE,
    INK,
    METAL,
    POINTS_PER_MM,
    RULE,
    SMALLEST_PT,
    SOFT,
    Pen,
    badge_width_mm,
    numeral_width_mm,
    shortened,
)
from autobalance.paper.plates import Plate, scale_for
from autobalance.paper.rim_strips import WebSide
from autobalance.paper.section_view import SectionView
from autobalance.report.balance import kinds
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.balanced import BalancedReport, Cut
from autobalance.types import Array

# A web seen along the axis within a degree wheel, its cuts numbered, to a scale of ISO 5455.


WHEEL_GAP_MM = 1.5
RING_MM = 5.0
"""Width of the ring of numerals around the wheel, and of each ring of numbers."""
TICKS_MM = 2.0
SIZE = SMALLEST_PT
APART_MM = 5.0
SHARED_UP_TO = 12
"""Most numbers that share the ring of the numerals; more of them have separate rings."""


class WebView:
    """The view of one plate, drawn with any pen from an upper left corner."""

    def __init__(
        self,
        report: BalancedReport,
        plate: Plate,
        zero: Zero,
        u: DisplayUnits,
        wide_mm: float,
        high_mm: float,
    ) -> None:
        self.report, self.plate, self.zero, self.u = report, plate, zero, u
        self.labels = plate.labels()
        web = plate.web
        points = np.concatenate([*web.outline, *[p for polygons in web.cuts.values() for p in polygons]])
        self.reach = float(np.hypot(*points.T).max())
        self.label_mm = max([2.0 * BADGE_MM, *(badge_width_mm(label) for label in self.labels)])
        apart = max(APART_MM, self.label_mm + 0.8)
        shared = len(self.labels) <= SHARED_UP_TO
        for rings in range(1, 12):
            around = WHEEL_GAP_MM + TICKS_MM + RING_MM * (rings if shared else rings + 1)
            side = around + 0.5 * (self.label_mm - 2.0 * BADGE_MM)
            self.scale, self.scale_name = scale_for(
                self.reach, self.reach, 0.5 * wide_mm - side, 0.5 * high_mm - around
            )
            self.wheel = self.scale * self.reach + WHEEL_GAP_MM
            self.first_ring = self.wheel + TICKS_MM + RING_MM * (not shared)
            if rings_for(len(self.labels), self.first_ring, apart) <= rings:
                break
        self.rings, self.apart = rings, apart
        self.half = self.wheel + around - WHEEL_GAP_MM
        self.high_mm = 2.0 * self.half
        self.wide_mm = max(self.high_mm + 2.0 * (side - around), 2.0 * (self.wheel + TICKS_MM + 10.5))

    def draw(self, pen: Pen, x: float, down: float) -> None:
        """Draw wheel, metal, cuts, numbers; the corner of the box is at (x, down)."""
        self.cx, self.cy = x + 0.5 * self.wide_mm, down + self.half
        places = self._places()
        occupied = Occupied()
        for (px, py), label in zip(places, self.labels, strict=True):
            half = 0.5 * badge_width_mm(label)
            occupied.add((px - half, py - BADGE_MM, px + half, py + BADGE_MM))
        self._wheel(pen, occupied)
        pen.shape(self.plate.web.outline, self.to_page, METAL, INK, 0.25)
        for item in self.plate.items:
            self._metal(pen, item)
        self._datum(pen)
        for (px, py), item in zip(places, self.plate.items, strict=True):
            ((ax, ay),) = self.to_page(self._anchor(item)[None])
            pen.line(px, py, ax, ay, SOFT, 0.12)
            pen.circle(ax, ay, 0.45, INK, 0.1, INK)
        for (px, py), label in zip(places, self.labels, strict=True):
            pen.badge(px, py, label)

    def to_page(self, places: Array) -> Array:
        """Return places (k, 2) of the rotor on the page: x up, y to the left, seen from -z to the right."""
        side = -1.0 if self.plate.from_below else 1.0
        return np.stack(
            [self.cx - side * self.scale * places[:, 1], self.cy - self.scale * places[:, 0]], axis=1
        )

    def _metal(self, pen: Pen, item: Cut) -> None:
        """Draw the metal that a cut removes or adds, and the circle and axis of a hole."""
        shadow = self.plate.web.cuts.get(item.number, [])
        pen.hatch(shadow, self.to_page, item.of_kind.adds_metal, filled=item.slug is not None)
        place = np.asarray(item.position_mm[:2], dtype=np.float64)
        if (hole := item.hole) is None:
            return
        inward = hole.inward
        if abs(inward[2]) > MIN_AXIAL_COMPONENT:
            ((x, down),) = self.to_page(place[None])
            r = self.scale * hole.diameter_mm / 2.0
            pen.circle(x, down, r, GONE, 0.3)
            for dx, dy in ((r + 1.2, 0.0), (0.0, r + 1.2)):
                pen.line(x - dx, down - dy, x + dx, down + dy, INK, 0.12)
            return
        depth = item.depth_mm + (hole.point_mm or 0.0)
        along = np.asarray(inward[:2], dtype=np.float64)
        (x0, y0), (x1, y1) = self.to_page(np.stack([place - 2.0 / self.scale * along, place + depth * along]))
        pen.line(x0, y0, x1, y1, ACCENT, 0.18, (3.0, 0.8, 0.8, 0.8))

    def _datum(self, pen: Pen) -> None:
        """Draw the centre lines of the axis, and the circle of crankpin 1."""
        cx, cy, long = self.cx, self.cy, self.wheel - 1.0
        pen.line(cx - long, cy, cx + long, cy, ACCENT, 0.13, CENTRE_LINE)
        pen.line(cx, cy - long, cx, cy + long, ACCENT, 0.13, CENTRE_LINE)
        for throw in self.report.crank.throws[:1]:
            r = self.scale * throw.crank_radius_mm
            pen.circle(
                cx, cy - r, self.scale * 0.5 * throw.crankpin.diameter_mm, ACCENT, 0.13, dash=(1.5, 0.8)
            )

    def _places(self) -> list[tuple[float, float]]:
        """Return the places of the numbers around the wheel."""
        wanted = [self._direction_rad(item) for item in self.plate.items]
        order = sorted(range(len(wanted)), key=lambda k: wanted[k])
        places = [(0.0, 0.0)] * len(wanted)
        for ring in range(self.rings):
            members = order[ring :: self.rings]
            radius = self.first_ring + RING_MM * (ring + 0.5)
            turns = spread_on_circle([wanted[k] for k in members], self.apart / radius)
            for k, turn in zip(members, turns, strict=True):
                places[k] = self._at(turn, radius)
        return places

    def _at(self, turn_rad: float, radius_mm: float) -> tuple[float, float]:
        """Return the place on the page at an angle from crankpin 1 and a distance from the axis."""
        side = -1.0 if self.plate.from_below else 1.0
        x = self.cx - side * radius_mm * math.sin(turn_rad)
        return x, self.cy - radius_mm * math.cos(turn_rad)

    def _direction_rad(self, item: Cut) -> float:
        x, y = self._anchor(item)
        return math.atan2(y, x)

    def _anchor(self, item: Cut) -> Array:
        """Return the place that a number points to: a hole's entry, else the middle of its metal."""
        polygons = self.plate.web.cuts.get(item.number, [])
        if item.hole is None and kinds.angle_deg(item) is None and polygons:
            return np.asarray(max(polygons, key=len)[0])
        return np.asarray(item.position_mm[:2], dtype=np.float64)

    def _wheel(self, pen: Pen, occupied: Occupied) -> None:
        """Draw a degree wheel: counter-clockwise from the sheet's zero, in brackets from the other one."""
        pen.circle(self.cx, self.cy, self.wheel, RULE, 0.15)
        zero = self.zero
        step = 30 if self.wheel > 30.0 else 90
        for mark in range(0, 360, 5):
            turn = math.radians(mark + zero.angle_deg)
            long = TICKS_MM if mark % 30 == 0 else 1.4 if mark % 10 == 0 else 0.8
            pen.line(*self._at(turn, self.wheel), *self._at(turn, self.wheel + long), SOFT, 0.15)
            if mark % step == 0:
                other = None if zero.other_deg is None else (mark + zero.angle_deg - zero.other_deg) % 360.0
                self._numeral(
                    pen, turn, str(mark), "" if other is None else f"({round(other) % 360})", occupied
                )
        self._mark(pen, zero.angle_deg)

    def _numeral(self, pen: Pen, turn: float, text: str, other: str, occupied: Occupied) -> None:
        """Write a numeral of the wheel, unless a number is in its place."""
        x, down = self._at(turn, self.wheel + TICKS_MM + 0.6)
        wide = pen.text_ratio * numeral_width_mm(text, other)
        side = math.copysign(0.5, x - self.cx) * min(1.0, abs(x - self.cx) / (0.2 * self.wheel))
        left = x + (side - 0.5) * wide
        base = down + 1.0 + 2.0 * (down - self.cy) / self.wheel
        if occupied.take((left - 0.6, base - 2.4, left + wide + 0.6, base + 0.9)):
            pen.numeral(x, base, side, text, other)

    def _mark(self, pen: Pen, angle_deg: float) -> None:
        turn = math.radians(angle_deg)
        tip, left, right = (
            self._at(turn, self.wheel - 0.2),
            self._at(turn + 0.8 / self.wheel, self.wheel + 1.8),
            self._at(turn - 0.8 / self.wheel, self.wheel + 1.8),
        )
        for start, end in ((tip, left), (left, right), (right, tip)):
            pen.line(*start, *end, INK, 0.25)


# A plate on the page: heading, view, section and table of a web together.


HEAD_MM = 8.0
BESIDE_MM = 5.0
"""Gap between the view and section or table beside it."""
LEAST_BESIDE_MM = 66.0
"""Smallest width for section or table beside a view."""
SECTION_MM = 90.0
LEAST_SECTION_MM = 50.0
LEAST_WHOLE_MM, MOST_WHOLE_MM = 45.0, 110.0
"""Height of the section of the whole crank."""
LEAST_SHARE = 0.5
"""Smallest rest of a page, as a share, into which a plate that is too high is drawn smaller."""


class PlateView(Flowable):  # type: ignore[misc]
    """A plate with its cuts; rows that do not fit beside its view are in ``below``."""

    def __init__(
        self, report: BalancedReport, plate: Plate, zero: Zero, cheeks: Mapping[int, WebSide],
        u: DisplayUnits, wide_mm: float, room_mm: float, page_mm: float,
    ) -> None:  # fmt: skip
        super().__init__()
        self.report, self.plate, self.zero, self.cheeks, self.u = report, plate, zero, cheeks, u
        self.wide_mm, self.page_mm = wide_mm, page_mm
        self.rows: Sequence[Making] = makings(plate.all_items, zero, cheeks, u)
        self._lay_out(room_mm)
        self.below = [] if self.side is not None else list(self.rows)

    def _lay_out(self, room_mm: float) -> None:
        """Lay out view, section and side table within a height."""
        high = room_mm - HEAD_MM
        self.side: SideTable | None = None
        self.section: SectionView | None = None
        self.view = WebView(
            self.report, self.plate, self.zero, self.u, self.wide_mm - LEAST_BESIDE_MM - BESIDE_MM, high
        )
        beside = self.wide_mm - self.view.wide_mm - BESIDE_MM
        side = SideTable(self.rows, self.u, beside) if self.rows else None
        drawn = self.plate.web.section
        if drawn is not None and drawn.outline:
            cut_mm = 0.0 if side is None or side.high_mm + LEAST_SECTION_MM > high else side.high_mm + 2.0
            room = min(SECTION_MM, high - cut_mm)
            self.section = SectionView(
                f"Section at {self.zero.ccw(drawn.angle_deg):.1f}° ccw",
                drawn, self.plate.items, self.plate.labels(), self.u, beside, room,
                self.cheeks.get(self.plate.web.number),
            )  # fmt: skip
        above = 0.0 if self.section is None else self.section.high_mm + 2.0
        if side is not None and above + side.high_mm <= high:
            self.side = side
        content = max(self.view.high_mm, above + (0.0 if self.side is None else self.side.high_mm))
        self.high_mm = HEAD_MM + content

    def wrap(self, _wide: float, high: float) -> tuple[float, float]:
        """Return width and height [points]; smaller where more than half a page is left but not enough."""
        left = high / POINTS_PER_MM
        if self.high_mm > left >= LEAST_SHARE * self.page_mm:
            had_side = self.side is not None
            self._lay_out(left)
            if had_side and self.side is None:
                self._lay_out(self.page_mm)
        return self.wide_mm * POINTS_PER_MM, self.high_mm * POINTS_PER_MM

    def draw(self) -> None:
        pen = Pen(self.canv, self.high_mm)
        pen.text(0.0, 3.4, self.plate.title, 9.5, bold=True)
        pen.text(0.0, 6.8, shortened(self._words(), SMALLEST_PT, self.wide_mm), SMALLEST_PT)
        self.view.draw(pen, 0.0, HEAD_MM)
        x, down = self.view.wide_mm + BESIDE_MM, HEAD_MM
        if self.section is not None:
            self.section.draw(pen, x, down)
            down += self.section.high_mm + 2.0
        if self.side is not None:
            self.side.draw(pen, x, down)

    def _words(self) -> str:
        """Return scale, zero and sense of the angles, and the positions of the twins."""
        words = [f"Scale {self.view.scale_name}", f"ccw from {self.zero.name}, crankpin 1 up"]
        if self.zero.other is not None:
            words.append(f"in brackets from {self.zero.other}")
        if self.plate.from_below:
            words.append("seen from below: ccw runs clockwise here")
        words += [twin.words for twin in self.plate.twins]
        items = self.plate.items
        if any(item.of_kind.adds_metal for item in items):
            words.append("crossed: built up")
        if any(item.slug is not None for item in items):
            words.append("filled: slug")
        return "; ".join(words)


class WholeCrank(Flowable):  # type: ignore[misc]
    """The section of the whole crank, in the rest of the last page; nothing where that is too little."""

    def __init__(
        self, section: SectionDrawing, items: Sequence[Cut], labels: Sequence[str],
        u: DisplayUnits, wide_mm: float,
    ) -> None:  # fmt: skip
        super().__init__()
        self.inputs, self.u, self.wide_mm = (section, items, labels), u, wide_mm
        self.view: SectionView | None = None

    def wrap(self, _wide: float, high: float) -> tuple[float, float]:
        """Return width and height [points]."""
        room = min(high / POINTS_PER_MM - 1.0, MOST_WHOLE_MM)
        view = SectionView(
            "The whole crank: section through the axis and crankpin 1",
            *self.inputs,
            self.u,
            self.wide_mm,
            room,
        )
        self.view = view if LEAST_WHOLE_MM <= view.high_mm <= room else None
        shown = 0.0 if self.view is None else self.view.high_mm
        return self.wide_mm * POINTS_PER_MM, shown * POINTS_PER_MM

    def draw(self) -> None:
        if self.view is not None:
            self.view.draw(Pen(self.canv, self.view.high_mm), 0.0, 0.0)
