"""Metal taken from a body, or added to it, by each of several tools, measured on exact surfaces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.cad.build import (
    AS_DRAWN,
    SAME_HEIGHT_MM,
    SAME_NORMAL,
    along_old_hole,
    clear_shares,
    tool_shape,
)
from autobalance.solid.cad.kernel import area_properties, common, cut, explored, fused, properties
from autobalance.solid.cad.tessellation import PlaneFace, as_array, bounds_mm, surfaces
from autobalance.solid.csg.shape import Arc, Line, Outline, outline_area_mm2, reversed_outline
from autobalance.solid.csg.tool import Drilling, Lowering, Raising, Tool
from autobalance.types import Array
from autobalance.value_classes import dataclass

ADD_UP = 1e-7
"""Share of the metal moved by which tools one by one may differ from all of them together."""
CHORDS_PER_EDGE = 64
"""Straight parts of an edge that is neither line nor circle."""


@dataclass(frozen=True, eq=False)
class Edge:
    """An edge of a plane face: a line between its ends (3,), or an arc about ``centre``.

    ``swept_rad`` is counter-clockwise about ``axis`` (unit, (3,)); ``axis`` None: a line.
    """

    start: Array
    end: Array
    centre: Array | None = None
    axis: Array | None = None
    swept_rad: float = 0.0


Loop = tuple[Edge, ...]


@dataclass(frozen=True, eq=False)
class EachTaken:
    """Metal taken or added by one tool.

    Attributes
    ----------
    volume : Moments
        Of the metal that went or came, density 1.
    floor : Moments or None
        ∫ (1, r, r rᵀ) dA over the new face, where a face was lowered or raised.
    loops : tuple of Loop
        Outline of that face: outer loops, each followed by its islands.
    hole : (4, 4) float or None
        If a drill ran along an existing hole, its placement there.
    lift_mm : float
        Height over the old face at which lowering it began, where that was up in a fillet; else 0.
    """

    volume: Moments
    floor: Moments | None = None
    loops: tuple[Loop, ...] = ()
    hole: Array | None = None
    lift_mm: float = 0.0


def each_taken(
    body: Any,
    removed: Sequence[Tool],
    added: Sequence[Tool],
    change_mm3: float,
    shares: Sequence[float] | None = None,
) -> tuple[tuple[EachTaken, ...], tuple[EachTaken, ...]] | None:
    """Return the metal that each removing tool took of a body, and that each adding one added, in turn.

    Metal that two tools want is the first one's. ``change_mm3`` is the change of the body's volume by all of
    them; None where their sum differs from it at every height over the faces (``clear_shares``) and by both
    ways of measuring.
    """
    low, high = bounds_mm(body)
    size = float(np.linalg.norm(high - low))
    for share in clear_shares(removed, shares):
        lift_mm = 0.0 if share <= AS_DRAWN else share * size
        grown = [tool_shape(tool, body, share * size) for tool in added]
        tools = [tool_shape(tool, body, share * size) for tool in removed]
        whole = fused([body, *grown])
        came = [cut(part, [body]) for part in _apart(grown)]
        went = [common(whole, part) for part in _apart(tools)]
        adds = tuple(_measured(tool, part, body, 0.0) for tool, part in zip(added, came, strict=True))
        takes = tuple(_measured(tool, part, body, lift_mm) for tool, part in zip(removed, went, strict=True))
        if _adds_up(takes, adds, change_mm3):
            return takes, adds
        changes = iter(_in_turn(body, grown, tools))
        adds = tuple(replace(each, volume=next(changes)) for each in adds)
        takes = tuple(replace(each, volume=next(changes).scaled(-1.0)) for each in takes)
        if _adds_up(takes, adds, change_mm3):
            return takes, adds
    return None


def _adds_up(takes: Sequence[EachTaken], adds: Sequence[EachTaken], change_mm3: float) -> bool:
    came, went = (sum(each.volume.mass_g for each in some) for some in (adds, takes))
    return bool(abs(came - went - change_mm3) <= ADD_UP * (abs(came) + abs(went)))


def _in_turn(body: Any, grown: Sequence[Any], tools: Sequence[Any]) -> list[Moments]:
    """Return the change of the body's moments by each tool, one after another.

    Where edges lie off their faces, as in the corpus's forging (18 faces, by 0.2 mm), a body's volume is not
    the sum of its parts'.
    """
    measured = [properties(body)]
    for shape in grown:
        body = fused([body, shape])
        measured.append(properties(body))
    for shape in tools:
        body = cut(body, [shape])
        measured.append(properties(body))
    return [after - before for before, after in pairwise(measured)]


def _apart(shapes: Sequence[Any]) -> list[Any]:
    """Return bodies, each without the volume of the earlier ones."""
    boxes = [bounds_mm(shape) for shape in shapes]
    parts = []
    for number, shape in enumerate(shapes):
        low, high = boxes[number]
        before = [
            shapes[k] for k in range(number) if not (np.any(boxes[k][0] > high) or np.any(low > boxes[k][1]))
        ]
        parts.append(cut(shape, before) if before else shape)
    return parts


def _measured(tool: Tool, part: Any, body: Any, lift_mm: float) -> EachTaken:
    volume = properties(part)
    if isinstance(tool, Drilling):
        placed = along_old_hole(tool, body)
        return EachTaken(volume, hole=None if placed is tool else placed.placement)
    if isinstance(tool, Lowering):
        outward = tool.placement[:3, 2]
        height = tool.low_mm + float(tool.placement[:3, 3] @ outward)
        return replace(_on_plane(part, volume, -outward, -height), lift_mm=lift_mm)
    if isinstance(tool, Raising):
        if not tool.surfaces:
            return EachTaken(volume)
        old = next(face for face in surfaces(body) if face.number == tool.surfaces[0])
        assert isinstance(old, PlaneFace)  # metal grows on no other
        return _on_plane(part, volume, tool.normal, float(old.centroid_mm @ tool.normal) + tool.rise_mm)
    return EachTaken(volume)


def _on_plane(part: Any, volume: Moments, normal: Array, height_mm: float) -> EachTaken:
    """Return the moments of a part, and those and the loops of its faces on a plane of an outward normal."""
    every = explored(part, "FACE")
    floor = [
        every[face.number]
        for face in surfaces(part)
        if isinstance(face, PlaneFace)
        and float(face.normal @ normal) > SAME_NORMAL
        and abs(float(face.centroid_mm @ normal) - height_mm) < SAME_HEIGHT_MM
    ]
    floor.sort(key=lambda face: -area_properties(face).mass_g)
    moments = sum((area_properties(face) for face in floor), Moments.zero())
    return EachTaken(volume, moments, tuple(loop for face in floor for loop in face_loops(face)))


def face_loops(face: Any) -> list[Loop]:
    """Return the outline of a plane face, its outer loop first."""
    from OCP.BRepTools import BRepTools
    from OCP.BRepTools import BRepTools_WireExplorer as Walk
    from OCP.TopoDS import TopoDS

    outer = BRepTools.OuterWire_s(TopoDS.Face(face))
    wires = sorted(explored(face, "WIRE"), key=lambda wire: not wire.IsSame(outer))
    loops = []
    for wire in wires:
        edges: list[Edge] = []
        walk = Walk(TopoDS.Wire(wire), TopoDS.Face(face))
        while walk.More():
            edges += _edges(walk.Current())
            walk.Next()
        loops.append(tuple(edges))
    return loops


def _edges(edge: Any) -> list[Edge]:
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_CurveType
    from OCP.TopAbs import TopAbs_Orientation

    curve = BRepAdaptor_Curve(edge)
    first, last = curve.FirstParameter(), curve.LastParameter()
    if edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        first, last = last, first
    kind = curve.GetType()
    start, end = as_array(curve.Value(first)), as_array(curve.Value(last))
    if kind == GeomAbs_CurveType.GeomAbs_Line:
        return [Edge(start, end)]
    if kind == GeomAbs_CurveType.GeomAbs_Circle:
        circle = curve.Circle()
        axis = circle.Axis().Direction()
        return [Edge(start, end, as_array(circle.Location()), as_array(axis), last - first)]
    points = [
        as_array(curve.Value(first + (last - first) * k / CHORDS_PER_EDGE))
        for k in range(CHORDS_PER_EDGE + 1)
    ]
    return [Edge(*pair) for pair in pairwise(points)]


def flat_loops(loops: Sequence[Loop], frame: Array) -> tuple[Outline, ...]:
    """Return loops as drawn in x and y of a frame (4, 4): counter-clockwise the first, its islands clockwise.

    All loops of a face run with its metal on one side, which is the right one as seen from its back.
    """
    outlines = [tuple(_flat(edge, frame) for edge in loop) for loop in loops]
    if not outlines or outline_area_mm2(outlines[0]) > 0.0:
        return tuple(outlines)
    return tuple(tuple(reversed_outline(loop)) for loop in outlines)


def _flat(edge: Edge, frame: Array) -> Line | Arc:
    def at(point: Array) -> tuple[float, float]:
        x, y, _ = frame[:3, :3] @ point + frame[:3, 3]
        return float(x), float(y)

    if edge.centre is None or edge.axis is None:
        return Line(at(edge.start), at(edge.end))
    centre, start = at(edge.centre), at(edge.start)
    radius = float(np.linalg.norm(edge.start - edge.centre))
    begin = math.atan2(start[1] - centre[1], start[0] - centre[0])
    sense = 1.0 if float((frame[:3, :3] @ edge.axis)[2]) > 0.0 else -1.0
    return Arc(centre, radius, begin, begin + sense * edge.swept_rad)
