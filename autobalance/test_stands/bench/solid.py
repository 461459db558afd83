"""Solid of the bench rotor with its holes: disc on a shaft, z along the axis from the shaft's lower end."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autobalance.solid.csg.shape import Line, Prism, Revolved, Shape, Without, circle, on_grid
from autobalance.test_stands.bench.rotor import DiscHole, DiscOnShaft

PAST_MM = 1.0


def rotor_shape(rotor: DiscOnShaft, holes: Sequence[DiscHole] = ()) -> Shape:
    """Return the exact shape of a rotor; holes go down from the disc's upper face, flat-bottomed."""
    side = rotor.shaft_each_side_mm
    low, high = on_grid(side), on_grid(side + rotor.thickness_mm)
    shaft, disc, end = 0.5 * rotor.shaft_mm, 0.5 * rotor.disc_mm, on_grid(rotor.length_mm)
    corners = [(0.0, 0.0), (shaft, 0.0), (shaft, low), (disc, low), (disc, high), (shaft, high), (shaft, end)]
    if side <= 0.0:
        corners = [(0.0, 0.0), (disc, 0.0), (disc, end)]
    corners.append((0.0, corners[-1][1]))
    profile = tuple(Line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True))
    body = Revolved(profile)
    if not holes:
        return body
    return Without(body, tuple(_hole(each, low, high) for each in holes))


def _hole(hole: DiscHole, low: float, high: float) -> Prism:
    place = (hole.radius_mm * math.cos(hole.angle_rad), hole.radius_mm * math.sin(hole.angle_rad))
    bottom = high - hole.depth_mm
    through = bottom <= low
    return Prism(
        circle(0.5 * hole.diameter_mm, place),
        on_grid(low - PAST_MM if through else bottom),
        on_grid(high + PAST_MM),
    )
