"""Cranks with several cylinders at an end or between two throws, and where every one of them is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array

SEGMENTS = 48


@dataclass(frozen=True)
class Step:
    """A cylinder on the axis, or a crankpin beside it at an angle; a keyway may go through all its length."""

    diameter: float
    width: float
    pin_deg: float | None = None
    key: tuple[float, float] | None = None


@dataclass(frozen=True)
class Placed:
    """A step with its middle along the axis, from the first crankpin's."""

    step: Step
    z: float


def pin(diameter: float, width: float, angle_deg: float) -> Step:
    return Step(diameter, width, angle_deg)


def stepped(
    steps: Sequence[Step],
    crank_radius: float = 27.0,
    web: float = 15.0,
    placement: Array | None = None,
    segments: int = SEGMENTS,
) -> tuple[Solid, list[Placed]]:
    """Return a crank of cylinders in a row, with a web on each side of each crankpin, and their places."""
    parts: list[Solid] = []
    placed: list[Placed] = []
    here = 0.0
    for before, step in zip([None, *steps], [*steps, None], strict=True):
        between = [each for each in (before, step) if each is not None and each.pin_deg is not None]
        if between:
            parts.append(_web(between, crank_radius, (here, here + web), segments))
            here += web
        if step is None:
            break
        parts.append(_cylinder(step, crank_radius, here, segments))
        placed.append(Placed(step, here + 0.5 * step.width))
        here += step.width
    zero = next(each.z for each in placed if each.step.pin_deg is not None)
    solid = union(parts)
    key = [_key(each) for each in placed if each.step.key is not None]
    for tool in key:
        solid = solid - tool
    solid = solid if placement is None else solid.moved(placement)
    return solid, [Placed(each.step, each.z - zero) for each in placed]


def _centre(angle_deg: float | None, crank_radius: float) -> tuple[float, float]:
    if angle_deg is None:
        return 0.0, 0.0
    angle = math.radians(angle_deg)
    return crank_radius * math.cos(angle), crank_radius * math.sin(angle)


def _cylinder(step: Step, crank_radius: float, low: float, segments: int) -> Solid:
    outline = Region.circle(0.5 * step.diameter, segments, _centre(step.pin_deg, crank_radius))
    return Solid.prism(outline, low, low + step.width)


def _web(pins: Sequence[Step], crank_radius: float, ends: tuple[float, float], segments: int) -> Solid:
    outline = Region.circle(24.0, segments)
    for each in pins:
        x, y = _centre(each.pin_deg, crank_radius)
        across = 20.0 * np.array([-y, x]) / crank_radius
        tip = np.array([x, y])
        corners = np.array([-across, tip - across, tip + across, across])[::-1]
        outline = outline + Region.circle(22.0, segments, (x, y)) + Region.of([corners])
    return Solid.prism(outline, *ends)


def _key(each: Placed) -> Solid:
    assert each.step.key is not None
    width, depth = each.step.key
    radius, half = 0.5 * each.step.diameter, 0.5 * each.step.width
    low = np.array([-0.5 * width, radius - depth, each.z - half])
    return Solid.box(low, np.array([0.5 * width, radius + 5.0, each.z + half]))
