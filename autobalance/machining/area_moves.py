"""Moves of a tool over an area, and the bodies around it: part, stock, workspace."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.correction import KINDS
from autobalance.correction.machining import AreaOperation, Operation
from autobalance.crank.anatomy import Anatomy
from autobalance.machining.input import (
    Block,
    CuttingTool,
    Go,
    MachineTool,
    SetupName,
    inverse,
    placement,
    zero_of,
)
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import polygon_area_mm2
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Passes of an end mill over an area square to the spindle: loops side by side, walls and islands kept.


CHORD_MM = 0.002
"""Largest distance of straight moves from a curved wall."""
LEAST_LOOP_MM2 = 1e-3
WALL_MM = 0.2
"""Metal that is left on a pocket's wall for the last pass."""
RAMP_SLOPE = math.tan(math.radians(3.0))
"""Slope at which a mill enters metal from above."""
FIRST_PASS_OFFSET_RADII = 0.3
"""Distance outside the metal of the first pass, in radii."""
BESIDE_MM = 0.5
"""Air beside the metal where a mill comes down."""
OVER_MM = 0.5
"""Height over the metal of a layer from which a ramp begins."""
SAMPLE_MM = 0.25


@dataclass(frozen=True, eq=False)
class Area:
    """An area to lower, in the machine's x and y: the floor, what is around it, heights [mm]."""

    floor: Region
    standing: Region
    top_mm: float
    bottom_mm: float
    is_walled: bool

    def centres(self, tool: CuttingTool, left_mm: float = 0.0) -> Region:
        """Return places of the mill's axis that keep clear of standing metal, ``left_mm`` kept on walls."""
        if self.is_walled:
            return self.floor.spread(-(tool.radius_mm + left_mm))
        return self.floor.spread(FIRST_PASS_OFFSET_RADII * tool.radius_mm) - self.standing.spread(
            tool.radius_mm + left_mm
        )

    def reached(self, tool: CuttingTool) -> Region:
        """Return the part of the floor that the mill reaches."""
        return self.centres(tool).spread(tool.radius_mm) & self.floor


def loops(area: Area, tool: CuttingTool, left_mm: float) -> list[Array]:
    """Return the closed paths (k, 2) of one layer: of a pocket from the middle out, else from outside in."""
    over = min(tool.step_over_mm, tool.radius_mm)
    outlines: list[Array] = []
    region = area.centres(tool, left_mm)
    while not region.is_empty:
        outlines += [
            each
            for each in region.simplified(CHORD_MM).polygons
            if abs(polygon_area_mm2(each)) > LEAST_LOOP_MM2
        ]
        region = region.spread(-over)
    return outlines[::-1] if area.is_walled else outlines


def layers(area: Area, tool: CuttingTool) -> list[float]:
    """Return the heights of the layers, the floor last."""
    depth = area.top_mm - area.bottom_mm
    count = max(1, math.ceil(depth / tool.step_down_mm - 1e-9))
    return [area.top_mm - depth * (k + 1) / count for k in range(count)]


def moves(area: Area, tool: CuttingTool, feed: float, retract_mm: float) -> Iterator[Block]:
    """Yield the moves that lower an area; they begin and end at ``retract_mm``, over all metal around."""
    allowed = area.centres(tool)
    rough = loops(area, tool, WALL_MM if area.is_walled else 0.0) or loops(area, tool, 0.0)
    before = area.top_mm
    for height in layers(area, tool):
        yield from _layer(area, tool, rough, allowed, (before, height), feed, retract_mm)
        before = height
    if area.is_walled:
        wall = [
            each
            for each in allowed.simplified(CHORD_MM).polygons
            if abs(polygon_area_mm2(each)) > LEAST_LOOP_MM2
        ]
        yield from _layer(area, tool, wall, allowed, (before + OVER_MM, before), feed, retract_mm)


def hops(blocks: Iterable[Block]) -> Iterator[tuple[Array, Array]]:
    """Yield both ends (2,) of each rapid across."""
    at: Array | None = None
    for block in blocks:
        if not isinstance(block, Go) or block.x is None or block.y is None:
            continue
        end = np.array([block.x, block.y])
        if at is not None and block.feed is None:
            yield at, end
        at = end


def _layer(
    area: Area,
    tool: CuttingTool,
    paths: Sequence[Array],
    allowed: Region,
    heights: tuple[float, float],
    feed: float,
    retract_mm: float,
) -> Iterator[Block]:
    above, height = heights
    at: Array | None = None
    for path in paths:
        closed = _from_nearest(path, at)
        if at is not None and _is_inside(allowed, at, closed[0]):
            yield Go(x=closed[0, 0], y=closed[0, 1], feed=feed)
        else:
            if at is not None:
                yield Go(z=retract_mm, feed=feed)
            entry = None if area.is_walled else _entry(area, tool, allowed, path)
            if entry is not None:
                outside, closed = entry
                yield Go(x=outside[0], y=outside[1])
                yield Go(z=height, feed=feed)
                yield Go(x=closed[0, 0], y=closed[0, 1], feed=feed)
            else:
                yield Go(x=closed[0, 0], y=closed[0, 1])
                yield from _ramp(closed, above, height, feed)
        for x, y in closed[1:]:
            yield Go(x=x, y=y, feed=feed)
        at = closed[-1]
    if at is not None:
        yield Go(z=retract_mm, feed=feed)


def _from_nearest(path: Array, at: Array | None) -> Array:
    """Return a path closed, from its corner nearest to a place on."""
    start = 0 if at is None else int(np.argmin(np.hypot(*(path - at).T)))
    turned = np.roll(path, -start, axis=0)
    closed: Array = np.vstack([turned, turned[:1]])
    return closed


def _is_inside(allowed: Region, start: Array, end: Array) -> bool:
    """Return whether a straight move stays where the mill may be."""
    count = max(2, math.ceil(float(np.hypot(*(end - start))) / SAMPLE_MM))
    points = start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
    return bool(allowed.grown(2.0 * CHORD_MM).contains(points).all())


def _entry(area: Area, tool: CuttingTool, allowed: Region, path: Array) -> tuple[Array, Array] | None:
    """Return a place beside the metal, and the path from the corner next to it; None: metal is all around."""
    radius = tool.radius_mm
    clear = area.floor.spread(radius + BESIDE_MM)
    beside = area.floor.spread(radius + 2.0 * BESIDE_MM) - area.standing.spread(radius + BESIDE_MM)
    free = [each for each in (beside - clear).simplified(0.05).polygons if len(each)]
    if not free:
        return None
    places = np.concatenate(free)
    room = (allowed + beside).grown(2.0 * CHORD_MM)
    gaps = np.hypot(*(places[:, None, :] - path[None, :, :]).transpose(2, 0, 1))
    for flat in np.argsort(gaps, axis=None)[:ENTRIES]:
        place, corner = divmod(int(flat), len(path))
        if _is_inside(room, places[place], path[corner]):
            turned = np.roll(path, -corner, axis=0)
            return places[place], np.vstack([turned, turned[:1]])
    return None


ENTRIES = 40
"""Places tried to come down beside the metal."""


def _ramp(closed: Array, above: float, height: float, feed: float) -> Iterator[Block]:
    """Yield the way down into the metal along a path, gently; it ends where the path begins."""
    begin = above + OVER_MM if above > height else height
    yield Go(z=begin, feed=feed)
    sides = np.hypot(*np.diff(closed, axis=0).T)
    round_mm = float(sides.sum())
    turns = max(1, math.ceil((begin - height) / (RAMP_SLOPE * round_mm)))
    walked, total = 0.0, turns * round_mm
    for _ in range(turns):
        for (x, y), side in zip(closed[1:], sides, strict=True):
            walked += float(side)
            yield Go(x=x, y=y, z=begin + (height - begin) * walked / total, feed=feed)


# The metal as it is at a moment, and what of it lies near a tool.


SIDES = 96
"""Sides of the circles that stand for round tools where it is looked what they come near; around them."""
DEEPER_MM = 30.0
"""Largest reach of a second look below the first without the whole crank."""
CIRCUMSCRIBED_RATIO = 1.0 / np.cos(np.pi / SIDES)


class Stock:
    """The crank in the rotor frame, less what was cut so far.

    The bodies that were cut are kept apart: only what lies near a tool is ever cut out of the whole crank.
    """

    def __init__(self, solid: Solid, anatomy: Anatomy) -> None:
        self.solid, self.anatomy = solid, anatomy
        self.removed: list[tuple[Solid, Array]] = []
        self._last: tuple[Array, Array, Array, Solid] | None = None

    def cut(self, body: Solid) -> None:
        """Take a body (rotor frame) from it."""
        if not body.is_empty:
            self.removed.append((body, body.bounds))

    def near(self, placement: Array, low: Array, high: Array) -> Solid:
        """Return the metal in a box between two corners (3,), in the axes that ``placement`` leads from."""
        box = Solid.box(low, high).moved(placement)
        metal_near = self._around(placement, low, high) & box
        first, last = box.bounds
        for body, bounds in self.removed:
            if not (np.any(bounds[0] > last) or np.any(first > bounds[1])):
                metal_near = metal_near - body
        return metal_near.moved(inverse(placement))

    def _around(self, placement: Array, low: Array, high: Array) -> Solid:
        """Return the uncut metal in a box at least as large; the last one is kept for another look."""
        if self._last is not None:
            known, first, last, metal = self._last
            if np.array_equal(known, placement) and (low >= first).all() and (high <= last).all():
                return metal
        first, last = low - np.array([1.0, 1.0, DEEPER_MM]), high + 1.0
        metal = self.solid & Solid.box(first, last).moved(placement)
        self._last = placement.copy(), first, last, metal
        return metal

    def left(self) -> Solid:
        """Return all that is left, rotor frame."""
        return self.solid - union([body for body, _ in self.removed]) if self.removed else self.solid

    @cached_property
    def _profile(self) -> tuple[Array, Array, Array]:
        """Smallest and largest z, and largest distance from the axis, of each triangle."""
        corners = self.solid.mesh.corners
        radius = np.hypot(corners[:, :, 0], corners[:, :, 1]).max(axis=1)
        return corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1), radius

    def reach_mm(self, low_mm: float, high_mm: float) -> float:
        """Return the largest radius of metal between two z; nothing was cut of it."""
        low, high, radius = self._profile
        return float(radius[(high >= low_mm) & (low <= high_mm)].max(initial=0.0))

    @property
    def greatest_radius_mm(self) -> float:
        """Largest radius of metal anywhere."""
        return float(self._profile[2].max())

    @property
    def ends_mm(self) -> tuple[float, float]:
        """Smallest and largest z."""
        return float(self._profile[0].min()), float(self._profile[1].max())

    def part_at(self, place: Array) -> str:
        """Return the name of the crank's part at a place (3,) in the rotor frame, for messages."""
        z = float(place[2])
        for web in self.anatomy.webs:
            if web.z_min_mm - 0.1 <= z <= web.z_max_mm + 0.1:
                return f"web {web.number}"
        return "the shaft"


def disc(radius_mm: float, x: float, y: float) -> Region:
    """Return a circle that a round tool lies in."""
    return Region.circle(radius_mm * CIRCUMSCRIBED_RATIO, SIDES, (x, y))


def strip(begin: Array, end: Array, radius_mm: float) -> Region:
    """Return the area under a round tool on a straight way between two places (2,)."""
    ends = disc(radius_mm, *begin.tolist()) + disc(radius_mm, *end.tolist())
    along = end - begin
    if not along.any():
        return ends
    across = radius_mm / float(np.hypot(*along)) * np.array([-along[1], along[0]])
    return ends + Region.of([np.array([begin - across, end - across, end + across, begin + across])])


def top_mm(metal: Solid, region: Region) -> float:
    """Return the height of the highest metal over a region; −inf without metal."""
    if metal.is_empty:
        return -np.inf
    low, high = metal.bounds[0, 2], metal.bounds[1, 2]
    inside = metal & Solid.prism(region, float(low) - 1.0, float(high) + 1.0)
    return -np.inf if inside.is_empty else float(inside.bounds[1, 2])


# The crank before and after its cuts, as a verified report has them.


@dataclass(frozen=True, eq=False)
class Listed:
    """A correction as the report lists it, and how it is cut: an operation, why not, or None for no cut."""

    item: Mapping[str, Any]
    operation: Operation | str | None

    @property
    def number(self) -> int:
        """Number in the report."""
        return int(self.item["number"])

    @property
    def pressed_in(self) -> Moments:
        """Moments of the slug that goes in."""
        keys = KINDS[self.item["kind"]].pressed_in
        if keys is None:
            return Moments.zero()
        return Moments.point(float(self.item[keys[0]]), np.array(self.item[keys[1]], dtype=np.float64))


@dataclass(frozen=True, eq=False)
class MachinedCrank:
    """The crank to machine; solids are in the rotor frame, masses in g."""

    name: str
    report: Path
    sha256: str
    before: Solid
    after: Solid
    anatomy: Anatomy
    density_g_mm3: float
    tolerance: Tolerance
    residual: Unbalance
    cuts: tuple[Listed, ...]


def listed(item: Mapping[str, Any]) -> Listed:
    """Return a correction with its operation."""
    return Listed(item, KINDS[item["kind"]].machining(item))


# The crank on a machine: its metal, and the heights that a set-up has to keep.


SLIVER_MM = 0.02


class Workspace:
    """A part on a machine: the metal still there, in the axes of each set-up."""

    def __init__(self, part: MachinedCrank, machine: MachineTool) -> None:
        self.machine = machine
        self.zero = zero_of(machine, part.anatomy)
        self.stock = Stock(part.before, part.anatomy)

    def over(self, name: SetupName, region: Region, height: float) -> Solid:
        """Return the metal over a region above a height, in the set-up's axes."""
        if region.is_empty:
            return Solid.nothing()
        low, high = region.bounds
        top = self.top(name) + 1.0
        if height >= top:
            return Solid.nothing()
        near = self.stock.near(placement(name, self.zero), np.array([*low, height]), np.array([*high, top]))
        return near if near.is_empty else near & Solid.prism(region, height, top)

    def part_at(self, metal: Solid, name: SetupName) -> str:
        frame = placement(name, self.zero)
        return self.stock.part_at(frame[:3, :3] @ metal.moments(1.0).centre_mm + frame[:3, 3])

    def flat(self, name: SetupName, region: Region) -> Region:
        return region.turned(inverse(placement(name, self.zero))[:2, :2])

    def height(self, name: SetupName, z_mm: float) -> float:
        return (z_mm - self.zero.z_mm) * (-1.0 if name == "B" else 1.0)

    def area(self, name: SetupName, operation: AreaOperation) -> Area:
        floor = self.flat(name, operation.region)
        top = self.height(name, operation.top_z_mm)
        bottom = top - operation.depth_mm
        low, high = floor.bounds
        far = max((tool.diameter_mm for tool in self.machine.tools if tool.kind == "end_mill"), default=0.0)
        near = self.stock.near(
            placement(name, self.zero),
            np.array([*(low - 3.0 * far - 5.0), bottom + SLIVER_MM]),
            np.array([*(high + 3.0 * far + 5.0), self.top(name) + 1.0]),
        )
        own = Solid.prism(floor.grown(SLIVER_MM), bottom - 1.0, top + 2.0 * SLIVER_MM)
        standing = (near - own).shadow() if not near.is_empty else Region.of([])
        standing = standing.grown(-0.5 * SLIVER_MM).grown(0.5 * SLIVER_MM)
        finish = min(self.machine.zero.finish_mm, operation.depth_mm)
        return Area(floor, standing, top, bottom + finish, operation.is_walled)

    @property
    def top_anywhere(self) -> float:
        low, high = self.stock.ends_mm
        return max(self.stock.greatest_radius_mm, abs(high - self.zero.z_mm), abs(low - self.zero.z_mm))

    def top(self, name: SetupName) -> float:
        """Return the height of the crank's top in an upright set-up."""
        low, high = self.stock.ends_mm
        return max(self.height(name, low), self.height(name, high))

    def safe_mm(self, name: SetupName) -> float:
        """Return the height over everything: in R over all that turns by, in L as a diameter."""
        clear = self.machine.zero.clearance_mm
        if name in ("T", "B"):
            return math.ceil(self.top(name) + clear)
        over = math.ceil(self.stock.greatest_radius_mm + clear)
        return float(over if name == "R" else 2 * over)
