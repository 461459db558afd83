"""Tools of corrections, which remove or add metal, described exactly; no facets, no kernel.

Most tools are plain shapes. Three depend on the solid that they meet. A face is lowered except under metal
that is on it. Metal grows on a face within the face's own outline. A drill follows the hole that it finds.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autobalance.solid.csg.shape import Outline, Placed, Point, Prism, Revolved, Shape, polygon
from autobalance.types import Array
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class Lowering:
    """Metal over a new, lower plane, except under metal that is on the old one.

    ``outline`` is drawn in the axes of ``placement`` (4, 4), whose z is the face's normal, and encloses the
    metal to remove. ``seed`` is a point of the face there, on the face's side of a ring that is on it.
    ``spared``, in the same axes, encloses other metal at those heights, which stays. ``within``, in the axes
    that ``placement`` leads to, is the part of space to which the cut keeps.
    """

    placement: Array
    outline: Outline
    face_mm: float
    low_mm: float
    seed: Point
    spared: tuple[Shape, ...] = ()
    within: Shape | None = None


@dataclass(frozen=True, eq=False)
class Raising:
    """Metal on plane faces of the solid, given by their numbers, up to a height over them.

    ``normal`` (3,) is the faces' own, outward.
    """

    surfaces: tuple[int, ...]
    normal: Array
    rise_mm: float
    within: Shape | None = None


@dataclass(frozen=True, eq=False)
class Drilling:
    """A twist drill's body along the z of ``placement`` (4, 4), see ``twist_drill``.

    Where a hole of its size is there already, the drill runs along that hole's own axis.
    """

    placement: Array
    radius_mm: float
    top_mm: float
    shoulder_mm: float
    point_mm: float

    @property
    def shape(self) -> Shape:
        """The body, in the axes that ``placement`` leads to."""
        drill = twist_drill(self.radius_mm, self.top_mm, self.shoulder_mm, self.point_mm)
        return Placed(drill, self.placement)


Tool = Shape | Lowering | Raising | Drilling


def placed(tool: Tool, motion: Array) -> Tool:
    """Return a tool moved rigidly by a homogeneous matrix (4, 4)."""
    if isinstance(tool, Lowering):
        return Lowering(
            motion @ tool.placement,
            tool.outline,
            tool.face_mm,
            tool.low_mm,
            tool.seed,
            tool.spared,
            None if tool.within is None else Placed(tool.within, motion),
        )
    if isinstance(tool, Drilling):
        return replace(tool, placement=motion @ tool.placement)
    if isinstance(tool, Raising):
        within = None if tool.within is None else Placed(tool.within, motion)
        return Raising(tool.surfaces, motion[:3, :3] @ tool.normal, tool.rise_mm, within)
    return Placed(tool, motion)


def ring(inner_mm: float, outer_mm: float, low_mm: float, high_mm: float) -> Revolved:
    """Return the annulus between two radii about z, from one height to another."""
    corners = [(inner_mm, low_mm), (outer_mm, low_mm), (outer_mm, high_mm), (inner_mm, high_mm)]
    return Revolved(polygon(corners))


def twist_drill(radius_mm: float, top_mm: float, shoulder_mm: float, point_mm: float) -> Revolved:
    """Return a cylinder along z from ``top`` to ``shoulder`` with a point, flat without length."""
    corners = [(0.0, top_mm), (radius_mm, top_mm), (radius_mm, shoulder_mm)]
    return Revolved(polygon([*corners, (0.0, shoulder_mm + max(point_mm, 0.0))]))


def wedge(start_rad: float, span_rad: float, reach_mm: float) -> Prism:
    """Return the sector between two half-planes through z, counter-clockwise from the first; less than 2π."""
    steps = max(2, int(np.ceil(span_rad / (0.25 * np.pi))) + 1)
    angles: NDArray[np.float64] = start_rad + np.linspace(0.0, span_rad, steps)
    far = 2.0 * reach_mm
    arc = [(far * float(np.cos(angle)), far * float(np.sin(angle))) for angle in angles]
    if abs(span_rad - np.pi) < 1e-12:  # a half-space: no corner on the axis
        return Prism(polygon(arc), -far, far)
    return Prism(polygon([(0.0, 0.0), *arc]), -far, far)
