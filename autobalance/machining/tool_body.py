"""The shape of a tool in its holder, as round steps over the tip."""

from __future__ import annotations

from dataclasses import dataclass

from autobalance.machining.input import CuttingTool


@dataclass(frozen=True)
class Step:
    """A round part of tool or holder: its radius, and where it begins and ends over the tip [mm]."""

    name: str
    radius_mm: float
    low_mm: float
    high_mm: float
    cuts: bool


def steps_of(tool: CuttingTool) -> tuple[Step, ...]:
    """Return the parts of a tool from its tip up: flutes, shank, holder."""
    radius = tool.radius_mm
    steps = [Step("flute", radius, 0.0, tool.flute_mm + tool.point_mm, True)]
    if tool.stick_out_mm > tool.flute_mm + tool.point_mm:
        steps.append(Step("shank", radius, tool.flute_mm + tool.point_mm, tool.stick_out_mm, False))
    at = tool.stick_out_mm
    for diameter, length in tool.holder:
        steps.append(Step("holder", 0.5 * diameter, at, at + length, False))
        at += length
    return tuple(steps)


def widest_mm(tool: CuttingTool) -> float:
    """Return the radius of the widest part."""
    return max(step.radius_mm for step in steps_of(tool))


def length_mm(tool: CuttingTool) -> float:
    """Return the length of tool and holder from the tip."""
    return tool.stick_out_mm + sum(length for _, length in tool.holder)
