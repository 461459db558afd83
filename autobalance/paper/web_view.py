"""A web seen along the axis within a degree wheel, its cuts numbered, to a scale of ISO 5455."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from autobalance.paper.drawing import MIN_AXIAL_COMPONENT
from autobalance.paper.labels import Occupied, rings_for, spread_on_circle
from autobalance.paper.lettering import SMALLEST_PT, width_mm
from autobalance.paper.pen import (
    ACCENT,
    BADGE_MM,
    CENTRE_LINE,
    GONE,
    INK,
    METAL,
    RULE,
    SOFT,
    Pen,
    badge_width_mm,
)
from autobalance.paper.plates import Plate
from autobalance.paper.scales import scale_for
from autobalance.report.balance import kinds
from autobalance.report.balance.zero import Zero
from autobalance.report.display_units import DisplayUnits
from autobalance.types import Array, Item
from autobalance.wording import at

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
        report: Mapping[str, Any],
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

    def _metal(self, pen: Pen, item: Item) -> None:
        """Draw the metal that a cut removes or adds, and the circle and axis of a hole."""
        shadow = self.plate.web.cuts.get(item["number"], [])
        pen.hatch(shadow, self.to_page, kinds.adds_metal(item), filled=item.get("slug_mass_g") is not None)
        place = np.asarray(item["position_mm"][:2], dtype=np.float64)
        inward = item.get("inward")
        if inward is None:
            return
        if abs(inward[2]) > MIN_AXIAL_COMPONENT:
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

    def _datum(self, pen: Pen) -> None:
        """Draw the centre lines of the axis, and the circle of crankpin 1."""
        cx, cy, long = self.cx, self.cy, self.wheel - 1.0
        pen.line(cx - long, cy, cx + long, cy, ACCENT, 0.13, CENTRE_LINE)
        pen.line(cx, cy - long, cx, cy + long, ACCENT, 0.13, CENTRE_LINE)
        for throw in (at(self.report, "crank.throws") or [])[:1]:
            r = self.scale * float(throw["crank_radius_mm"])
            pen.circle(
                cx, cy - r, self.scale * 0.5 * throw["crankpin"]["diameter_mm"], ACCENT, 0.13, dash=(1.5, 0.8)
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

    def _direction_rad(self, item: Item) -> float:
        x, y = self._anchor(item)
        return math.atan2(y, x)

    def _anchor(self, item: Item) -> Array:
        """Return the place that a number points to: a hole's entry, else the middle of its metal."""
        inward, polygons = item.get("inward"), self.plate.web.cuts.get(item["number"], [])
        if inward is None and kinds.angle_deg(item) is None and polygons:
            return np.asarray(max(polygons, key=len)[0])
        return np.asarray(item["position_mm"][:2], dtype=np.float64)

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
        wide = width_mm(text, SIZE, True) + (0.6 + width_mm(other, SIZE) if other else 0.0)
        left = (
            x
            + (math.copysign(0.5, x - self.cx) * min(1.0, abs(x - self.cx) / (0.2 * self.wheel)) - 0.5) * wide
        )
        base = down + 1.0 + 2.0 * (down - self.cy) / self.wheel
        if occupied.take((left - 0.6, base - 2.4, left + wide + 0.6, base + 0.9)):
            pen.text(left, base, text, SIZE, INK, bold=True)
            pen.text(left + width_mm(text, SIZE, True) + 0.6, base, other, SIZE, SOFT)

    def _mark(self, pen: Pen, angle_deg: float) -> None:
        turn = math.radians(angle_deg)
        tip, left, right = (
            self._at(turn, self.wheel - 0.2),
            self._at(turn + 0.8 / self.wheel, self.wheel + 1.8),
            self._at(turn - 0.8 / self.wheel, self.wheel + 1.8),
        )
        for start, end in ((tip, left), (left, right), (right, tip)):
            pen.line(*start, *end, INK, 0.25)
