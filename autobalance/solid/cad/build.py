"""Construction of the CAD kernel's bodies from exact descriptions of shapes."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from autobalance.errors import SolidError
from autobalance.solid.cad.kernel import cut, fused
from autobalance.solid.csg.shape import (
    Arc,
    Bar,
    Drafted,
    Joined,
    Line,
    Outline,
    Placed,
    Prism,
    Revolved,
    Shape,
    Without,
    wedges,
)
from autobalance.types import Array

ONE_POINT_MM = 1e-6
"""Ends of edges nearer than this are one corner: closed forms of one point round differently."""

Point3 = tuple[float, float, float]


def built(shape: Shape) -> Any:
    """Return the kernel's body of a shape, with exact surfaces."""
    if isinstance(shape, Joined):
        return fused([built(part) for part in shape.parts])
    if isinstance(shape, Without):
        return cut(built(shape.body), [built(tool) for tool in shape.tools])
    if isinstance(shape, Placed):
        return moved(built(shape.shape), shape.placement)
    if isinstance(shape, Drafted):
        low, high = sorted((shape.face, shape.top))
        return cut(built(Prism(shape.outline, low, high)), [built(tool) for tool in wedges(shape)])
    return _primitive(shape)


def _primitive(shape: Prism | Revolved | Bar) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism, BRepPrimAPI_MakeRevol
    from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Vec

    if isinstance(shape, Prism):
        face = plane_face(shape.outline, (0.0, 0.0, shape.z_low), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
        return BRepPrimAPI_MakePrism(face, gp_Vec(0.0, 0.0, shape.z_high - shape.z_low)).Shape()
    if isinstance(shape, Revolved):
        origin = (*shape.centre, 0.0)
        face = plane_face(shape.profile, origin, (0.0, -1.0, 0.0), (1.0, 0.0, 0.0))
        return BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(*origin), gp_Dir(0.0, 0.0, 1.0))).Shape()
    along = np.array(shape.end) - np.array(shape.start)
    axes = gp_Ax2(gp_Pnt(*shape.start), gp_Dir(*map(float, along)))
    return BRepPrimAPI_MakeCylinder(axes, shape.diameter / 2.0, float(np.linalg.norm(along))).Shape()


def plane_face(outline: Outline, origin: Point3, normal: Point3, x: Point3) -> Any:
    """Return the plane face inside an outline, drawn in the plane's own axes."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.gp import gp_Ax3, gp_Dir, gp_Pln, gp_Pnt

    axes = gp_Ax3(gp_Pnt(*origin), gp_Dir(*normal), gp_Dir(*x))
    for edge, following in pairwise([*outline, outline[0]]):
        if math.dist(edge.end, following.start) > ONE_POINT_MM:
            raise SolidError(f"an outline is open between {edge.end} and {following.start}")
    corners = [_vertex(axes, edge.start) for edge in outline]
    wire = BRepBuilderAPI_MakeWire()
    for number, edge in enumerate(outline):
        if isinstance(edge, Line) and math.dist(edge.start, edge.end) < ONE_POINT_MM:
            corners[(number + 1) % len(outline)] = corners[number]
            continue
        wire.Add(_edge(axes, edge, corners[number], corners[(number + 1) % len(outline)]))
    return BRepBuilderAPI_MakeFace(gp_Pln(axes), wire.Wire()).Face()


def _point(axes: Any, point: tuple[float, float]) -> Any:
    from OCP.gp import gp_Vec

    x, y = gp_Vec(axes.XDirection()), gp_Vec(axes.YDirection())
    return axes.Location().Translated(x.Multiplied(point[0]).Added(y.Multiplied(point[1])))


def _vertex(axes: Any, point: tuple[float, float]) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex

    vertex = BRepBuilderAPI_MakeVertex(_point(axes, point)).Vertex()
    BRep_Builder().UpdateVertex(vertex, ONE_POINT_MM)
    return vertex


def _edge(axes: Any, edge: Line | Arc, start: Any, end: Any) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.gp import gp_Ax2, gp_Circ, gp_Dir

    if isinstance(edge, Line):
        return BRepBuilderAPI_MakeEdge(start, end).Edge()
    x = gp_Dir(axes.XDirection().XYZ())
    circle = gp_Circ(gp_Ax2(_point(axes, edge.centre), axes.Direction(), x), edge.radius)
    if abs(edge.end_rad - edge.start_rad) > 2.0 * np.pi - 1e-12:
        return BRepBuilderAPI_MakeEdge(circle).Edge()
    if edge.end_rad > edge.start_rad:
        return BRepBuilderAPI_MakeEdge(circle, start, end).Edge()
    return BRepBuilderAPI_MakeEdge(circle, end, start).Edge()


def moved(body: Any, placement: Array) -> Any:
    """Return a body moved rigidly by a homogeneous matrix (4, 4)."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Trsf

    motion = gp_Trsf()
    motion.SetValues(*(float(value) for value in placement[:3].ravel()))
    return BRepBuilderAPI_Transform(body, motion, True).Shape()
