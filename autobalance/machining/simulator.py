"""Simulation of a program on the solid."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import field
from itertools import pairwise

import numpy as np

from autobalance.correction.holes.hole import drill_body
from autobalance.correction.holes.surface import Axis
from autobalance.correction.machining import AreaOperation, HoleOperation, Operation
from autobalance.correction.rings import EQUAL_AREA, RING_SIDES, faceted_ring
from autobalance.correction.rings import EQUAL_AREA as RING_EQUAL_AREA
from autobalance.errors import FormatError
from autobalance.machining.area_moves import CIRCUMSCRIBED_RATIO, SIDES, Stock
from autobalance.machining.input import CuttingTool, MachineTool, NcZero, SetupName, placement
from autobalance.machining.interpreter import Move, ToolPlace, ToolStep, steps_of, widest_mm
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.shape import equal_area
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array
from autobalance.value_classes import dataclass

# The moves of a program's text on the solid: what they cut, and what tool or holder would hit.


TOUCH_MM3 = 1e-3
"""Volume below which tool and metal only touch: rounding."""
WITHIN_MM = 1e-3
"""Amount by which a clearance may fall short: four decimals of the words."""
BESIDE_MM = 0.02
"""Smallest room beside a shank or a holder while the tool cuts: a shank as wide as its flutes rubs along the
wall that they left, over any length."""
RAMP_STEP_MM = 0.1
"""Heights in which a ramp is looked at."""
AREA_RADIUS = equal_area(SIDES)


@dataclass(frozen=True)
class Collision:
    """A move that would collide: the cut, the part of the tool, the part of the crank and the amount."""

    cut: int | None
    tool: int
    what: str
    part: str
    deep_mm: float
    line: int
    rapid: bool
    along: bool = False

    @property
    def text(self) -> str:
        """Message in one line."""
        at = "before the first cut" if self.cut is None else f"at cut {self.cut}"
        if self.rapid:
            return (
                f"{self.what} of tool {self.tool} comes {self.deep_mm:.1f} mm too near to {self.part} "
                f"in a rapid {at} (line {self.line})"
            )
        if self.along:
            return (
                f"{self.what} of tool {self.tool} runs {self.deep_mm:.1f} mm along {self.part}, less than "
                f"{BESIDE_MM:g} mm from it, {at}"
            )
        return f"{self.what} of tool {self.tool} reaches {self.deep_mm:.1f} mm into {self.part} {at}"


@dataclass
class Simulation:
    """Effect of programs: moments taken (density 1) by each cut's number, collisions, metal left."""

    stock: Stock
    taken: dict[int | None, Moments] = field(default_factory=dict)
    collisions: list[Collision] = field(default_factory=list)


@dataclass
class _Group:
    """Feeds of one tool in one pose, not yet cut."""

    tool: CuttingTool
    cut: int | None
    pose: Array
    moves: list[Move] = field(default_factory=list)


class Simulator:
    """Runs the moves of programs on one stock, set-up after set-up."""

    def __init__(self, stock: Stock, machine: MachineTool, zero: NcZero) -> None:
        self.machine, self.zero = machine, zero
        self.found = Simulation(stock)
        self.tools = {tool.number: tool for tool in machine.tools}

    def run(self, name: SetupName, moves: Sequence[Move]) -> None:
        """Run a program.

        Raises
        ------
        FormatError
            If it uses a tool that the machine has not, or cuts without a turning spindle.
        """
        group: _Group | None = None
        for move in moves:
            if move.tool not in self.tools:
                raise FormatError(f"line {move.line}: tool {move.tool} is not in the machine file")
            if not move.rapid and not move.spinning:
                raise FormatError(f"line {move.line}: a feed with the spindle at rest")
            tool = self.tools[move.tool]
            if name == "L":
                self._lathe(move, tool)
                continue
            if move.start.turned_deg != move.end.turned_deg:
                self._flush(group)
                group = None
                self._turned(move, tool)
                continue
            pose = placement(name, self.zero, self._sign, move.end.turned_deg)
            if move.rapid and not move.in_hole:
                self._flush(group)
                group = None
                self._rapid(move, tool, pose, name)
                continue
            same = group is not None and group.tool is tool and group.cut == move.cut
            if group is None or not same or not np.array_equal(group.pose, pose):
                self._flush(group)
                group = _Group(tool, move.cut, pose)
            group.moves.append(move)
        self._flush(group)

    @property
    def _sign(self) -> int:
        return 1 if self.machine.rotary is None else self.machine.rotary.sign

    # --- rapids -----------------------------------------------------------------------------------------

    def _rapid(self, move: Move, tool: CuttingTool, pose: Array, name: SetupName) -> None:
        ends = [place for place in (move.start, move.end) if place.z is not None]
        known = [place for place in ends if place.x is not None and place.y is not None]
        if not ends or not known:
            return
        low = min(float(place.z) for place in ends if place.z is not None)
        clear = self.machine.zero.clearance_mm
        if low - clear >= self._top(name) - WITHIN_MM:
            return
        path = np.array([[place.x, place.y] for place in known], dtype=np.float64)
        near = self._near(pose, path, low - clear, widest_mm(tool) + clear)
        if near.is_empty:
            return
        for step in steps_of(tool):
            bottom = low + step.low_mm - clear + WITHIN_MM
            body = Solid.prism(
                swept(path, step.radius_mm + clear - WITHIN_MM),
                bottom,
                max(bottom, float(near.bounds[1, 2])) + 1.0,
            )
            self._hit(near & body, bottom, move, tool, step, pose)

    def _turned(self, move: Move, tool: CuttingTool) -> None:
        """Turn the rotary axis, in rapid or under a cutter."""
        start = move.start
        if start.z is None:
            raise FormatError(f"line {move.line}: the axis turns while the tool's height is not known")
        if not move.rapid:
            self._milled_rim(move, tool)
            return
        clear = self.machine.zero.clearance_mm
        for step in steps_of(tool):
            if start.x is None:
                reach = self.found.stock.greatest_radius_mm
            else:
                middle, half = start.x + self.zero.z_mm, step.radius_mm + clear
                reach = self.found.stock.reach_mm(middle - half, middle + half)
            deep = reach + clear - (start.z + step.low_mm)
            if deep > WITHIN_MM:
                place = np.array([0.0, 0.0, self.zero.z_mm + (start.x or 0.0)])
                self._collides(move, tool, step, self.found.stock.part_at(place), deep)
                return

    # --- feeds ------------------------------------------------------------------------------------------

    def _flush(self, group: _Group | None) -> None:
        """Cut the metal of a group of feeds; check shank and holder."""
        if group is None or not group.moves:
            return
        feeds = [move for move in group.moves if not move.rapid]
        if not feeds:
            return
        tool, pose, first = group.tool, group.pose, feeds[0]
        segments = [each for move in feeds for each in _segments(move)]
        path = np.array([point for _, ends in segments for point in ends])
        low = min(height for height, _ in segments)
        near = self._near(pose, path, low - 1.0, widest_mm(tool))
        if near.is_empty:
            return
        top = float(near.bounds[1, 2])
        levels = _levels(segments, top)
        if not levels:
            return
        if tool.is_drill:
            cutter = self._drilled(segments, tool)
        else:
            bodies = [
                Solid.prism(_around(ends, tool.radius_mm * AREA_RADIUS), height, height + tool.flute_mm)
                for height, ends in levels
            ]
            cutter = union(bodies)
        metal = near & cutter
        left = near - cutter
        for step in steps_of(tool):
            if step.cuts:
                continue
            for height, ends in levels:
                bottom = height + step.low_mm
                if bottom < top:
                    wide, narrow = (
                        left
                        & Solid.prism(
                            _around(ends, step.radius_mm + more), bottom + WITHIN_MM, height + step.high_mm
                        )
                        for more in (BESIDE_MM, -BESIDE_MM)
                    )
                    along = narrow.is_empty or narrow.volume_mm3 <= TOUCH_MM3
                    if self._hit(wide, bottom, first, tool, step, pose, along):
                        break
        self._cut(group.cut, metal.moved(pose), cutter.moved(pose))

    def _drilled(self, segments: Sequence[tuple[float, Array]], tool: CuttingTool) -> Solid:
        """Return the metal of a drill: down to its deepest at each place; moved aside, all that it sweeps."""
        deepest: dict[tuple[float, float], float] = {}
        for height, ends in segments:
            for x, y in ends:
                key = float(x), float(y)
                deepest[key] = min(deepest.get(key, math.inf), height)
        turned = np.diag([1.0, -1.0, -1.0, 1.0])
        bodies = []
        for (x, y), height in deepest.items():
            shape = drill_body(tool.radius_mm, -tool.flute_mm, 0.0, tool.point_mm).moved(turned)
            motion = np.eye(4)
            motion[:3, 3] = x, y, height + tool.point_mm
            bodies.append(shape.moved(motion))
        aside = [(height, ends) for height, ends in segments if float(np.ptp(ends, axis=0).max()) > WITHIN_MM]
        bodies += [
            Solid.prism(swept(ends, tool.radius_mm), height, height + tool.flute_mm) for height, ends in aside
        ]
        return union(bodies)

    def _milled_rim(self, move: Move, tool: CuttingTool) -> None:
        start, end = move.start, move.end
        same = (start.x, start.y, start.z) == (end.x, end.y, end.z)
        turn = abs(end.turned_deg - start.turned_deg)
        if not same or start.y != 0.0 or start.x is None or start.z is None or abs(turn - 360.0) > 1e-6:
            raise FormatError(
                f"line {move.line}: under a cutter the axis turns a full turn at a constant height"
            )
        z = start.x + self.zero.z_mm
        radius = tool.radius_mm
        self._ring(move, tool, (z - radius, z + radius), start.z)

    def _lathe(self, move: Move, tool: CuttingTool) -> None:
        ends = [place for place in (move.start, move.end) if place.x is not None]
        known = [place for place in ends if place.z is not None]
        if not known:
            return
        radius = 0.5 * min(float(place.x) for place in ends if place.x is not None)
        heights = [float(place.z) + self.zero.z_mm for place in known if place.z is not None]
        stretch = min(heights), max(heights)
        if not move.rapid:
            half = tool.radius_mm
            self._ring(move, tool, (stretch[0] - half, stretch[1] + half), radius)
            return
        clear = self.machine.zero.clearance_mm
        for step in steps_of(tool):
            wide = step.radius_mm + clear
            reach = self.found.stock.reach_mm(stretch[0] - wide, stretch[1] + wide)
            deep = reach + clear - (radius + step.low_mm)
            if deep > WITHIN_MM:
                part = self.found.stock.part_at(np.array([0.0, 0.0, 0.5 * sum(stretch)]))
                self._collides(move, tool, step, part, deep)
                return

    def _ring(self, move: Move, tool: CuttingTool, stretch: tuple[float, float], radius: float) -> None:
        """Cut all beyond a radius along a stretch of the axis, as far as the flutes reach."""
        stock = self.found.stock
        if stock.reach_mm(*stretch) > radius:
            inner, outer = radius * RING_EQUAL_AREA, radius + tool.flute_mm
            cutter = faceted_ring(inner, outer, *stretch, RING_SIDES)
            metal = stock.near(np.eye(4), *_box(outer, stretch)) & cutter
            self._cut(move.cut, metal, cutter)
        middle = 0.5 * (stretch[0] + stretch[1])
        for step in steps_of(tool):
            more = step.radius_mm - tool.radius_mm
            reach = 0.0 if step.cuts else stock.reach_mm(stretch[0] - more, stretch[1] + more)
            deep = reach - (radius + step.low_mm)
            if not step.cuts and deep > WITHIN_MM:
                part = stock.part_at(np.array([0.0, 0.0, middle]))
                self._collides(move, tool, step, part, deep)
                return

    # --- what comes of it -------------------------------------------------------------------------------

    def _cut(self, cut: int | None, metal: Solid, cutter: Solid) -> None:
        moments = metal.moments(1.0)
        self.found.taken[cut] = self.found.taken.get(cut, Moments.zero()) + moments
        self.found.stock.cut(cutter)

    def _hit(
        self,
        both: Solid,
        bottom: float,
        move: Move,
        tool: CuttingTool,
        step: ToolStep,
        pose: Array,
        along: bool = False,
    ) -> bool:
        if both.is_empty or both.volume_mm3 <= TOUCH_MM3:
            return False
        deepest = max(both.pieces(), key=lambda piece: float(piece.bounds[1, 2]))
        centre = deepest.moments(1.0).centre_mm
        part = self.found.stock.part_at(pose[:3, :3] @ centre + pose[:3, 3])
        deep = float(both.bounds[1, 2]) - bottom
        self._collides(move, tool, step, part, deep, along)
        return True

    def _collides(
        self, move: Move, tool: CuttingTool, step: ToolStep, part: str, deep: float, along: bool = False
    ) -> None:
        self.found.collisions.append(
            Collision(move.cut, tool.number, step.name, part, deep, move.line, move.rapid, along)
        )

    def _near(self, pose: Array, path: Array, low: float, wide: float) -> Solid:
        first, last = (
            path.min(axis=0) - wide * CIRCUMSCRIBED_RATIO - 1.0,
            path.max(axis=0) + wide * CIRCUMSCRIBED_RATIO + 1.0,
        )
        top = self._farthest + 1.0
        return self.found.stock.near(pose, np.array([*first, low]), np.array([*last, max(top, low + 1.0)]))

    @property
    def _farthest(self) -> float:
        low, high = self.found.stock.ends_mm
        along = max(abs(low - self.zero.z_mm), abs(high - self.zero.z_mm))
        return max(self.found.stock.greatest_radius_mm, along)

    def _top(self, name: SetupName) -> float:
        low, high = self.found.stock.ends_mm
        if name == "R":
            return self.found.stock.greatest_radius_mm
        return high - self.zero.z_mm if name == "T" else self.zero.z_mm - low


def _box(outer: float, stretch: tuple[float, float]) -> tuple[Array, Array]:
    return (
        np.array([-outer - 1.0, -outer - 1.0, stretch[0] - 1.0]),
        np.array([outer + 1.0, outer + 1.0, stretch[1] + 1.0]),
    )


def _segments(move: Move) -> list[tuple[float, Array]]:
    """Return the straight parts of a feed, each with the height that it is looked at; ends (2, 2)."""
    start, end = _point(move.start, move.end), _point(move.end, move.end)
    fall = end[2] - start[2]
    if abs(fall) < 1e-9 or np.hypot(*(end - start)[:2]) < 1e-9:
        return [(min(start[2], end[2]), np.stack([start[:2], end[:2]]))]
    count = max(1, math.ceil(abs(fall) / RAMP_STEP_MM))
    points = start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
    return [
        (math.ceil(max(a[2], b[2]) / RAMP_STEP_MM) * RAMP_STEP_MM, np.stack([a[:2], b[:2]]))
        for a, b in pairwise(points)
    ] + [(float(end[2]), np.stack([end[:2], end[:2]]))]


def _point(place: ToolPlace, other: ToolPlace) -> Array:
    """Return a place as an array (3,); a coordinate that is not known is that of the move's end."""
    pairs = ((place.x, other.x), (place.y, other.y), (place.z, other.z))
    if any(value is None and else_ is None for value, else_ in pairs):
        raise FormatError("a feed begins where nobody knows the tool")
    return np.array([else_ if value is None else value for value, else_ in pairs], dtype=np.float64)


def _levels(segments: Iterable[tuple[float, Array]], top: float) -> list[tuple[float, list[Array]]]:
    """Return the parts of feeds by height, those over all metal left out."""
    levels: dict[float, list[Array]] = {}
    for height, ends in segments:
        if height < top:
            levels.setdefault(round(height, 4), []).append(ends)
    return sorted(levels.items())


def swept(path: Array, radius_mm: float) -> Region:
    """Return the area swept by the tool's circle along straight moves between points (k, 2)."""
    return _around([np.stack(pair) for pair in pairwise(path)] or [path], radius_mm * CIRCUMSCRIBED_RATIO)


def _around(parts: Sequence[Array], radius_mm: float) -> Region:
    angle = np.arange(SIDES) * (2.0 * math.pi / SIDES)
    circle = radius_mm * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Region.of([_stadium(ends, circle) for ends in parts])


def _stadium(ends: Array, circle: Array) -> Array:
    """Return the hull of a circle at two places: one half of it at each."""
    along = ends[-1] - ends[0]
    if float(np.hypot(*along)) < 1e-9:
        shape: Array = circle + ends[0]
        return shape
    ahead = circle @ along >= 0.0
    first = int(np.flatnonzero(ahead & ~np.roll(ahead, 1))[0])
    turned, front = np.roll(circle, -first, axis=0), np.roll(ahead, -first)
    return np.concatenate([turned[front] + ends[-1], turned[~front] + ends[0]])


# Metal of an operation, as a body in the rotor frame: the report's own, however a tool makes it.


OVER_MM = 0.01
"""Height over a face up to which its metal counts as the face's: roughness."""
BEYOND_MM = 1.0


def operation_body(operation: Operation) -> Solid:
    """Return the metal of an operation, rotor frame."""
    if isinstance(operation, HoleOperation):
        placement = Axis(operation.entry_mm, operation.inward).placement
        radius = 0.5 * operation.diameter_mm
        body = drill_body(radius, -operation.lift_mm, operation.depth_mm, operation.point_mm)
        return body.moved(placement)
    if isinstance(operation, AreaOperation):
        ends = (
            operation.top_z_mm + operation.side * OVER_MM,
            operation.top_z_mm - operation.side * operation.depth_mm,
        )
        return Solid.prism(operation.region, min(ends), max(ends))
    inner, outer = operation.new_radius_mm * EQUAL_AREA, operation.rim_radius_mm + BEYOND_MM
    return faceted_ring(inner, outer, operation.z_from_mm, operation.z_to_mm, RING_SIDES)
