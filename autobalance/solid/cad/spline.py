"""Bodies whose walls are true B-spline surfaces, and solids of planar facets, in the CAD kernel."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalance.errors import SolidError
from autobalance.solid.cad import kernel
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.build import moved
from autobalance.solid.cad.files import write_step
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.value_classes import dataclass

SAME_MM = 1e-9


@dataclass(frozen=True, eq=False)
class SplineBody:
    """A body between two heights: along an inner outline, out, along a clamped spline, and back in.

    Attributes
    ----------
    low_mm, high_mm : (n, 2) float
        Control points of the spline at the lower and the higher end; walls are ruled between them.
    knots : (n + degree + 1,) float
    degree : int
    inner_mm : (m, 2) float
        The inner outline, from where the spline begins to where it ends.
    arc : bool
        Whether the inner outline is one arc about the origin; else straight between its points.
    z_mm : (float, float)
    corner_radius_mm : float
        Of the edges at both ends of the spline.
    openings : sequence of ((3,), (3,), float)
        Round holes: from, to and diameter.
    """

    low_mm: Array
    high_mm: Array
    knots: Array
    degree: int
    inner_mm: Array
    arc: bool
    z_mm: tuple[float, float]
    corner_radius_mm: float = 0.0
    openings: Sequence[tuple[Array, Array, float]] = ()


def spline_solid(body: SplineBody) -> ExactSolid:
    """Return the body with exact surfaces.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed.
    SolidError
        If the kernel cannot build it.
    """
    kernel.require_kernel()
    return ExactSolid.of(kernel.cut(_walls(body), [_cylinder(*opening) for opening in body.openings]))


def with_new_metal(
    crank: ExactSolid, sectors: Sequence[Any], bodies: Sequence[SplineBody], frame: Array
) -> ExactSolid:
    """Return a crank with its free metal taken away and bodies put in its place.

    ``sectors`` are the metal taken away, kernel bodies in the rotor frame as ``bodies`` are; ``frame`` (4, 4)
    takes them to the crank's own.

    Raises
    ------
    SolidError
        If the kernel cannot join them.
    """
    removed = [moved(sector, frame) for sector in sectors]
    added = [moved(spline_solid(body).body, frame) for body in bodies]
    return ExactSolid.of(kernel.unified(kernel.fused([kernel.cut(crank.body, removed), *added])))


def step_beside(parts: Sequence[ExactSolid], bodies: Sequence[SplineBody], frame: Array, unit: str) -> bytes:
    """Return a STEP file of solids and, beside them, bodies that ``frame`` (4, 4) takes to their place."""
    shapes = [moved(spline_solid(body).body, frame) for body in bodies]
    return write_step(kernel.compound([*(each.body for each in parts), *shapes]), unit, "crank")


def faceted_solid(mesh: Mesh) -> ExactSolid:
    """Return one connected body of planar faces, those in one plane merged.

    Raises
    ------
    SolidError
        If the kernel finds fault with it.
    """
    kernel.require_kernel()
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeShapeOnMesh, BRepBuilderAPI_MakeSolid
    from OCP.gp import gp_Pnt
    from OCP.Poly import Poly_Triangle, Poly_Triangulation
    from OCP.TopoDS import TopoDS_Shell

    raw = Poly_Triangulation(len(mesh.vertices), len(mesh.triangles), False, False)
    for number, point in enumerate(mesh.vertices.tolist(), 1):
        raw.SetNode(number, gp_Pnt(*point))
    for number, corners in enumerate((mesh.triangles + 1).tolist(), 1):
        raw.SetTriangle(number, Poly_Triangle(*corners))
    maker = BRepBuilderAPI_MakeShapeOnMesh(raw)
    with kernel.kernel_failures(
        "faces of these triangles"
    ):  # of needles, where a coarse crank was cut: no plane
        maker.Build()
        shell, builder = TopoDS_Shell(), BRep_Builder()
        builder.MakeShell(shell)
        for face in kernel.explored(maker.Shape(), "FACE"):
            builder.Add(shell, face)
        shell.Closed(True)
        return ExactSolid.of(kernel.unified(BRepBuilderAPI_MakeSolid(shell).Solid()))


def sector_body(inner_mm: Array, arc: bool, far_mm: float, z_mm: tuple[float, float]) -> Any:
    """Return everything of a sector beyond an inner outline (m, 2), as a kernel's body."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Vec

    first, last = (point * (far_mm / np.linalg.norm(point)) for point in (inner_mm[0], inner_mm[-1]))
    middle = inner_mm[len(inner_mm) // 2]
    outer = [first, middle * (far_mm / np.linalg.norm(middle)), last]
    edges = [
        _line(inner_mm[0], first, z_mm[0]),
        *(_line(a, b, z_mm[0]) for a, b in itertools.pairwise(outer)),
        _line(last, inner_mm[-1], z_mm[0]),
        *_inner(inner_mm, arc, z_mm[0]),
    ]
    return BRepPrimAPI_MakePrism(_face(edges), gp_Vec(0.0, 0.0, z_mm[1] - z_mm[0])).Shape()


# --- edges, wires and walls ---------------------------------------------------------------------------------


def _walls(body: SplineBody) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Vec

    low, high = body.z_mm
    straight = np.abs(body.low_mm - body.high_mm).max() < SAME_MM
    whole = body.high_mm if np.linalg.norm(body.high_mm) > np.linalg.norm(body.low_mm) else body.low_mm
    prism = BRepPrimAPI_MakePrism(_face(_edges(body, whole, low)), gp_Vec(0.0, 0.0, high - low)).Shape()
    if body.corner_radius_mm > 0.0:
        prism = _filleted(prism, body, whole)
    if straight:
        return prism
    ruled = _ruled(_edges(body, body.low_mm, low), _edges(body, body.high_mm, high))
    return kernel.common(ruled, prism) if body.corner_radius_mm > 0.0 else ruled


def _edges(body: SplineBody, control_mm: Array, z_mm: float) -> list[Any]:
    return [
        _line(body.inner_mm[0], control_mm[0], z_mm),
        _spline(control_mm, body.knots, body.degree, z_mm),
        _line(control_mm[-1], body.inner_mm[-1], z_mm),
        *_inner(body.inner_mm, body.arc, z_mm),
    ]


def _inner(points_mm: Array, arc: bool, z_mm: float) -> list[Any]:
    """Return the edges of an inner outline, from its last point to its first."""
    if not arc:
        back = points_mm[::-1]
        return [_line(a, b, z_mm) for a, b in itertools.pairwise(back)]
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pnt

    radius = float(np.linalg.norm(points_mm[0]))
    circle = gp_Circ(gp_Ax2(gp_Pnt(0.0, 0.0, z_mm), gp_Dir(0.0, 0.0, 1.0)), radius)
    first = math.atan2(points_mm[0][1], points_mm[0][0])
    around = (math.atan2(points_mm[-1][1], points_mm[-1][0]) - first) % math.tau
    return [BRepBuilderAPI_MakeEdge(circle, first, first + around).Edge()]


def _line(start: Array, end: Array, z_mm: float) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.gp import gp_Pnt

    return BRepBuilderAPI_MakeEdge(
        gp_Pnt(float(start[0]), float(start[1]), z_mm), gp_Pnt(float(end[0]), float(end[1]), z_mm)
    ).Edge()


def _spline(control_mm: Array, knots: Array, degree: int, z_mm: float) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int
    from OCP.Geom import Geom_BSplineCurve
    from OCP.gp import gp_Pnt

    places, counts = np.unique(knots, return_counts=True)
    poles = Array1_gp_Pnt(1, len(control_mm))
    for number, (x, y) in enumerate(control_mm.tolist(), 1):
        poles.SetValue(number, gp_Pnt(x, y, z_mm))
    values, multiplicities = Array1_double(1, len(places)), Array1_int(1, len(places))
    for number, (place, count) in enumerate(zip(places.tolist(), counts.tolist(), strict=True), 1):
        values.SetValue(number, place)
        multiplicities.SetValue(number, count)
    return BRepBuilderAPI_MakeEdge(Geom_BSplineCurve(poles, values, multiplicities, degree)).Edge()


def _wire(edges: Sequence[Any]) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeWire

    maker = BRepBuilderAPI_MakeWire()
    for edge in edges:
        maker.Add(edge)
    if not maker.IsDone():
        raise SolidError("the CAD kernel could not close an outline")
    return maker.Wire()


def _face(edges: Sequence[Any]) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace

    return BRepBuilderAPI_MakeFace(_wire(edges), True).Face()


def _ruled(low: Sequence[Any], high: Sequence[Any]) -> Any:
    from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections

    maker = BRepOffsetAPI_ThruSections(True, True)
    maker.CheckCompatibility(False)
    maker.AddWire(_wire(low))
    maker.AddWire(_wire(high))
    maker.Build()
    return maker.Shape()


def _filleted(prism: Any, body: SplineBody, control_mm: Array) -> Any:
    """Return a prism with the upright edges at both ends of its spline rounded."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.TopoDS import TopoDS

    maker = BRepFilletAPI_MakeFillet(prism)
    for edge in kernel.explored(prism, "EDGE"):
        curve = BRepAdaptor_Curve(TopoDS.Edge(edge))
        ends = [curve.Value(curve.FirstParameter()), curve.Value(curve.LastParameter())]
        at = np.array([ends[0].X(), ends[0].Y()])
        upright = abs(ends[0].Z() - ends[1].Z()) > SAME_MM
        if upright and min(np.linalg.norm(control_mm[[0, -1]] - at, axis=1)) < 1e-6:
            maker.Add(body.corner_radius_mm, TopoDS.Edge(edge))
    maker.Build()
    if not maker.IsDone() or not kernel.is_valid(maker.Shape()):
        raise SolidError(f"the CAD kernel could not round corners by {body.corner_radius_mm:g} mm")
    return maker.Shape()


def _cylinder(start: Array, end: Array, diameter_mm: float) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    along = np.asarray(end) - np.asarray(start)
    axes = gp_Ax2(gp_Pnt(*map(float, start)), gp_Dir(*map(float, along)))
    return BRepPrimAPI_MakeCylinder(axes, 0.5 * diameter_mm, float(np.linalg.norm(along))).Shape()
