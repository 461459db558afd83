"""Shapes built with the kernel, and cuts in them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from autobalance.errors import FormatError, SolidError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.cad import kernel
from autobalance.solid.cad.files import write_step
from autobalance.solid.cad.tessellation import CylinderFace, PlaneFace, bounds_mm, surfaces
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
from autobalance.solid.csg.tool import Drilling, Lowering, Raising, Tool
from autobalance.types import Array
from autobalance.units import MM_PER
from autobalance.value_classes import dataclass

# Construction of the CAD kernel's bodies from exact descriptions of shapes.


ONE_POINT_MM = 1e-6
"""Ends of edges nearer than this are one corner: closed forms of one point round differently."""

Point3 = tuple[float, float, float]


def built(shape: Shape) -> Any:
    """Return the kernel's body of a shape, with exact surfaces."""
    if isinstance(shape, Joined):
        return kernel.fused([built(part) for part in shape.parts])
    if isinstance(shape, Without):
        return kernel.cut(built(shape.body), [built(tool) for tool in shape.tools])
    if isinstance(shape, Placed):
        return moved(built(shape.shape), shape.placement)
    if isinstance(shape, Drafted):
        low, high = sorted((shape.face, shape.top))
        return kernel.cut(built(Prism(shape.outline, low, high)), [built(tool) for tool in wedges(shape)])
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


# Machining in the CAD kernel: tools add and remove metal, all with exact surfaces.


CLEAR_SHARES = (1e-7, 1e-6, 1e-5, 1e-4)
"""Heights over a face at which the metal that is on it is sectioned, as shares of the part's diagonal:
higher where the kernel cannot make a sound cut of the first."""
AS_DRAWN = 1e-6
"""Largest share at which cuts are as planned: a fillet's foot is a hundredth of a millimetre wider."""

SAME_VOLUME = 1e-9
"""Share of the volume by which merging faces may change it: rounding."""
SAME_HOLE = 0.02
"""Difference of axis and radius, as a share of the radius, within which a drill continues a hole ..."""
DIRECTION_TOLERANCE_RAD = 5e-3
"""... and of the directions [rad]."""
SAME_NORMAL = 1.0 - 1e-9
SAME_HEIGHT_MM = 1e-5
"""A face of the metal that a tool took is the tool's own floor when it lies this near to it."""
SAME_DRILL = 1e-3
"""Radii that differ by less, as a share, are one."""


@dataclass(frozen=True, eq=False)
class MetalTaken:
    """Metal really taken by a tool: moments of the removed volume, and of the new face, density 1."""

    volume: Moments
    floor: Moments


@dataclass(frozen=True, eq=False)
class Machined:
    """A body after machining.

    ``taken`` has an entry for each removing tool: None where the tool takes the metal of its drawing. A face
    that could only be lowered farther from the metal on it, up in the fillets, loses more than that.
    """

    body: Any
    taken: tuple[MetalTaken | None, ...]


def machined(
    body: Any, removed: Sequence[Tool], added: Sequence[Tool], shares: Sequence[float] | None = None
) -> Machined:
    """Return a body with metal added, then other metal removed, as ``clear_shares`` has it.

    Raises
    ------
    SolidError
        If the kernel makes no sound solid of it, or it falls apart.
    """
    low, high = bounds_mm(body)
    size = float(np.linalg.norm(high - low))
    bodies = len(kernel.explored(body, "SOLID"))
    solids = 0
    for share in clear_shares(removed, shares):
        grown = [tool_shape(tool, body, share * size) for tool in added]
        tools = [tool_shape(tool, body, share * size) for tool in removed]
        whole = kernel.fused([body, *grown])
        result = kernel.cut(whole, tools)
        solids = len(kernel.explored(result, "SOLID"))
        if solids == bodies and kernel.is_valid(result):
            pairs = zip(removed, tools, strict=True)
            as_drawn = share <= AS_DRAWN
            faces_taken = tuple(None if as_drawn else _taken(tool, whole, shape) for tool, shape in pairs)
            return Machined(_seamless(result, body), faces_taken)
    if solids != bodies:
        raise SolidError(f"cut as planned, the part falls into {solids} solids; expected {bodies}")
    raise SolidError("the CAD kernel finds fault with the solid after the cut")


def _taken(tool: Tool, body: Any, shape: Any) -> MetalTaken | None:
    """Return the metal that a tool's shape takes of a body, None where that does not depend on the body."""
    if not isinstance(tool, Lowering):
        return None
    metal = kernel.common(body, shape)
    up = tool.placement[:3, 2]
    low_mm = tool.low_mm + float(tool.placement[:3, 3] @ up)
    every = kernel.explored(metal, "FACE")
    floor = [
        kernel.area_properties(every[face.number])
        for face in surfaces(metal)
        if isinstance(face, PlaneFace)
        and float(face.normal @ up) < -SAME_NORMAL
        and abs(float(face.centroid_mm @ up) - low_mm) < SAME_HEIGHT_MM
    ]
    return MetalTaken(kernel.properties(metal), sum(floor, Moments.zero()))


def _seamless(result: Any, before: Any) -> Any:
    """Return a cut body without seams where faces of the tools continue the body's own.

    A body that had such seams before keeps all: its owner may want them.
    """
    if len(kernel.explored(kernel.unified(before), "FACE")) < len(kernel.explored(before, "FACE")):
        return result
    merged = kernel.unified(result)
    volume = kernel.properties(result).mass_g
    same = abs(kernel.properties(merged).mass_g - volume) < SAME_VOLUME * volume
    sound = (
        same
        and kernel.is_valid(merged)
        and len(kernel.explored(merged, "SOLID")) == len(kernel.explored(result, "SOLID"))
    )
    return merged if sound else result


def clear_shares(removed: Sequence[Tool], shares: Sequence[float] | None = None) -> Sequence[float]:
    """Return the shares to try, else `CLEAR_SHARES`: one if no tool lowers a face, as all give the same."""
    shares = CLEAR_SHARES if shares is None else shares
    return shares if any(isinstance(tool, Lowering) for tool in removed) else shares[:1]


def tool_shape(tool: Tool, body: Any, clear_mm: float) -> Any:
    """Return the kernel's body of a tool; metal that is on a face is sectioned ``clear_mm`` over it."""
    if isinstance(tool, Lowering):
        return _lowering(tool, body, clear_mm)
    if isinstance(tool, Raising):
        return _raising(tool, body)
    if isinstance(tool, Drilling):
        return built(along_old_hole(tool, body).shape)
    return built(tool)


def along_old_hole(tool: Drilling, body: Any) -> Drilling:
    """Return a drill moved exactly onto the axis of the hole that it continues, if there is one."""
    for face in surfaces(body):
        if isinstance(face, CylinderFace) and face.hollow:
            drilling = _in_hole(tool, face)
            if drilling is not None:
                return drilling
    return tool


def _in_hole(tool: Drilling, face: CylinderFace) -> Drilling | None:
    down, entry, slack = tool.placement[:3, 2], tool.placement[:3, 3], SAME_HOLE * tool.radius_mm
    if (
        abs(face.radius_mm - tool.radius_mm) > slack
        or np.linalg.norm(np.cross(face.axis, down)) > DIRECTION_TOLERANCE_RAD
    ):
        return None
    axis = face.axis if float(face.axis @ down) > 0.0 else -face.axis
    start = face.point_mm + float((entry - face.point_mm) @ axis) * axis
    ends = [float((face.point_mm + at * face.axis - start) @ axis) for at in (face.low_mm, face.high_mm)]
    if np.linalg.norm(start - entry) > slack or min(ends) > tool.shoulder_mm or max(ends) < tool.top_mm:
        return None
    x = tool.placement[:3, 0] - float(tool.placement[:3, 0] @ axis) * axis
    x /= np.linalg.norm(x)
    placement = np.eye(4)
    placement[:3] = np.column_stack([x, np.cross(axis, x), axis, start])
    same = abs(face.radius_mm - tool.radius_mm) < SAME_DRILL * tool.radius_mm
    return replace(tool, placement=placement, radius_mm=face.radius_mm if same else tool.radius_mm)


def _lowering(tool: Lowering, body: Any, clear_mm: float) -> Any:
    """Return the prism over the new plane, without the metal that is on the old one."""
    top = tool.face_mm + clear_mm
    room = moved(built(Prism(tool.outline, tool.low_mm, top)), tool.placement)
    keep = [moved(built(spared), tool.placement) for spared in tool.spared]
    plane = moved(plane_face(tool.outline, (0.0, 0.0, top), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)), tool.placement)
    up = tool.placement[:3, 2]
    seed = tool.placement[:3, :3] @ np.array([*tool.seed, top]) + tool.placement[:3, 3]
    for footprint in kernel.explored(kernel.common(plane, body), "FACE"):
        outer, holes = _outlines(footprint, seed)
        pillar, *wells = [
            drawn_out(moved(face, _shift(up)), -(top - tool.low_mm + 2.0) * up) for face in (outer, *holes)
        ]
        keep.append(kernel.cut(pillar, wells))
    part = kernel.cut(room, keep)
    return part if tool.within is None else kernel.common(part, built(tool.within))


def _outlines(footprint: Any, seed: Array) -> tuple[Any, list[Any]]:
    """Return a plane face with its holes filled, and the holes, as faces, that contain a point (3,).

    The cut goes into those; all other holes are drillings in the metal that is on the face.
    """
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepTools import BRepTools
    from OCP.TopoDS import TopoDS

    face = TopoDS.Face(footprint)
    outer, plane = BRepTools.OuterWire_s(face), BRepAdaptor_Surface(face).Plane()
    inner = [wire for wire in kernel.explored(face, "WIRE") if not wire.IsSame(outer)]
    holes = [BRepBuilderAPI_MakeFace(plane, TopoDS.Wire(wire)).Face() for wire in inner]
    around = [hole for hole in holes if _is_inside(hole, seed)]
    return BRepBuilderAPI_MakeFace(plane, outer).Face(), around


def _is_inside(face: Any, point: Array) -> bool:
    from OCP.BRepClass import BRepClass_FaceClassifier
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_State

    classified = BRepClass_FaceClassifier(face, gp_Pnt(*(float(value) for value in point)), 1e-7)
    return bool(classified.State() == TopAbs_State.TopAbs_IN)


def _raising(tool: Raising, body: Any) -> Any:
    if not tool.surfaces:
        raise SolidError("a face for added metal is not a separate plane in the solid")
    faces = kernel.explored(body, "FACE")
    grown = kernel.fused([drawn_out(faces[number], tool.rise_mm * tool.normal) for number in tool.surfaces])
    return grown if tool.within is None else kernel.common(grown, built(tool.within))


def drawn_out(face: Any, along: Array) -> Any:
    """Return the body that a face sweeps along a vector (3,)."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Vec

    return BRepPrimAPI_MakePrism(face, gp_Vec(*(float(value) for value in along)), True).Shape()


def _shift(by: Array) -> Array:
    motion = np.eye(4)
    motion[:3, 3] = by
    return motion


# Shapes of the CAD kernel that a caller holds in memory, and the files that stand for them.


EXPECTED = (
    "an OCP TopoDS_Shape, an object whose .wrapped is one (build123d, CadQuery), "
    "or the bytes of a STEP or BREP file"
)


def step_of_shape(source: Any, unit: str) -> bytes:
    """Return the STEP file, in ``unit``, of a shape whose numbers are in ``unit``.

    Parameters
    ----------
    source : TopoDS_Shape, or an object that wraps one
        Of a CadQuery ``Workplane``, the shape on its stack.
    unit : str
        mm, cm, m or inch.

    Raises
    ------
    FormatError
        If it is not a shape of the kernel, or the kernel is not installed or of another generation.
    """
    kernel.require_kernel("a shape in memory")
    from OCP.TopoDS import TopoDS_Shape

    shape = source
    if not isinstance(shape, TopoDS_Shape) and callable(getattr(shape, "val", None)):
        shape = shape.val()  # a Workplane of CadQuery
    shape = getattr(shape, "wrapped", shape)
    if not isinstance(shape, TopoDS_Shape) or shape.IsNull():
        kind = "an empty shape" if isinstance(shape, TopoDS_Shape) else type(source).__name__
        raise FormatError(f"shape: found {kind}; expected {EXPECTED}")
    return write_step(kernel.scaled(shape, MM_PER[unit]), unit, str(getattr(source, "label", "") or "crank"))


def nothing() -> Any:
    """Return an empty shape of the kernel.

    Raises
    ------
    FormatError
        If the kernel is not installed.
    """
    kernel.require_kernel("a shape in memory")
    return kernel.compound([])


def shape_of(drawn: Shape, motion: Array) -> Any:
    """Return an exact description as a shape of the kernel, moved rigidly by a matrix (4, 4).

    Raises
    ------
    FormatError
        If the kernel is not installed.
    """
    kernel.require_kernel("a shape in memory")
    return moved(built(drawn), motion)
