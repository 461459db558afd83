"""Planning of operations: tools, feeds and their order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import field
from functools import partial

import numpy as np

from autobalance.correction.machining import (
    AreaOperation,
    HoleOperation,
    Operation,
    RimOperation,
    angle_deg,
    is_along_axis,
    radial_error,
)
from autobalance.declare import Ordinal
from autobalance.errors import JobError
from autobalance.machining.area_moves import (
    SLIVER_MM,
    Listed,
    MachinedCrank,
    Workspace,
    disc,
    hops,
    moves,
    strip,
    top_mm,
)
from autobalance.machining.input import (
    Block,
    Clamp,
    CuttingTool,
    DrillCycle,
    Go,
    Index,
    MachineTool,
    NcZero,
    Note,
    Retreat,
    SetupName,
    ToolChange,
    Unclamp,
    inverse,
    placement,
    rotary_deg,
)
from autobalance.machining.interpreter import steps_of, widest_mm
from autobalance.machining.simulator import operation_body
from autobalance.solid.csg.region import Region
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Choice of the set-up that reaches a cut, and of the tool that fits it.


OFF_AXIS_MM = 0.01
AXIS_TOLERANCE = 1e-4
SAME_MM = 0.01
SAME_DEG = 0.5
NOTHING_MM3 = 1e-3
MAX_COVERED_SHARE = 0.02
"""Share of an area that metal may lie over; more, and no cutter comes along the axis."""
OVER_ENTRY_MM = 1.0
LEFT_SHARE = 2e-4


def setup_of(space: Workspace, operation: Operation) -> str:
    """Return the set-up that reaches a cut; a sentence why none does."""
    if isinstance(operation, HoleOperation):
        return _setup_of_hole(space, operation)
    if isinstance(operation, AreaOperation):
        name: SetupName = "T" if operation.side == 1 else "B"
        covered = _covered(space, name, operation)
        return name if covered is None else covered
    if any(tool.kind == "turning" for tool in space.machine.tools):
        return "L"
    if space.machine.rotary is not None:
        return "R"
    return "the machine file has neither a turning tool nor a [rotary] axis"


def _setup_of_hole(space: Workspace, operation: HoleOperation) -> str:
    if is_along_axis(operation):
        name: SetupName = "T" if operation.inward[2] < 0.0 else "B"
        frame = inverse(placement(name, space.zero))
        x, y, z = frame[:3, :3] @ operation.entry_mm + frame[:3, 3]
        radius = 0.5 * operation.diameter_mm
        metal = space.over(name, disc(radius, x, y), z + 2.0 * radius + OVER_ENTRY_MM)
        if metal.volume_mm3 > NOTHING_MM3:
            return f"{space.part_at(metal, name)} lies over it along the axis; no set-up reaches it"
        return name
    off, lean = radial_error(operation)
    if off > OFF_AXIS_MM or lean > AXIS_TOLERANCE:
        return "it is oblique: its axis does not meet the crank axis square; no set-up reaches it"
    return "R" if space.machine.rotary is not None else "the machine file has no [rotary] axis"


def _covered(space: Workspace, name: SetupName, operation: AreaOperation) -> str | None:
    region = space.flat(name, operation.region)
    top = space.height(name, operation.top_z_mm)
    metal = space.over(name, region.grown(-SLIVER_MM), top + OVER_ENTRY_MM)
    if metal.is_empty or metal.shadow().area_mm2 <= MAX_COVERED_SHARE * region.area_mm2:
        return None
    return f"{space.part_at(metal, name)} lies over it along the axis; no set-up reaches it"


def tool_for(space: Workspace, cut: Listed, operation: Operation, setup: str) -> CuttingTool | str:
    """Return the tool that fits a cut; a sentence what is missing."""
    who = f"cut {cut.number}"
    if isinstance(operation, HoleOperation):
        size = f"diameter_mm = {operation.diameter_mm:g} and point_deg = {operation.point_deg:g}"
        what = f"a drill with {size}"
        fitting = [
            tool
            for tool in space.machine.tools
            if tool.is_drill
            and abs(tool.diameter_mm - operation.diameter_mm) <= SAME_MM
            and abs(tool.point_deg - operation.point_deg) <= SAME_DEG
        ]
        return _long_enough(who, fitting, operation.depth_mm, what)
    if isinstance(operation, AreaOperation):
        corner = operation.corner_radius_mm
        mills = [tool for tool in space.machine.tools if tool.kind == "end_mill"]
        widest = "" if corner is None else f" of at most {2.0 * corner:g} mm (its corners)"
        fitting = [tool for tool in mills if corner is None or tool.radius_mm <= corner + 1e-6]
        fitting.sort(key=lambda tool: -tool.diameter_mm)
        if corner is None:
            fitting = _that_reach(space, operation, setup, fitting)
        return _long_enough(who, fitting, operation.depth_mm, f"an end_mill{widest}")
    depth = operation.rim_radius_mm - operation.new_radius_mm
    if setup == "L":
        turning = [tool for tool in space.machine.tools if tool.kind == "turning"]
        return _long_enough(who, turning, depth, "a turning tool")
    mills = [tool for tool in space.machine.tools if tool.kind == "end_mill"]
    mills.sort(key=lambda tool: (not _clears_neighbours(space, operation, tool), -tool.diameter_mm))
    return _long_enough(who, mills, depth, "an end_mill")


def _long_enough(who: str, fitting: Sequence[CuttingTool], depth: float, what: str) -> CuttingTool | str:
    if not fitting:
        return f"{who}: no tool fits; expected {what} in [[tool]]"
    long = [tool for tool in fitting if tool.flute_mm >= depth - 1e-9]
    if long:
        return long[0]
    tool = max(fitting, key=lambda each: each.flute_mm)
    return (
        f"{who}: tool {tool.number} has flute_mm = {tool.flute_mm:g}; the cut is {depth:.4g} mm deep; "
        "expected a longer one"
    )


def _that_reach(
    space: Workspace, operation: AreaOperation, setup: str, mills: Sequence[CuttingTool]
) -> list[CuttingTool]:
    """Return mills in the order in which to take them: the widest that leaves next to nothing first."""
    area = space.area("T" if setup == "T" else "B", operation)
    whole = area.floor.area_mm2
    left = {tool.number: whole - area.reached(tool).area_mm2 for tool in mills}
    least = min(left.values(), default=0.0)
    good = [tool for tool in mills if left[tool.number] <= least + LEFT_SHARE * whole]
    return [*good, *(tool for tool in mills if tool not in good)]


def _clears_neighbours(space: Workspace, operation: RimOperation, tool: CuttingTool) -> bool:
    """Return whether a mill over a rim reaches into no other metal beside it."""
    low, high = operation.z_from_mm, operation.z_to_mm
    first, last = rim_lines(operation, tool)[0], rim_lines(operation, tool)[-1]
    beside = [(first - tool.radius_mm, low - SLIVER_MM), (high + SLIVER_MM, last + tool.radius_mm)]
    return all(
        end <= start or space.stock.reach_mm(start, end) <= operation.new_radius_mm for start, end in beside
    )


def rim_lines(operation: RimOperation, tool: CuttingTool) -> list[float]:
    """Return the z that a mill's axis turns the rim under, side by side."""
    low, high, radius = operation.z_from_mm, operation.z_to_mm, tool.radius_mm
    if high - low <= 2.0 * radius:
        return [0.5 * (low + high)]
    count = max(1, math.ceil((high - low - 2.0 * radius) / min(tool.step_over_mm, 2.0 * radius)))
    lines: list[float] = np.linspace(low + radius, high - radius, count + 1).tolist()
    return lines


# The programs of each set-up as blocks, before a post writes them: tools in turn, and their moves.


ORDER: tuple[SetupName, ...] = ("R", "T", "B", "L")
FULL_TURN = 360.0
PAST_MM = 0.1


@dataclass
class Setup:
    """The program of one set-up, as blocks."""

    name: SetupName
    safe_mm: float
    blocks: list[Block] = field(default_factory=list)
    tools: list[CuttingTool] = field(default_factory=list)
    cuts: list[tuple[Listed, CuttingTool]] = field(default_factory=list)


@dataclass(frozen=True)
class NotProgrammed:
    """A correction that no program makes."""

    correction: Ordinal
    why: str


@dataclass(frozen=True, eq=False)
class NcPlan:
    """All set-ups, and the cuts that none reaches with the reason."""

    zero: NcZero
    setups: tuple[Setup, ...]
    not_programmed: tuple[NotProgrammed, ...]


@dataclass(frozen=True, eq=False)
class _Job:
    """A cut in its set-up, with its tool."""

    cut: Listed
    operation: Operation
    setup: SetupName
    tool: CuttingTool


class Planner:
    """Plans the programs of a part on a machine."""

    def __init__(self, part: MachinedCrank, machine: MachineTool) -> None:
        self.part, self.machine = part, machine
        self.space = Workspace(part, machine)

    def plan(self) -> NcPlan:
        """Return the set-ups.

        Raises
        ------
        JobError
            If a tool is missing, too short, or the travel is.
        """
        left_out: list[NotProgrammed] = []
        faults: list[str] = []
        jobs: list[_Job] = []
        for cut in self.part.cuts:
            operation = cut.operation
            if operation is None:
                continue
            place = operation if isinstance(operation, str) else setup_of(self.space, operation)
            if isinstance(operation, str) or place not in ORDER:
                left_out.append(NotProgrammed(cut.number, place))
                continue
            tool = tool_for(self.space, cut, operation, place)
            if isinstance(tool, str):
                faults.append(tool)
            else:
                jobs.append(_Job(cut, operation, place, tool))
        if faults:
            raise JobError("; ".join(dict.fromkeys(faults)))
        setups = [self._planned(name, [job for job in jobs if job.setup == name]) for name in ORDER]
        return NcPlan(self.space.zero, tuple(each for each in setups if each.cuts), tuple(left_out))

    def _planned(self, name: SetupName, jobs: Sequence[_Job]) -> Setup:
        setup = Setup(name, self.space.safe_mm(name))
        order = list(dict.fromkeys(job.tool.number for job in jobs))
        for number in order:
            mine = [job for job in jobs if job.tool.number == number]
            tool = mine[0].tool
            rpm = tool.speed_rpm(self._cutting_diameter(mine), self.machine.spindle.max_rpm)
            setup.tools.append(tool)
            setup.blocks.append(Note(f"tool {number}: {tool_words(tool)}"))
            setup.blocks.append(ToolChange(tool, rpm, setup.safe_mm))
            for job in mine:
                setup.cuts.append((job.cut, tool))
                setup.blocks.append(Note(cut_words(job.cut)))
                setup.blocks += self._moves(job, setup, tool.feed(rpm))
                self.space.stock.cut(operation_body(job.operation))
            setup.blocks.append(Retreat(setup.safe_mm))
        return setup

    def _cutting_diameter(self, jobs: Sequence[_Job]) -> float:
        first = jobs[0]
        if isinstance(first.operation, RimOperation) and first.setup == "L":
            return 2.0 * max(
                job.operation.rim_radius_mm for job in jobs if isinstance(job.operation, RimOperation)
            )
        return first.tool.diameter_mm

    def _moves(self, job: _Job, setup: Setup, feed: float) -> Iterator[Block]:
        operation = job.operation
        if isinstance(operation, HoleOperation):
            yield from self._hole(operation, job.tool, setup, feed)
        elif isinstance(operation, AreaOperation):
            yield from self._lowered(operation, job.tool, setup, feed)
        elif setup.name == "L":
            yield from self._turned(operation, job.tool, setup, feed)
        else:
            yield from self._milled_rim(operation, job.tool, setup, feed)

    def _hole(
        self, operation: HoleOperation, tool: CuttingTool, setup: Setup, feed: float
    ) -> Iterator[Block]:
        rotary = self.machine.rotary
        sign, turned = 1, 0.0
        if setup.name == "R":
            assert rotary is not None  # else it would not be in this set-up
            sign = rotary.sign
            turned = rotary_deg(angle_deg(operation), self.space.zero, sign)
        pose = placement(setup.name, self.space.zero, sign, turned)
        frame = inverse(pose)
        x, y, z = (frame[:3, :3] @ operation.entry_mm + frame[:3, 3]).tolist()
        y = 0.0 if setup.name == "R" else y
        depth = max(operation.depth_mm - self.machine.zero.finish_mm, 0.0)
        bottom = z - depth - operation.point_mm
        retract = self._retract_mm(tool, pose, (x, y, z), bottom)
        if setup.name == "R":
            yield Go(z=setup.safe_mm)
            yield Index(turned)
        yield Go(x=x, y=y)
        yield DrillCycle(x, y, bottom, min(retract, setup.safe_mm), feed, tool.peck_mm)

    def _retract_mm(
        self, tool: CuttingTool, pose: Array, entry: tuple[float, float, float], bottom: float
    ) -> float:
        """Return the lowest height of the tip in rapid over a hole: tool and holder clear of all metal."""
        x, y, z = entry
        clear = self.machine.zero.clearance_mm
        reach = widest_mm(tool) + clear + 1.0
        top = max(self.space.top_anywhere, z) + 1.0
        low, high = np.array([x - reach, y - reach, bottom - 1.0]), np.array([x + reach, y + reach, top])
        near = self.space.stock.near(pose, low, high)
        heights = [
            top_mm(near, disc(step.radius_mm + clear, x, y)) + clear - step.low_mm for step in steps_of(tool)
        ]
        return float(np.ceil(max(z + clear, *heights) * 100.0) / 100.0)

    # --- areas ------------------------------------------------------------------------------------------

    def _lowered(
        self, operation: AreaOperation, tool: CuttingTool, setup: Setup, feed: float
    ) -> Iterator[Block]:
        area = self.space.area(setup.name, operation)
        if area.top_mm - area.bottom_mm <= 1e-6:
            return
        clear, path = self.machine.zero.clearance_mm, area.centres(tool)
        if path.is_empty:
            path = area.floor
        swept = path.spread(2.0 * tool.radius_mm + 1.0)
        reach = widest_mm(tool) + clear + 1.0
        low, high = swept.bounds
        near = self.space.stock.near(
            placement(setup.name, self.space.zero),
            np.array([*(low - reach), area.bottom_mm - 1.0]),
            np.array([*(high + reach), self.space.top(setup.name) + 1.0]),
        )

        def over_all(under: Callable[[float], Region]) -> float:
            tops = [top_mm(near, under(step.radius_mm + clear)) - step.low_mm for step in steps_of(tool)]
            return min(float(np.ceil((max(area.top_mm, *tops) + clear) * 100.0) / 100.0), setup.safe_mm)

        retract = over_all(swept.spread)
        blocks = list(moves(area, tool, feed, retract))
        over = max((over_all(partial(strip, *ends)) for ends in hops(blocks)), default=retract)
        if over > retract:  # something stands between two loops, such as a shaft
            retract, blocks = over, list(moves(area, tool, feed, over))
        first = next((block for block in blocks if isinstance(block, Go) and block.x is not None), None)
        if first is None:
            return
        yield Go(x=first.x, y=first.y)
        yield Go(z=retract)
        yield from blocks
        yield Go(z=setup.safe_mm)

    # --- rims -------------------------------------------------------------------------------------------

    def _passes(self, operation: RimOperation, tool: CuttingTool) -> list[float]:
        """Return the radii of the passes, the last one that which is left."""
        new = min(operation.new_radius_mm + self.machine.zero.finish_mm, operation.rim_radius_mm)
        depth = operation.rim_radius_mm - new
        count = max(1, math.ceil(depth / tool.step_down_mm - 1e-9))
        return [operation.rim_radius_mm - depth * (k + 1) / count for k in range(count)]

    def _milled_rim(
        self, operation: RimOperation, tool: CuttingTool, setup: Setup, feed: float
    ) -> Iterator[Block]:
        yield Go(z=setup.safe_mm)
        yield Index(0.0)
        yield Unclamp()
        at = 0.0
        for line in rim_lines(operation, tool):
            yield Go(x=line - self.space.zero.z_mm, y=0.0)
            for radius in self._passes(operation, tool):
                yield Go(z=radius, feed=feed)
                at = FULL_TURN - at
                yield Go(a=at, feed=feed / (2.0 * math.pi * radius) * FULL_TURN)
            yield Go(z=setup.safe_mm, feed=feed)  # the rim stands beside the mill
        yield Clamp()

    def _turned(
        self, operation: RimOperation, tool: CuttingTool, setup: Setup, feed: float
    ) -> Iterator[Block]:
        past = tool.nose_radius_mm + PAST_MM
        start, end = (
            operation.z_from_mm - past - self.space.zero.z_mm,
            operation.z_to_mm + past - self.space.zero.z_mm,
        )
        for radius in self._passes(operation, tool):
            yield Go(z=start)
            yield Go(x=2.0 * radius, feed=feed)
            yield Go(z=end, feed=feed)
            yield Go(x=setup.safe_mm, feed=feed)  # the rim stands beside the tool


def tool_words(tool: CuttingTool) -> str:
    """Return the description of a tool, in a line."""
    if tool.kind == "turning":
        return f"turning tool, nose radius {tool.nose_radius_mm:g}"
    point = f", point {tool.point_deg:g} deg" if tool.is_drill else ""
    return f"{tool.kind.replace('_', ' ')} dia {tool.diameter_mm:g}{point}, stick-out {tool.stick_out_mm:g}"


def cut_words(cut: Listed) -> str:
    """Return the description of a cut, in a line: number, web, angle, depth."""
    item = cut.item
    web = f", web {item['web']}" if item.get("web") is not None else ""
    angle = "" if isinstance(cut.operation, RimOperation) else f", at {float(item['angle_deg']):.4f} deg"
    return f"cut {cut.number}{web}{angle}, depth {abs(float(item['depth_mm'])):.4f}"
