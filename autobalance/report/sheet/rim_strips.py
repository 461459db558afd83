"""Templates for holes from the rim: one strip for each radius, 1:1, cut in lengths that fit the page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from reportlab.platypus import Flowable

from autobalance.report.display_units import DisplayUnits
from autobalance.report.sheet.labels import spread_between
from autobalance.report.sheet.lettering import POINTS_PER_MM
from autobalance.report.sheet.pen import ACCENT, GONE, INK, RULE, SOFT, Pen
from autobalance.wording import degrees

Item = Mapping[str, Any]
SAME_RADIUS_MM = 0.05
BORDER_DEG = 12.0
LAP_MM = 10.0
"""By how much the lengths of a strip lie over each other: two marks at each end."""
ABOVE_MM, BELOW_MM = 16.0, 6.0
APART_MM = 5.0
FAR_DEG = 60.0
"""Where holes are farther apart the strip ends and another begins."""


@dataclass(frozen=True)
class Strip:
    """Holes of one radius on webs side by side, from one angle to another."""

    radius_mm: float
    items: tuple[Item, ...]
    first_deg: float
    last_deg: float
    z_mm: tuple[float, float]

    @property
    def long_mm(self) -> float:
        """Length on the rim."""
        return math.radians(self.last_deg - self.first_deg) * self.radius_mm


def strips(report: Mapping[str, Any]) -> list[Strip]:
    """Return the strips for all holes that enter from the rim, one for each radius and web."""
    radial = [item for item in report["corrections"] if item.get("inward") and abs(item["inward"][2]) < 0.7]
    found = []
    groups: dict[tuple[Any, int], list[Item]] = {}
    for item in radial:
        groups.setdefault((item["web"], round(_radius(item) / SAME_RADIUS_MM)), []).append(item)
    webs = {web["number"]: web for web in report["crank"]["webs"]}
    for (web, _), items in groups.items():
        known = webs.get(web)
        z = [float(item["position_mm"][2]) for item in items]
        low = min([*z, *([known["z_min_mm"]] if known else [])])
        high = max([*z, *([known["z_max_mm"]] if known else [])])
        for run in _runs(items):
            angles = [angle for angle, _ in run]
            found.append(
                Strip(
                    sum(_radius(item) for _, item in run) / len(run),
                    tuple(item for _, item in run),
                    min(angles) - BORDER_DEG,
                    max(angles) + BORDER_DEG,
                    (low, high),
                )
            )
    return found


def _radius(item: Item) -> float:
    return float(item.get("entry_radius_mm", math.hypot(*item["position_mm"][:2])))


def _runs(items: Sequence[Item]) -> list[list[tuple[float, Item]]]:
    """Return holes in order around the rim, parted where none is for a long way."""
    ordered = sorted(((float(item["angle_deg"]), item) for item in items), key=lambda pair: pair[0])
    gaps = [(ordered[(k + 1) % len(ordered)][0] - angle) % 360.0 for k, (angle, _) in enumerate(ordered)]
    gaps = [360.0] if len(ordered) == 1 else gaps
    start = (max(range(len(gaps)), key=lambda k: gaps[k]) + 1) % len(ordered)
    runs: list[list[tuple[float, Item]]] = [[]]
    angle = ordered[start][0]
    for step in range(len(ordered)):
        k = (start + step) % len(ordered)
        runs[-1].append((angle, ordered[k][1]))
        angle += gaps[k]
        if gaps[k] > FAR_DEG and step < len(ordered) - 1:
            runs.append([])
    return runs


class StripTile(Flowable):  # type: ignore[misc]
    """One length of a strip, 1:1, angles along it, z across, a cross at each hole."""

    def __init__(
        self, strip: Strip, number: int, tile: int, tiles: int, u: DisplayUnits, wide_mm: float
    ) -> None:
        super().__init__()
        self.strip, self.number, self.tile, self.tiles = strip, number, tile, tiles
        self.u, self.wide_mm = u, wide_mm
        self.start_mm, self.end_mm = tile_range(strip, tile, wide_mm)
        self.margin_mm = 6.0 + max(0.5 * float(item["diameter_mm"]) for item in strip.items) * 0.0
        self.height_mm = ABOVE_MM + (strip.z_mm[1] - strip.z_mm[0]) + BELOW_MM

    def wrap(self, _wide: float, _high: float) -> tuple[float, float]:
        """Return width and height [points]."""
        return self.wide_mm * POINTS_PER_MM, self.height_mm * POINTS_PER_MM

    def _x(self, angle_deg: float) -> float:
        """Return where an angle stands: outside of the rim up, angles grow to the left."""
        return (
            math.radians(self.strip.last_deg - angle_deg) * self.strip.radius_mm
            - self.start_mm
            + self.margin_mm
        )

    def _y(self, z_mm: float) -> float:
        return ABOVE_MM + self.strip.z_mm[1] - z_mm

    def draw(self) -> None:
        """Draw edges, angles, marks, holes."""
        pen, strip, u = Pen(self.canv, self.height_mm), self.strip, self.u
        part = f", part {self.tile + 1} of {self.tiles}: lay marks on marks" if self.tiles > 1 else ""
        pen.text(
            0.0, 3.0,
            f"Strip {self.number}: web {strip.items[0]['web']}, radius {u.mm(strip.radius_mm)} {u.length}, "
            f"1:1, +z edge up, angle ccw (cw){part}",
            7.5,
        )  # fmt: skip
        left, right = self.margin_mm, self.margin_mm + self.end_mm - self.start_mm
        top, bottom = self._y(strip.z_mm[1]), self._y(strip.z_mm[0])
        for down in (top, bottom):
            pen.line(left, down, right, down, INK, 0.25)
        if self.tile == 0:
            pen.line(left, top, left, bottom, INK, 0.25)
        if self.tile == self.tiles - 1:
            pen.line(right, top, right, bottom, INK, 0.25)
        self._marks(pen, left, right, top, bottom)
        self._angles(pen, left, right, top, bottom)
        self._holes(pen, left, right)

    def _marks(self, pen: Pen, left: float, right: float, top: float, bottom: float) -> None:
        """Draw the marks that lie on those of the neighbouring lengths."""
        for x, inner in ((left, self.tile > 0), (right, self.tile < self.tiles - 1)):
            for place in (x, x + (LAP_MM if x == left else -LAP_MM)) if inner else ():
                for down in (top, bottom):
                    pen.line(place - 2.0, down, place + 2.0, down, ACCENT, 0.3)
                    pen.line(place, down - 2.0, place, down + 2.0, ACCENT, 0.3)

    def _angles(self, pen: Pen, left: float, right: float, top: float, bottom: float) -> None:
        strip = self.strip
        step = next(
            s for s in (1, 2, 5, 10, 15, 30, 90) if math.radians(s) * strip.radius_mm >= 13.0 or s == 90
        )
        for mark in range(math.ceil(strip.first_deg / step), math.floor(strip.last_deg / step) + 1):
            x = self._x(mark * step)
            if left - 0.01 <= x <= right + 0.01:
                pen.line(x, top - 1.0, x, bottom + 1.0, RULE, 0.12)
                ccw = mark * step % 360
                pen.text(x, bottom + 3.4, f"{ccw}° ({-ccw % 360}°)", 5.4, SOFT, align="centre")

    def _holes(self, pen: Pen, left: float, right: float) -> None:
        here = [(self._x(self._turned(float(item["angle_deg"]))), item) for item in self.strip.items]
        here = [(x, item) for x, item in here if left - 0.01 <= x <= right + 0.01]
        for x, item in here:
            down, r = self._y(float(item["position_mm"][2])), 0.5 * float(item["diameter_mm"])
            pen.circle(x, down, r, GONE, 0.3)
            pen.line(x - r - 1.5, down, x + r + 1.5, down, INK, 0.12)
            pen.line(x, down - r - 1.5, x, down + r + 1.5, INK, 0.12)
        places = spread_between([x for x, _ in here], APART_MM, 3.0, self.wide_mm - 3.0)
        for place, (x, item) in zip(places, here, strict=True):
            pen.line(place, 8.0, x, self._y(float(item["position_mm"][2])), SOFT, 0.1)
        for place, (_, item) in zip(places, here, strict=True):
            pen.badge(place, 8.0, item["number"])
        if len(here) * 12.0 < self.wide_mm and places == [x for x, _ in here]:
            for place, (_, item) in zip(places, here, strict=True):
                pen.text(place, 13.0, degrees(item["angle_deg"]), 6.0, align="centre")

    def _turned(self, angle_deg: float) -> float:
        """Return an angle as the strip counts it, maybe beyond 360."""
        return self.strip.first_deg + (angle_deg - self.strip.first_deg) % 360.0


def tile_range(strip: Strip, tile: int, wide_mm: float) -> tuple[float, float]:
    """Return from where to where on the strip one of its lengths reaches [mm]."""
    long = wide_mm - 12.0
    start = tile * (long - LAP_MM)
    return start, min(start + long, strip.long_mm)


def tiles_of(strip: Strip, wide_mm: float) -> int:
    """Return in how many lengths a strip is printed."""
    long = wide_mm - 12.0
    return 1 if strip.long_mm <= long else math.ceil((strip.long_mm - LAP_MM) / (long - LAP_MM))


def strip_tiles(report: Mapping[str, Any], u: DisplayUnits, wide_mm: float) -> list[StripTile]:
    """Return all lengths of all strips."""
    return [
        StripTile(strip, number, tile, tiles_of(strip, wide_mm), u, wide_mm)
        for number, strip in enumerate(strips(report), 1)
        for tile in range(tiles_of(strip, wide_mm))
    ]
