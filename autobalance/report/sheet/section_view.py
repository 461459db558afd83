"""A section along the axis through a web or the whole crank, what goes hatched, z dimensioned below."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from reportlab.platypus import Flowable

from autobalance.report.balance import kinds
from autobalance.report.display_units import DisplayUnits
from autobalance.report.sheet.drawing import SectionDrawing
from autobalance.report.sheet.labels import spread_between
from autobalance.report.sheet.lettering import POINTS_PER_MM
from autobalance.report.sheet.pen import ACCENT, CENTRE_LINE, INK, METAL, SOFT, Pen
from autobalance.report.sheet.scales import scale_for
from autobalance.types import Array

HEAD_MM = 6.0
BADGES_MM = 5.4
RULER_MM = 9.0
APART_MM = 5.0
END_MM = 9.0
"""Beside the section, for the axis that sticks out and its name."""


class SectionView(Flowable):  # type: ignore[misc]
    """A section with z to the right and the direction of the cut up."""

    def __init__(
        self, title: str, section: SectionDrawing, items: Sequence[Mapping[str, Any]], u: DisplayUnits,
        wide_mm: float, room_mm: float,
    ) -> None:  # fmt: skip
        super().__init__()
        self.title, self.section, self.u, self.wide_mm = title, section, u, wide_mm
        self.items = [item for item in items if item["number"] in section.cuts]
        points = np.concatenate([*section.outline, *[p for c in section.cuts.values() for p in c]])
        self.low, self.high = points.min(axis=0), points.max(axis=0)
        size = self.high - self.low
        self.rows = max(1, math.ceil(len(self.items) * APART_MM / (wide_mm - 2.0 * END_MM)))
        extra = HEAD_MM + RULER_MM + BADGES_MM * self.rows
        self.scale, self.scale_name = scale_for(size[0], size[1], wide_mm - 2.0 * END_MM, room_mm - extra)
        self.top = HEAD_MM + (BADGES_MM * self.rows if self.items else 0.0)
        self.height_mm = self.top + self.scale * float(size[1]) + RULER_MM

    def wrap(self, _wide: float, _high: float) -> tuple[float, float]:
        """Return width and height [points]."""
        return self.wide_mm * POINTS_PER_MM, self.height_mm * POINTS_PER_MM

    def to_page(self, places: Array) -> Array:
        """Return where places (k, 2), z and radius, are drawn."""
        left = 0.5 * (self.wide_mm - self.scale * (self.high[0] - self.low[0]))
        return np.stack(
            [
                left + self.scale * (places[:, 0] - self.low[0]),
                self.top + self.scale * (self.high[1] - places[:, 1]),
            ],
            axis=1,
        )

    def draw(self) -> None:
        """Draw metal, cuts, numbers and the scale of z."""
        pen = Pen(self.canv, self.height_mm)
        pen.text(0.0, 3.0, f"{self.title}, scale {self.scale_name}", 7.5, SOFT)
        pen.shape(self.section.outline, self.to_page, METAL, INK, 0.2)
        for item in self.items:
            pen.hatch(self.section.cuts[item["number"]], self.to_page, kinds.adds_metal(item))
        self._axis(pen)
        self._badges(pen)
        self._ruler(pen)

    def _axis(self, pen: Pen) -> None:
        if not self.low[1] <= 0.0 <= self.high[1]:
            return
        (x0, down), (x1, _) = self.to_page(np.array([[self.low[0], 0.0], [self.high[0], 0.0]]))
        pen.line(x0 - 3.0, down, x1 + 3.0, down, ACCENT, 0.18, CENTRE_LINE)
        pen.text(x1 + 4.0, down + 1.0, "+z", 7.5, ACCENT)

    def _badges(self, pen: Pen) -> None:
        """Put the numbers above, a line from each to the middle of its metal."""
        middles = [self.to_page(_middle(self.section.cuts[item["number"]])[None])[0] for item in self.items]
        order = sorted(range(len(middles)), key=lambda k: float(middles[k][0]))
        places: dict[int, tuple[float, float]] = {}
        for row in range(self.rows):
            members = order[row :: self.rows]
            wanted = [float(middles[k][0]) for k in members]
            for k, x in zip(members, spread_between(wanted, APART_MM, 3.0, self.wide_mm - 3.0), strict=True):
                places[k] = (x, HEAD_MM + BADGES_MM * (row + 0.5) - 0.6)
        for k, (x, down) in places.items():
            pen.line(x, down, float(middles[k][0]), float(middles[k][1]), SOFT, 0.12)
            pen.circle(float(middles[k][0]), float(middles[k][1]), 0.4, INK, 0.1, INK)
        for k, (x, down) in places.items():
            pen.badge(x, down, self.items[k]["number"])

    def _ruler(self, pen: Pen) -> None:
        """Draw the scale of z from the datum, the middle of crankpin 1."""
        down = self.height_mm - RULER_MM + 2.5
        step = _round_step(14.0 / (self.scale / self.u.mm_per_length))
        (x0, _), (x1, _) = self.to_page(np.array([[self.low[0], 0.0], [self.high[0], 0.0]]))
        pen.line(x0, down, x1, down, INK, 0.13)
        low, high = float(self.low[0]) / self.u.mm_per_length, float(self.high[0]) / self.u.mm_per_length
        digits = max(0, -math.floor(math.log10(step) + 1e-9)) if step < 1.0 else 0
        for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1):
            ((x, _),) = self.to_page(np.array([[k * step * self.u.mm_per_length, 0.0]]))
            pen.line(x, down, x, down + (2.2 if k == 0 else 1.3), INK, 0.13)
            pen.text(x, down + 4.2, f"{k * step + 0.0:.{digits}f}", 6.0, INK, align="centre")
        pen.text(x1 + 2.0, down + 1.0, f"z {self.u.length}", 6.0, SOFT)


def _middle(polygons: Sequence[Array]) -> Array:
    points = np.concatenate(polygons)
    middle: Array = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return middle


def _round_step(least: float) -> float:
    """Return the least of 1, 2, 5 times a power of ten that is not below a step.

    Examples
    --------
    >>> [_round_step(each) for each in (0.3, 1.0, 14.0)]
    [0.5, 1.0, 20.0]
    """
    power = 10.0 ** math.floor(math.log10(least) + 1e-9)
    return next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= least * (1.0 - 1e-9))
