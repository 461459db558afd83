"""Outlines of milled pockets: between two radii and two angles, corners rounded; and their fit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from autobalance.correction.holes.sites import in_sectors
from autobalance.correction.refusals import Sectors
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Arc, Line, Outline, outline_points

CLEAR_MM = 1.0
"""Height of the tool's start over the cheek, and distance of the cutter from metal around it."""
SEGMENTS = 360
"""Parts of a full circle in the tool's outline: what they miss is 5e-5 of a pocket."""
PLACES = 24
"""Directions tried on each cheek; one is the heavy side's."""
SPANS_DEG = (24.0, 60.0)
"""Angles that pockets take."""
NARROW_CUTTERS = 2.0
"""Radial width of a narrow pocket, in cutters; a wide one takes what there is."""
RAYS = 13
"""Directions in which the reach of a pocket is measured; the pocket is checked after."""
SHRINKING_MM = (1e-3, 0.05, 0.2, 0.6)
"""Reductions of a pocket where it does not fit between the rays."""


@dataclass(frozen=True)
class Pocket:
    """The outline of a pocket about the crank axis, its corners rounded; angles counter-clockwise."""

    inner_mm: float
    outer_mm: float
    start_rad: float
    end_rad: float
    corner_mm: float

    @property
    def has_room(self) -> bool:
        """Whether the rounded corners fit."""
        c = self.corner_mm
        wide = self.outer_mm - self.inner_mm >= 2.0 * c and self.inner_mm >= 0.0
        return wide and self.end_rad - self.start_rad > 2.0 * math.asin(c / (self.inner_mm + c))

    @cached_property
    def outline(self) -> Outline:
        """Two arcs, two lines, four round corners."""
        c, a, b = self.corner_mm, self.start_rad, self.end_rad
        far, near = self.outer_mm - c, self.inner_mm + c
        lean, bend = math.asin(c / far), math.asin(c / near)
        quarter, half = 0.5 * math.pi, math.pi

        def at(radius: float, angle: float) -> tuple[float, float]:
            return radius * math.cos(angle), radius * math.sin(angle)

        corners = (
            Arc(at(far, a + lean), c, a - quarter, a + lean),
            Arc(at(far, b - lean), c, b - lean, b + quarter),
            Arc(at(near, b - bend), c, b + quarter, b - bend + half),
            Arc(at(near, a + bend), c, a + bend + half, a + 3.0 * quarter),
        )
        return (
            corners[0],
            Arc((0.0, 0.0), self.outer_mm, a + lean, b - lean),
            corners[1],
            Line(corners[1].end, corners[2].start),
            corners[2],
            Arc((0.0, 0.0), self.inner_mm, b - bend, a + bend),
            corners[3],
            Line(corners[3].end, corners[0].start),
        )

    @cached_property
    def region(self) -> Region:
        """The outline in straight edges."""
        return Region.of([outline_points(self.outline, SEGMENTS)])


SLIVER_MM2 = 1e-6
"""Area by which outlines may differ from rounding."""


def lies_in(inner: Region, outer: Region) -> bool:
    """Return whether a region lies in another, except for rounding."""
    return (inner - outer).area_mm2 <= SLIVER_MM2


def pockets(free: Region, towards_rad: float, cutter_mm: float, sectors_deg: Sectors) -> Iterator[Pocket]:
    """Yield the pockets that fit in a region, in even steps from one direction, narrow and wide."""
    corner = 0.5 * cutter_mm
    seen: set[tuple[float, ...]] = set()
    for place in range(PLACES):
        middle = towards_rad + place * (2.0 * math.pi / PLACES)
        if not in_sectors(middle, sectors_deg):
            continue
        for span in map(math.radians, SPANS_DEG):
            start, end = middle - 0.5 * span, middle + 0.5 * span
            reach = _common_reach(free, start, end)
            if reach is None:
                continue
            for inner in (reach[0], max(reach[0], reach[1] - NARROW_CUTTERS * cutter_mm)):
                pocket = _fitted(Pocket(inner, reach[1], start, end, corner), free)
                if pocket is not None and (key := (pocket.inner_mm, pocket.outer_mm, start, end)) not in seen:
                    seen.add(key)
                    yield pocket


def _common_reach(free: Region, start_rad: float, end_rad: float) -> tuple[float, float] | None:
    """Return the radii between which a region lies in all of some directions, the outermost stretch."""
    inner, outer = 0.0, math.inf
    for angle in np.linspace(start_rad, end_rad, RAYS).tolist():
        ends = _crossings(free, angle)
        stretches = [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=False) if a < outer and b > inner]
        if not stretches:
            return None
        inner, outer = max(inner, stretches[-1][0]), min(outer, stretches[-1][1])
    return (inner, outer) if outer > inner else None


def _crossings(region: Region, angle_rad: float) -> list[float]:
    """Return the rising radii at which a ray from the axis crosses an outline; 0 first if begun inside."""
    along = np.array([math.cos(angle_rad), math.sin(angle_rad)])
    across = np.array([-along[1], along[0]])
    crossings: list[float] = []
    for outline in region.polygons:
        u, v = outline @ along, outline @ across
        u1, v1 = np.roll(u, -1), np.roll(v, -1)
        rows = (v < 0.0) != (v1 < 0.0)
        at = u[rows] - v[rows] * (u1[rows] - u[rows]) / (v1[rows] - v[rows])
        crossings += at[at > 0.0].tolist()
    crossings.sort()
    return [0.0, *crossings] if len(crossings) % 2 else crossings


def _fitted(pocket: Pocket, free: Region) -> Pocket | None:
    """Return a pocket a little smaller, so that it lies in a region all over; None if it does not."""
    for by in SHRINKING_MM:
        smaller = replace(pocket, inner_mm=pocket.inner_mm + by, outer_mm=pocket.outer_mm - by)
        if smaller.has_room and lies_in(smaller.region, free):
            return smaller
    return None
