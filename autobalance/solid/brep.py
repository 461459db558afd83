"""Shapes with exact surfaces through the CAD kernel, and STEP files of them; needs the extra ``step``."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from autobalance.errors import FormatError, SolidError
from autobalance.rotor.moments import Moments
from autobalance.solid.mesh import Array
from autobalance.solid.shape import (
    Arc,
    Bar,
    Drafted,
    Joined,
    Line,
    Outline,
    Placed,
    Prism,
    Shape,
    Turned,
    Without,
    wedges,
)

ONE_POINT_MM = 1e-6
"""Ends of edges nearer than this are one corner: closed forms of one point round differently."""

Point3 = tuple[float, float, float]


def has_kernel() -> bool:
    """Tell whether the CAD kernel is installed."""
    from importlib.util import find_spec

    return find_spec("OCP") is not None


class ExactSolid:
    """A body bounded by exact surfaces: planes, cylinders, cones, tori.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed.
    SolidError
        If the kernel cannot build the shape, or what it built is not valid.
    """

    def __init__(self, shape: Shape) -> None:
        """Build a shape exactly."""
        if not has_kernel():
            raise FormatError(
                "STEP needs the CAD kernel, which is not installed: pip install 'autobalance[step]'"
            )
        self._body = _checked(_unified(_exact(shape)))

    @property
    def volume_mm3(self) -> float:
        """Volume [mm³]."""
        return self.moments(1.0).mass_g

    def moments(self, density_g_mm3: float) -> Moments:
        """Return the mass moments about the origin, from the exact surfaces."""
        return properties(self._body).scaled(density_g_mm3)

    def face_kinds(self) -> dict[str, int]:
        """Count the faces by their surface: ``plane``, ``cylinder``, ``cone``, ``torus`` and others."""
        from OCP.BRepAdaptor import BRepAdaptor_Surface
        from OCP.TopAbs import TopAbs_ShapeEnum
        from OCP.TopExp import TopExp_Explorer
        from OCP.TopoDS import TopoDS

        counts: dict[str, int] = {}
        explorer = TopExp_Explorer(self._body, TopAbs_ShapeEnum.TopAbs_FACE)
        while explorer.More():
            surface = BRepAdaptor_Surface(TopoDS.Face(explorer.Current()))
            kind = str(surface.GetType()).rpartition("_")[2].lower()
            counts[kind] = counts.get(kind, 0) + 1
            explorer.Next()
        return counts

    def step(self) -> bytes:
        """Return a STEP file of the body, in mm."""
        from OCP.IFSelect import IFSelect_ReturnStatus
        from OCP.Interface import Interface_Static
        from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

        silence()
        writer = STEPControl_Writer()
        Interface_Static.SetCVal_s("write.step.unit", "MM")
        writer.Transfer(self._body, STEPControl_StepModelType.STEPControl_AsIs)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "crank.step"
            if writer.Write(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
                raise SolidError("the CAD kernel could not write the STEP file")
            return path.read_bytes()


def properties(body: Any) -> Moments:
    """Return the moments of a kernel's body of density 1 about the origin, from its exact surfaces."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    found = GProp_GProps()
    BRepGProp.VolumeProperties_s(body, found, True)
    volume, centre, matrix = found.Mass(), found.CentreOfMass(), found.MatrixOfInertia()
    middle = np.array([centre.X(), centre.Y(), centre.Z()])
    inertia = np.array([[matrix.Value(i, j) for j in (1, 2, 3)] for i in (1, 2, 3)])
    about_centre = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    second = about_centre + volume * np.outer(middle, middle)
    return Moments(volume, volume * middle, second)


def silence() -> None:
    """Keep the kernel's statistics off standard output."""
    from OCP.Message import Message, Message_PrinterOStream

    Message.DefaultMessenger_s().RemovePrinters(Message_PrinterOStream.get_type_descriptor_s())


def _checked(body: Any) -> Any:
    from OCP.BRepCheck import BRepCheck_Analyzer

    if body.IsNull() or not BRepCheck_Analyzer(body).IsValid():
        raise SolidError("the CAD kernel could not build the shape exactly")
    return body


def _unified(body: Any) -> Any:
    """Merge faces and edges that lie on one surface or curve."""
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

    tool = ShapeUpgrade_UnifySameDomain(body, True, True, False)
    tool.Build()
    return tool.Shape()


def _exact(shape: Shape) -> Any:
    if isinstance(shape, Joined):
        return _fused([_exact(part) for part in shape.parts])
    if isinstance(shape, Without):
        return _cut(_exact(shape.body), [_exact(tool) for tool in shape.tools])
    if isinstance(shape, Placed):
        return _placed(_exact(shape.shape), shape.placement)
    if isinstance(shape, Drafted):
        low, high = sorted((shape.face, shape.top))
        return _cut(_exact(Prism(shape.outline, low, high)), [_exact(tool) for tool in wedges(shape)])
    return _primitive(shape)


def _primitive(shape: Prism | Turned | Bar) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism, BRepPrimAPI_MakeRevol
    from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Vec

    if isinstance(shape, Prism):
        face = _face(shape.outline, (0.0, 0.0, shape.z_low), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
        return BRepPrimAPI_MakePrism(face, gp_Vec(0.0, 0.0, shape.z_high - shape.z_low)).Shape()
    if isinstance(shape, Turned):
        origin = (*shape.centre, 0.0)
        face = _face(shape.profile, origin, (0.0, -1.0, 0.0), (1.0, 0.0, 0.0))
        return BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(*origin), gp_Dir(0.0, 0.0, 1.0))).Shape()
    along = np.array(shape.end) - np.array(shape.start)
    axes = gp_Ax2(gp_Pnt(*shape.start), gp_Dir(*map(float, along)))
    return BRepPrimAPI_MakeCylinder(axes, shape.diameter / 2.0, float(np.linalg.norm(along))).Shape()


def _face(outline: Outline, origin: Point3, normal: Point3, x: Point3) -> Any:
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


def _placed(body: Any, placement: Array) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.gp import gp_Trsf

    motion = gp_Trsf()
    motion.SetValues(*(float(value) for value in placement[:3].ravel()))
    return BRepBuilderAPI_Transform(body, motion, True).Shape()


def _listed(bodies: Sequence[Any]) -> Any:
    from OCP.collections import List_TopoDS_Shape

    found = List_TopoDS_Shape()
    for body in bodies:
        found.Append(body)
    return found


def _fused(bodies: Sequence[Any]) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

    if len(bodies) == 1:
        return bodies[0]
    return _boolean(BRepAlgoAPI_Fuse(), bodies[:1], bodies[1:])


def _cut(body: Any, tools: Sequence[Any]) -> Any:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    return _boolean(BRepAlgoAPI_Cut(), [body], tools)


def _boolean(operation: Any, arguments: Sequence[Any], tools: Sequence[Any]) -> Any:
    operation.SetArguments(_listed(arguments))
    operation.SetTools(_listed(tools))
    operation.SetRunParallel(False)
    operation.Build()
    if not operation.IsDone():
        raise SolidError("the CAD kernel could not join or cut two shapes")
    return operation.Shape()
