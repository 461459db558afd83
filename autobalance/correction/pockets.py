"""Pockets milled or turned: their metal, tools and rules, and how one is found again in a solid."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from autobalance.correction.contract import Item, Limits
from autobalance.correction.holes.sites import in_sectors
from autobalance.correction.relaxing import ALL_AROUND, STEP, Sectors, refuse_out_of_range, refuse_sectors
from autobalance.correction.rings import faceted_ring
from autobalance.correction.trace import (
    Before,
    Metal,
    Reading,
    depth_left,
    rates,
    slack_mm,
    stated_number,
    stated_size,
    stated_vector,
    web_at,
    where_listed,
)
from autobalance.crank.anatomy import Face, Web
from autobalance.crank.recognition.circles import following
from autobalance.declare import NOT_NEGATIVE, POSITIVE
from autobalance.errors import CorrectionError, FormatError
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import Arc, Line, Outline, outline_area_mm2, outline_points
from autobalance.solid.csg.solid import Solid
from autobalance.units import wrapped_deg
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
        u1, v1 = following(u), following(v)
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


# Traces of milled pockets.


WALL_MM = 5e-3
"""Uncertainty of walls on files that were rounded."""


def listed_pocket(item: Item) -> Pocket:
    """Return the pocket of a listed correction.

    Raises
    ------
    FormatError
        If its corners are too large for it.
    """
    inner, outer = (stated_number(item, f"{name}_radius_mm") for name in ("inner", "outer"))
    start, end = (math.radians(stated_number(item, f"{name}_deg")) for name in ("start", "end"))
    end = start + (end - start) % (2.0 * math.pi)
    pocket = Pocket(inner, outer, start, end, stated_number(item, "corner_radius_mm"))
    if not pocket.has_room:
        raise FormatError("corner_radius_mm of a correction of kind 'mill' is too large for its pocket")
    return pocket


def listed_side(item: Item) -> int:
    """Return the side from which a listed pocket is milled: 1 for +z, -1 for -z."""
    return 1 if stated_number(item, "face_z_mm") > stated_vector(item, "position_mm")[2] else -1


@dataclass(frozen=True)
class PocketTrace:
    """Trace of a milled pocket: a sector between two radii with round corners, along the axis."""

    item: Item

    @property
    def takes_metal(self) -> bool:
        return True

    def implied(self, crank: Before, limits: Limits | None) -> Mapping[str, Any]:
        """Return the cutter of the job, the tool's volume, and the wall and depth left."""
        cutter = getattr(limits, "cutter_mm", stated_size(self.item, "cutter_mm"))
        values = {"direction": "axial", "cutter_mm": cutter, "corner_radius_mm": 0.5 * cutter}
        values["tool_volume_mm3"] = outline_area_mm2(self._pocket.outline) * (
            stated_number(self.item, "depth_mm") + CLEAR_MM
        )
        return values | where_listed(self.item, self._left(crank, limits))

    def _left(self, crank: Before, limits: Limits | None) -> dict[str, Any]:
        """Return the wall and the depth that the pocket has left."""
        z, depth = stated_number(self.item, "face_z_mm"), stated_size(self.item, "depth_mm")
        webs = {web.number: web for web in crank.anatomy.webs}
        cheeks = [
            f for f in crank.faces if f.kind == "plane" and f.web in webs and f.web == self.item.get("web")
        ]
        face = min(cheeks, key=lambda face: abs(float(face.centroid_mm[2]) - z), default=None)
        if face is None or face.web is None:
            return {}
        below, pocket = Below.cheek(crank.placed, face, webs[face.web]), self._pocket.region
        room = {"wall_left_mm": Reading(np.array(below.wall_left_mm(pocket, depth)), WALL_MM)}
        if isinstance(limits, MillLimits):
            deepest = below.deepest_mm(pocket, limits.min_wall_mm, limits.max_depth_mm)
            room["depth_left_mm"] = depth_left(deepest, depth, limits.depth_step_mm)
        return room

    @cached_property
    def _pocket(self) -> Pocket:
        return listed_pocket(self.item)

    def room(self, crank: Before) -> Solid:
        """Return all between the radii and the angles, from the cheek down."""
        depth, z = stated_size(self.item, "depth_mm"), stated_number(self.item, "face_z_mm")
        inner, outer = (stated_number(self.item, f"{name}_radius_mm") for name in ("inner", "outer"))
        start, end = stated_number(self.item, "start_deg"), stated_number(self.item, "end_deg")
        slack = slack_mm(depth)
        around = faceted_ring(max(inner - slack, 0.0), outer + slack, z - depth - slack, z + depth + slack)
        wide = min((end - start) % 360.0 or 360.0, 350.0)
        more = math.degrees(slack / max(inner, 1.0))
        angles = np.radians(np.linspace(start - more, start + wide + more, 64))
        wedge = np.concatenate(
            [np.zeros((1, 2)), 2.0 * outer * np.column_stack([np.cos(angles), np.sin(angles)])]
        )
        return around & Solid.prism(Region.of([wedge]), z - depth - slack, z + depth + slack)

    def read(self, metal: Metal) -> Mapping[str, Any]:
        """Return radii and angles from the section at half depth, the rate from the floor's section."""
        centre = metal.moments.centre_mm
        up = np.sign(stated_number(self.item, "face_z_mm") - centre[2])
        axis = np.array([0.0, 0.0, up])
        floor, cut = metal.facing(-axis)
        cheek, _ = metal.facing(axis)
        outline = np.concatenate(
            [np.zeros((0, 2)), *(p for each in metal.pieces for p in each.section(centre[2]).polygons)]
        )
        radius, middle = np.hypot(*outline.T), math.atan2(centre[1], centre[0])
        off = np.angle(np.exp(1j * (np.arctan2(outline[:, 1], outline[:, 0]) - middle)))
        return {
            "direction": "axial",
            "face": None,
            "cutter_mm": getattr(metal.limits, "cutter_mm", None),
            "web": web_at(metal.crank.anatomy, float(centre[2])),
            "inner_radius_mm": float(radius.min()),
            "outer_radius_mm": float(radius.max()),
            "start_deg": wrapped_deg(math.degrees(middle + float(off.min()))),
            "end_deg": wrapped_deg(math.degrees(middle + float(off.max()))),
            **({"side": round(up)} if "side" in self.item else {}),
            "face_z_mm": up * cheek,
            "depth_mm": cheek + floor,
            "position_mm": centre,
            **rates(cut.scaled(-metal.density_g_mm3)),
        }
