"""Choice of the set-up that reaches a cut, and of the tool that fits it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.correction.machining import (
    AreaOperation,
    HoleOperation,
    Operation,
    RimOperation,
    is_along_axis,
    radial_error,
)
from autobalance.machining.input import CuttingTool
from autobalance.machining.part import Listed
from autobalance.machining.setups import SetupName, inverse, placement
from autobalance.machining.stock import disc
from autobalance.machining.workspace import SLIVER_MM, Workspace

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
