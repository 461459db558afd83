"""A section along the axis through a web or the whole crank, cuts hatched, dimensioned from a cheek."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.paper.cuts import spread_between
from autobalance.paper.drawing import MIN_AXIAL_COMPONENT, SectionDrawing
from autobalance.paper.pen import (
    ACCENT,
    CENTRE_LINE,
    INK,
    METAL,
    SMALLEST_PT,
    SOFT,
    Pen,
    badge_width_mm,
    width_mm,
)
from autobalance.paper.plates import scale_for
from autobalance.paper.rim_strips import WebSide
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.balanced import Cut
from autobalance.types import Array

HEAD_MM = 4.4
BADGES_MM = 5.0
RULER_MM = 7.2
DIMENSION_MM = 5.0
"""Height of the row of a dimension along z."""
APART_MM = 5.0
END_MM = 9.0
"""Room beside the section for the end of the axis and its name."""
BESIDE_MM = 17.0
"""Room on the right of a dimensioned section."""
TICKS = 3
"""Fewest parts of a scale."""
NUMBERS_MM, LEAST_NUMBERS_MM = 9.0, 4.6
"""Distance of the numbers of a scale, usual and least."""
SIZE = SMALLEST_PT
SHORT_MM = 5.0
"""Length on the page below which a dimension has its arrows outside."""


class SectionView:
    """A section with z to the right and the direction of the cut up, drawn from an upper left corner."""

    def __init__(
        self, title: str, section: SectionDrawing, items: Sequence[Cut], labels: Sequence[str],
        u: DisplayUnits, wide_mm: float, room_mm: float, cheek: WebSide | None = None,
    ) -> None:  # fmt: skip
        self.title, self.section, self.u, self.wide_mm, self.cheek = title, section, u, wide_mm, cheek
        pairs = [(i, text) for i, text in zip(items, labels, strict=True) if i.number in section.cuts]
        self.items, self.labels = [item for item, _ in pairs], [text for _, text in pairs]
        self.measured = self._dimensioned()
        points = np.concatenate([*section.outline, *[p for c in section.cuts.values() for p in c]])
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        if cheek is not None:
            self.low[0], self.high[0] = min(self.low[0], cheek.z_mm), max(self.high[0], cheek.z_mm)
        size = self.high - self.low
        self.apart = max([APART_MM, *(badge_width_mm(text) + 0.8 for text in self.labels)])
        self.rows = max(1, math.ceil(len(self.items) * self.apart / (wide_mm - 2.0 * END_MM)))
        self.top = HEAD_MM + (BADGES_MM * self.rows if self.items else 0.0) + 4.0 * (cheek is not None)
        self.foot = RULER_MM + DIMENSION_MM * (self.measured is not None)
        beside = END_MM + (BESIDE_MM if self.measured is not None else END_MM)
        self.right_mm = beside - END_MM
        self.scale, self.scale_name = scale_for(
            size[0], size[1], wide_mm - beside, room_mm - self.top - self.foot
        )
        self.high_mm = self.top + self.scale * float(size[1]) + self.foot

    def _dimensioned(self) -> Cut | None:
        """Return the hole of the section with the largest unbalance, to be dimensioned; None without one."""
        holes = [item for item in self.items if item.hole is not None]
        if self.cheek is None or not holes:
            return None
        return max(holes, key=lambda item: math.hypot(*item.unbalance_change_g_mm))

    def to_page(self, places: Array) -> Array:
        """Return places (k, 2) of z and radius on the page."""
        room = self.wide_mm - END_MM - self.right_mm
        left = self.x + END_MM + 0.5 * (room - self.scale * (self.high[0] - self.low[0]))
        return np.stack(
            [
                left + self.scale * (places[:, 0] - self.low[0]),
                self.down + self.top + self.scale * (self.high[1] - places[:, 1]),
            ],
            axis=1,
        )

    def _place(self, z_mm: float, radius_mm: float) -> tuple[float, float]:
        ((x, down),) = self.to_page(np.array([[z_mm, radius_mm]])).tolist()
        return x, down

    def draw(self, pen: Pen, x: float, down: float) -> None:
        """Draw metal, cuts, numbers, dimensions and the scale of z; the corner of the box is at (x, down)."""
        self.x, self.down = x, down
        pen.text(x, down + 3.0, f"{self.title}, {self.scale_name}", SIZE)
        pen.shape(self.section.outline, self.to_page, METAL, INK, 0.2)
        for item in self.items:
            slug = item.slug is not None
            pen.hatch(self.section.cuts[item.number], self.to_page, item.of_kind.adds_metal, filled=slug)
        self._axis(pen)
        self._cheek(pen)
        if self.measured is not None:
            self._dimensions(pen, self.measured)
        self._badges(pen)
        self._ruler(pen)

    def _axis(self, pen: Pen) -> None:
        if not self.low[1] <= 0.0 <= self.high[1]:
            return
        (x0, down), (x1, _) = self._place(self.low[0], 0.0), self._place(self.high[0], 0.0)
        pen.line(x0 - 3.0, down, x1 + 2.0, down, ACCENT, 0.18, CENTRE_LINE)
        pen.text(x0 - 8.0, down + 0.9, "axis", SIZE, ACCENT)

    def _cheek(self, pen: Pen) -> None:
        """Mark the cheek that z counts from with its letter in a box."""
        if self.cheek is None:
            return
        x, top = self._place(self.cheek.z_mm, self.high[1])
        wide = width_mm(self.cheek.letter, SIZE, True) + 1.8
        pen.line(x, top + 2.0, x, top - 1.2, INK, 0.15)
        pen.box(x - 0.5 * wide, top - 4.4, wide, 3.2, INK, 0.2)
        pen.text(x, top - 1.9, self.cheek.letter, SIZE, bold=True, align="centre")

    def _dimensions(self, pen: Pen, item: Cut) -> None:
        """Draw centre to cheek and depth of a hole, its radius if it runs along the axis, and its wall."""
        assert self.cheek is not None
        z, depth, u, hole = item.position_mm[2], item.depth_mm, self.u, item.only_hole
        radius, wide = item.shown_radius_mm, 0.5 * hole.diameter_mm
        right = self._place(self.high[0], 0.0)[0] + 4.0
        row = self.down + self.high_mm - self.foot + 3.4
        if abs(hole.inward[2]) < MIN_AXIAL_COMPONENT:
            self._upright(pen, right, (z + wide, radius), (z + wide, radius - depth), f"{u.mm(depth)}")
            if abs(z - self.cheek.z_mm) > 1e-6:
                self._along(
                    pen, row, (self.cheek.z_mm, 0.0), (z, radius - depth), u.mm(abs(z - self.cheek.z_mm))
                )
        else:
            end = z + math.copysign(depth, hole.inward[2])
            self._upright(pen, right, (z, radius), (z, 0.0), f"R {u.mm(radius)}")
            self._along(pen, row, (z, radius - wide), (end, radius - wide), u.mm(depth))
        if item.wall_left_mm is not None:
            text = f"wall {u.mm(item.wall_left_mm)}"
            pen.text(self.x + self.wide_mm, self.down + 3.0, text, SIZE, align="right")

    def _upright(
        self, pen: Pen, x: float, one: tuple[float, float], two: tuple[float, float], text: str
    ) -> None:
        """Draw a dimension across the axis, its text on the right."""
        (x0, y0), (x1, y1) = self._place(*one), self._place(*two)
        for start, y in ((x0, y0), (x1, y1)):
            pen.line(start + 0.6, y, x + 1.0, y, SOFT, 0.1)
        for from_, to in _arrows(y0, y1):
            pen.arrow(x, from_, x, to)
        pen.text(x + 1.6, 0.5 * (y0 + y1) + 0.8, text, SIZE)

    def _along(
        self, pen: Pen, down: float, one: tuple[float, float], two: tuple[float, float], text: str
    ) -> None:
        """Draw a dimension along the axis on a row below the section, its text beside."""
        (x0, y0), (x1, y1) = self._place(*one), self._place(*two)
        for x, y in ((x0, y0), (x1, y1)):
            pen.line(x, y + 0.6, x, down + 1.0, SOFT, 0.1)
        arrows = _arrows(x0, x1)
        for from_, to in arrows:
            pen.arrow(from_, down, to, down)
        pen.text(max(x0, x1, *(from_ for from_, _ in arrows)) + 1.2, down + 0.8, text, SIZE)

    def _badges(self, pen: Pen) -> None:
        """Draw the numbers above, a line from each to the middle of its metal."""
        middles = [self.to_page(_middle(self.section.cuts[item.number])[None])[0] for item in self.items]
        order = sorted(range(len(middles)), key=lambda k: float(middles[k][0]))
        places: dict[int, tuple[float, float]] = {}
        low, high = self.x + 0.5 * self.apart, self.x + self.wide_mm - 0.5 * self.apart
        for row in range(self.rows):
            members = order[row :: self.rows]
            wanted = [float(middles[k][0]) for k in members]
            for k, x in zip(members, spread_between(wanted, self.apart, low, high), strict=True):
                places[k] = (x, self.down + HEAD_MM + BADGES_MM * (row + 0.5) - 0.6)
        for k, (x, down) in places.items():
            pen.line(x, down, float(middles[k][0]), float(middles[k][1]), SOFT, 0.12)
            pen.circle(float(middles[k][0]), float(middles[k][1]), 0.4, INK, 0.1, INK)
        for k, (x, down) in places.items():
            pen.badge(x, down, self.labels[k])

    def _ruler(self, pen: Pen) -> None:
        """Draw the scale of z from the cheek; of the whole crank from the middle of crankpin 1."""
        down = self.down + self.high_mm - RULER_MM + 2.2
        origin = 0.0 if self.cheek is None else self.cheek.z_mm
        per = self.u.mm_per_length
        low, high = (float(self.low[0]) - origin) / per, (float(self.high[0]) - origin) / per
        step, every = ruler_steps(high - low, self.scale * per)
        (x0, _), (x1, _) = self._place(self.low[0], 0.0), self._place(self.high[0], 0.0)
        pen.line(x0, down, x1, down, INK, 0.13)
        digits = max(0, -math.floor(math.log10(step) + 1e-9)) if step < 1.0 else 0
        for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1):
            x, _ = self._place(origin + k * step * per, 0.0)
            pen.line(x, down, x, down + (2.0 if k == 0 else 1.2), INK, 0.13)
            if k % every == 0:
                pen.text(x, down + 4.1, f"{k * step + 0.0:.{digits}f}", SIZE, INK, align="centre")
        name = "z" if self.cheek is None else f"z from {self.cheek.letter}"
        pen.text(x1 + 2.0, down + 0.6, f"{name} {self.u.length}", SIZE)


def _arrows(one: float, other: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return start and end of the arrows of a dimension; they come from outside where it is short."""
    middle = 0.5 * (one + other)
    if abs(other - one) >= SHORT_MM:
        return (middle, one), (middle, other)
    out = math.copysign(0.5 * SHORT_MM, one - other)
    return (one + out, one), (other - out, other)


def ruler_steps(long: float, mm_per: float) -> tuple[float, int]:
    """Return the round step of a scale with three parts at least, and the number of steps per numeral.

    Examples
    --------
    >>> ruler_steps(20.0, 1.0), ruler_steps(20.0, 0.2), ruler_steps(500.0, 0.2)
    ((5.0, 1), (5.0, 5), (50.0, 1))
    """
    steps = [k * 10.0**power for power in range(-4, 5) for k in (1.0, 2.0, 5.0)]
    apart = next(step for step in steps if step * mm_per >= NUMBERS_MM)
    step = min(apart, max(step for step in steps if step <= long / TICKS))
    return step, math.ceil(LEAST_NUMBERS_MM / (step * mm_per) - 1e-9)


def _middle(polygons: Sequence[Array]) -> Array:
    points = np.concatenate(polygons)
    middle: Array = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return middle
