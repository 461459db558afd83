"""The programs of each set-up as blocks, before a post writes them: tools in turn, and their moves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from autobalance.correction.machining import (
    AreaOperation,
    HoleOperation,
    Operation,
    RimOperation,
    angle_deg,
)
from autobalance.declare import Ordinal
from autobalance.errors import JobError
from autobalance.machining.area_moves import hops, moves
from autobalance.machining.blocks import Block, Bore, Change, Clamp, Go, Index, Note, Retreat, Unclamp
from autobalance.machining.choices import rim_lines, setup_of, tool_for
from autobalance.machining.input import CuttingTool, MachineTool
from autobalance.machining.operation_body import operation_body
from autobalance.machining.part import Listed, Part
from autobalance.machining.setups import NcZero, SetupName, inverse, placement, rotary_deg
from autobalance.machining.stock import disc, strip, top_mm
from autobalance.machining.tool_body import steps_of, widest_mm
from autobalance.machining.workspace import Workspace
from autobalance.solid.csg.region import Region
from autobalance.types import Array

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

    def __init__(self, part: Part, machine: MachineTool) -> None:
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
            setup.blocks.append(Change(tool, rpm, setup.safe_mm))
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
        yield Bore(x, y, bottom, min(retract, setup.safe_mm), feed, tool.peck_mm)

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
