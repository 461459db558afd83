"""Milled pockets: limits, outlines between two radii and two angles, and the metal left around them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Annotated

import numpy as np

from autobalance.correction.contract import Limits
from autobalance.correction.holes.sites import in_sectors
from autobalance.correction.relaxing import ALL_AROUND, STEP, Sectors, refuse_out_of_range, refuse_sectors
from autobalance.crank.anatomy import Face, Web
from autobalance.declare import NOT_NEGATIVE, POSITIVE
from autobalance.errors import CorrectionError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Arc, Line, Outline, outline_points
from autobalance.solid.csg.solid import Solid
from autobalance.value_classes import dataclass

# Outlines of milled pockets: between two radii and two angles, corners rounded; and their fit.


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


# Metal left around a milled pocket, and its largest depth: distances to all voids.


SKIN_MM = 1e-3
"""Metal over or under a cheek that is its own roughness."""
LOOKED_AT_MM = 10.0
"""Distance next to and below a pocket within which air is sought, and farther if none is found."""
DEPTH_TOLERANCE_MM = 1e-3
"""Depths found here are short of the exact limit by at most this, never beyond it."""
BISECTIONS = 24
"""Halvings of a depth at most: they bring 16 m to the tolerance above."""


@dataclass(frozen=True, eq=False)
class Below:
    """Metal below a plane cheek: ``crank`` in the rotor frame, ``up`` ±1 along the axis.

    ``behind_mm`` is the thickness of the web under it; its roughness ``skin_mm`` is left out.
    """

    crank: Solid
    web: int
    z_mm: float
    up: float
    behind_mm: float
    skin_mm: float

    @classmethod
    def cheek(cls, crank: Solid, face: Face, web: Web) -> Below:
        """Return the metal below a face that looks along the axis."""
        up, z = math.copysign(1.0, float(face.normal[2])), float(face.centroid_mm[2])
        behind = z - web.z_min_mm if up > 0.0 else web.z_max_mm - z
        return cls(crank, web.number, z, up, behind, 2.0 * face.spread_mm + 2.0 * SKIN_MM)

    def wall_left_mm(self, pocket: Region, depth_mm: float) -> float:
        """Return the least distance from a pocket's sides and floor to any surface but the cheek."""
        body, reach = self._body(pocket, depth_mm), LOOKED_AT_MM
        while True:
            gap = body.gap_mm(self._air(body, reach), reach)
            if gap < reach:
                return gap
            reach *= 2.0

    def deepest_mm(self, pocket: Region, wall_mm: float, most_mm: float) -> float:
        """Return the largest depth of a pocket in its web, wall kept, up to ``most_mm``; 0 if none."""
        most_mm = min(most_mm, self.behind_mm - wall_mm)
        air = self._air(self._body(pocket, most_mm), wall_mm + SKIN_MM)

        def fits(depth_mm: float) -> bool:
            return self._body(pocket, depth_mm).gap_mm(air, wall_mm + SKIN_MM) >= wall_mm - SKIN_MM

        if fits(most_mm):
            return most_mm
        low, high = 0.0, most_mm
        for _ in range(BISECTIONS):
            if high - low <= DEPTH_TOLERANCE_MM:
                break
            middle = 0.5 * (low + high)
            low, high = (middle, high) if fits(middle) else (low, middle)
        return low

    def _body(self, pocket: Region, depth_mm: float) -> Solid:
        """Return the pocket from under the cheek's skin down to its floor."""
        ends = sorted(
            (self.z_mm - self.up * self.skin_mm, self.z_mm - self.up * max(depth_mm, 2.0 * self.skin_mm))
        )
        return Solid.prism(pocket, *ends)

    def _air(self, body: Solid, reach_mm: float) -> Solid:
        """Return all voids under the cheek, around a body."""
        low, high = body.bounds
        low, high = low - 2.0 * reach_mm, high + 2.0 * reach_mm
        top = self.z_mm - self.up * self.skin_mm
        if self.up > 0.0:
            high = np.array([high[0], high[1], top])
        else:
            low = np.array([low[0], low[1], top])
        return Solid.box(low, high) - self.crank


# Limits of milled pockets.


@dataclass(frozen=True)
class MillLimits(Limits):
    """Limits of milled pockets. The defaults are ours: no standard gives them.

    Attributes
    ----------
    cutter_mm : float
        Diameter of the end mill; corners have its radius.
    min_wall_mm : float
        Metal between a pocket and any surface but the cheek it enters, and between pockets.
    min_depth_mm, max_depth_mm, depth_step_mm : float
        Depth from the cheek, along the axis; step 0: any depth.
    sectors_deg : tuple of (float, float)
        Sectors for the middles of pockets: angles in the rotor frame, counter-clockwise from the first to
        the second; (0, 360) is all around.
    """

    cutter_mm: Annotated[float, POSITIVE] = 10.0
    min_wall_mm: Annotated[float, NOT_NEGATIVE] = 3.0
    min_depth_mm: Annotated[float, POSITIVE] = 0.5
    max_depth_mm: Annotated[float, POSITIVE] = 15.0
    depth_step_mm: Annotated[float, STEP] = 0.1
    sectors_deg: Sectors = ALL_AROUND

    def __post_init__(self) -> None:
        """Refuse limits that contradict each other."""
        refuse_out_of_range("mill", self)
        if not self.min_depth_mm <= self.max_depth_mm:
            raise CorrectionError(
                f"mill.min_depth_mm is {self.min_depth_mm:g}; must be > 0 and at most "
                f"max_depth_mm = {self.max_depth_mm:g}"
            )
        refuse_sectors("mill", self.sectors_deg)
