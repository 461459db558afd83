"""Passes of an end mill over an area square to the spindle: loops side by side, walls and islands kept."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.machining.blocks import Block, Go
from autobalance.machining.input import CuttingTool
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import polygon_area_mm2
from autobalance.types import Array

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
