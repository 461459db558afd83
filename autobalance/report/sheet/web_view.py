"""A web seen along the axis within a degree wheel, its cuts numbered, to a scale of ISO 5455."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from reportlab.platypus import Flowable

from autobalance.report.balance import kinds
from autobalance.report.display_units import DisplayUnits
from autobalance.report.sheet.drawing import WebDrawing
from autobalance.report.sheet.labels import Occupied, directions, rings_for, spread_on_circle
from autobalance.report.sheet.lettering import POINTS_PER_MM, width_mm
from autobalance.report.sheet.pen import ACCENT, BADGE_MM, CENTRE_LINE, GONE, INK, METAL, RULE, SOFT, Pen
from autobalance.report.sheet.scales import scale_bar, scale_for
from autobalance.types import Array
from autobalance.wording import at, degrees

Item = Mapping[str, Any]
WHEEL_GAP_MM = 3.0
WHEEL_TEXT_MM = 9.5
"""From the wheel to the inner edge of the numbers outside of it."""
RING_MM = 5.4
APART_MM = 5.2
MOST_NOTES = 10
"""Cuts up to which sizes stand beside the numbers; the tables have them anyway."""
HIGHEST_MM = 186.0
FOOT_MM = 9.0


class WebView(Flowable):  # type: ignore[misc]
    """The view of one web."""

    def __init__(
        self,
        report: Mapping[str, Any],
        web: WebDrawing,
        items: Sequence[Item],
        u: DisplayUnits,
        wide_mm: float,
    ) -> None:
        super().__init__()
        self.report, self.web, self.items, self.u, self.wide_mm = report, web, list(items), u, wide_mm
        points = np.concatenate([*web.outline, *[p for polygons in web.cuts.values() for p in polygons]])
        self.reach = float(np.hypot(*points.T).max())
        room = 0.5 * min(wide_mm, HIGHEST_MM - FOOT_MM)
        for rings in range(1, 8):
            around = WHEEL_GAP_MM + WHEEL_TEXT_MM + rings * RING_MM * bool(self.items)
            self.scale, self.scale_name = scale_for(self.reach, self.reach, room - around, room - around)
            self.wheel = self.scale * self.reach + WHEEL_GAP_MM
            if rings_for(len(self.items), self.wheel + WHEEL_TEXT_MM, APART_MM) <= rings:
                break
        self.rings, self.half = rings, self.scale * self.reach + around
        self.height_mm = 2.0 * self.half + FOOT_MM

    def wrap(self, _wide: float, _high: float) -> tuple[float, float]:
        """Return width and height [points]."""
        return self.wide_mm * POINTS_PER_MM, self.height_mm * POINTS_PER_MM

    def to_page(self, places: Array) -> Array:
        """Return where places (k, 2) of the rotor are drawn: x up, y to the left."""
        return np.stack(
            [0.5 * self.wide_mm - self.scale * places[:, 1], self.half - self.scale * places[:, 0]], axis=1
        )

    def draw(self) -> None:
        """Draw wheel, metal, cuts, numbers."""
        pen, occupied = Pen(self.canv, self.height_mm), Occupied()
        cx, cy = 0.5 * self.wide_mm, self.half
        _wheel(pen, cx, cy, self.wheel, occupied)
        pen.shape(self.web.outline, self.to_page, METAL, INK, 0.25)
        for item in self.items:
            pen.hatch(self.web.cuts.get(item["number"], []), self.to_page, kinds.adds_metal(item))
        for item in self.items:
            self._axis_of(pen, item)
        self._datum(pen, cx, cy, occupied)
        self._numbers(pen, cx, cy, occupied)
        scale_bar(pen, self.u, 0.0, self.height_mm - 2.0)

    def _axis_of(self, pen: Pen, item: Item) -> None:
        """Draw the circle and the axis of a hole."""
        place = np.asarray(item["position_mm"][:2], dtype=np.float64)
        inward = item.get("inward")
        if inward is None:
            return
        if abs(inward[2]) > 0.7:
            ((x, down),) = self.to_page(place[None])
            r = self.scale * item["diameter_mm"] / 2.0
            pen.circle(x, down, r, GONE, 0.3)
            for dx, dy in ((r + 1.2, 0.0), (0.0, r + 1.2)):
                pen.line(x - dx, down - dy, x + dx, down + dy, INK, 0.12)
            return
        depth = float(item["depth_mm"]) + float(item.get("point_mm") or 0.0)
        along = np.asarray(inward[:2], dtype=np.float64)
        (x0, y0), (x1, y1) = self.to_page(np.stack([place - 2.0 / self.scale * along, place + depth * along]))
        pen.line(x0, y0, x1, y1, ACCENT, 0.18, (3.0, 0.8, 0.8, 0.8))

    def _datum(self, pen: Pen, cx: float, cy: float, occupied: Occupied) -> None:
        """Draw the centre lines of the axis and of crankpin 1, dimensioned to the datum."""
        long = self.wheel - 1.0
        pen.line(cx - long, cy, cx + long, cy, ACCENT, 0.13, CENTRE_LINE)
        pen.line(cx, cy - long, cx, cy + long, ACCENT, 0.13, CENTRE_LINE)
        for throw in (at(self.report, "crank.throws") or [])[:1]:
            r = self.scale * float(throw["crank_radius_mm"])
            pen.circle(
                cx, cy - r, self.scale * 0.5 * throw["crankpin"]["diameter_mm"], ACCENT, 0.13, dash=(1.5, 0.8)
            )
            self._dimension(pen, cx, cy, r, throw, occupied)

    def _dimension(self, pen: Pen, cx: float, cy: float, r: float, throw: Item, occupied: Occupied) -> None:
        label = f"{self.u.mm(throw['crank_radius_mm'])} crank radius"
        wide = width_mm(label, 6.5)
        for x in (cx + 0.35 * self.wheel, cx - 0.35 * self.wheel - wide - 1.5):
            if occupied.take((x + 0.5, cy - 0.5 * r - 2.4, x + wide + 1.8, cy - 0.5 * r + 1.0)):
                pen.line(cx, cy - r, x + 1.0, cy - r, SOFT, 0.1)
                pen.arrow(x, cy - 0.5 * r, x, cy - r)
                pen.arrow(x, cy - 0.5 * r, x, cy)
                self._paper(pen, x + 1.0, cy - 0.5 * r, wide)
                pen.text(x + 1.2, cy - 0.5 * r + 0.2, label, 6.5)
                return

    def _paper(self, pen: Pen, x: float, down: float, wide: float) -> None:
        """Lay a white patch under a text that stands on the drawing."""
        pen.canvas.setFillColor("#ffffff")
        pen.canvas.rect(
            x * POINTS_PER_MM,
            pen.y(down + 1.0),
            (wide + 0.8) * POINTS_PER_MM,
            3.2 * POINTS_PER_MM,
            stroke=0,
            fill=1,
        )

    def _numbers(self, pen: Pen, cx: float, cy: float, occupied: Occupied) -> None:
        """Put the numbers around the wheel, a line from each to its cut, sizes beside if there is room."""
        wanted = [self._direction_rad(item) for item in self.items]
        order = sorted(range(len(wanted)), key=lambda k: wanted[k])
        placed = []
        for ring in range(self.rings):
            members = order[ring :: self.rings]
            radius = self.wheel + WHEEL_TEXT_MM + RING_MM * (ring + 0.5)
            turns = spread_on_circle([wanted[k] for k in members], APART_MM / radius)
            ends = np.array([cx, cy]) + radius * directions(turns)
            placed += list(zip(members, ends.tolist(), strict=True))
        for k, (x, down) in placed:
            ((ax, ay),) = self.to_page(self._anchor(self.items[k])[None])
            pen.line(x, down, ax, ay, SOFT, 0.12)
            pen.circle(ax, ay, 0.45, INK, 0.1, INK)
        for k, (x, down) in placed:
            occupied.add((x - BADGE_MM, down - BADGE_MM, x + BADGE_MM, down + BADGE_MM))
            pen.badge(x, down, self.items[k]["number"])
        if len(placed) <= MOST_NOTES:
            for k, (x, down) in placed:
                self._note(pen, self.items[k], x, down, x < cx, occupied)

    def _direction_rad(self, item: Item) -> float:
        x, y = self._anchor(item)
        return math.atan2(y, x)

    def _anchor(self, item: Item) -> Array:
        """Return the place that a number points to: a hole's entry, else the middle of the metal drawn."""
        inward, polygons = item.get("inward"), self.web.cuts.get(item["number"], [])
        if inward is None and kinds.angle_deg(item) is None and polygons:
            return np.asarray(max(polygons, key=len)[0])
        return np.asarray(item["position_mm"][:2], dtype=np.float64)

    def _note(self, pen: Pen, item: Item, x: float, down: float, left: bool, occupied: Occupied) -> None:
        """Write radius and angle, or the depth, beside a number, unless something stands there."""
        ccw, u = kinds.angle_deg(item), self.u
        lines = [f"depth {u.mm(abs(item['depth_mm']))}"]
        if item.get("inward") is not None and ccw is not None:
            lines.insert(0, f"R {u.mm(item.get('entry_radius_mm', item['radius_mm']))} at {degrees(ccw)}")
        wide = max(width_mm(line, 6.5) for line in lines)
        start = x - BADGE_MM - 0.8 - wide if left else x + BADGE_MM + 0.8
        box = (start, down - 2.6, start + wide, down - 2.6 + 2.6 * len(lines))
        inside = start >= 0.0 and start + wide <= self.wide_mm
        if inside and occupied.take(box):
            for k, line in enumerate(lines):
                pen.text(start, down - 0.4 + 2.6 * k, line, 6.5)


def _wheel(pen: Pen, cx: float, cy: float, radius: float, occupied: Occupied) -> None:
    """Draw a degree wheel: numbers counter-clockwise, in brackets clockwise, both from crankpin 1."""
    pen.circle(cx, cy, radius, RULE, 0.15)
    step = 30 if radius > 30.0 else 90
    for mark_deg in range(0, 360, 5):
        turn = math.radians(mark_deg)
        s, c = -math.sin(turn), -math.cos(turn)
        long = 2.0 if mark_deg % 30 == 0 else 1.4 if mark_deg % 10 == 0 else 0.8
        pen.line(
            cx + radius * s, cy + radius * c, cx + (radius + long) * s, cy + (radius + long) * c, SOFT, 0.15
        )
        if mark_deg % step == 0:
            x, down = cx + (radius + 5.6) * s, cy + (radius + 5.0) * c
            pen.text(x, down + 0.2, f"{mark_deg}", 7, INK, align="centre")
            pen.text(x, down + 2.7, f"({(360 - mark_deg) % 360})", 5.5, SOFT, align="centre")
            occupied.add((x - 2.8, down - 2.4, x + 2.8, down + 3.2))
