"""Triangles of shapes and of their surfaces."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from autobalance.solid.cad.kernel import explored
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Surfaces of an exact solid by which a crank's parts are recognised: planes and cylinders.


@dataclass(frozen=True, eq=False)
class PlaneFace:
    """A plane face: its number in the solid, outward unit normal (3,), area and centroid (3,) [mm]."""

    number: int
    normal: Array
    area_mm2: float
    centroid_mm: Array


@dataclass(frozen=True, eq=False)
class CylinderFace:
    """A cylindrical face.

    ``point_mm`` (3,) and ``axis`` (unit, (3,)) give the axis, on which the face reaches from ``low_mm`` to
    ``high_mm``; ``hollow`` is true of a hole. ``swept_rad`` is the angle that it spans.
    """

    number: int
    point_mm: Array
    axis: Array
    radius_mm: float
    low_mm: float
    high_mm: float
    hollow: bool
    area_mm2: float
    swept_rad: float


Surface = PlaneFace | CylinderFace


@dataclass(frozen=True, eq=False)
class Surfaces:
    """The plane and cylindrical faces of a solid, and the face that each triangle of its mesh belongs to.

    ``owner`` (m,) holds numbers of faces, also of faces that are neither plane nor cylindrical.
    """

    faces: tuple[Surface, ...]
    owner: Indices

    @property
    def planes(self) -> tuple[PlaneFace, ...]:
        return tuple(face for face in self.faces if isinstance(face, PlaneFace))

    @property
    def cylinders(self) -> tuple[CylinderFace, ...]:
        return tuple(face for face in self.faces if isinstance(face, CylinderFace))


# Triangles of exact faces, and their surfaces by kind: planes, cylinders.


SAG_SHARE: Final = 2e-5
"""Largest distance of a triangle from the true surface, as a share of the diagonal."""
TURN_RAD: Final = 0.1
"""Largest angle between neighbouring triangles on one surface."""


@dataclass(frozen=True, eq=False)
class Facets:
    """Triangles of an exact solid.

    Attributes
    ----------
    points : (n, 3) float
        Corners [mm]; faces that meet have equal ones, each its own.
    triangles : (m, 3) int
        Outward.
    face : (m,) int
        Number of the face that each belongs to.
    """

    points: Array
    triangles: Indices
    face: Indices


def bounds_mm(body: Any) -> Array:
    """Return smallest and largest coordinates (2, 3) of a body [mm], with a little room."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.Add_s(body, box, False)
    low, high = box.CornerMin(), box.CornerMax()
    return np.array([[low.X(), low.Y(), low.Z()], [high.X(), high.Y(), high.Z()]])


@dataclass(frozen=True)
class Fineness:
    """Largest distance of a triangle from the surface as a share of the diagonal, and angle between two."""

    sag_share: float
    turn_rad: float

    @classmethod
    def usual(cls) -> Fineness:
        return cls(SAG_SHARE, TURN_RAD)


def tessellate(body: Any, fineness: Fineness | None = None) -> None:
    """Let the kernel put triangles on a body's faces if their triangles are coarser or missing."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh

    fineness = fineness or Fineness.usual()
    low, high = bounds_mm(body)
    sag_mm = fineness.sag_share * float(np.linalg.norm(high - low))
    BRepMesh_IncrementalMesh(body, sag_mm, False, fineness.turn_rad, False)


def drop_triangles(body: Any) -> None:
    from OCP.BRepTools import BRepTools

    BRepTools.Clean_s(body)


def facets(body: Any) -> Facets:
    """Return triangles of a body, face by face."""
    tessellate(body)
    points: list[Array] = []
    triangles: list[Indices] = []
    owners: list[Indices] = []
    count = 0
    for number, face in enumerate(explored(body, "FACE")):
        corners, numbers = _face_triangles(face)
        points.append(corners)
        triangles.append(numbers + count)
        owners.append(np.full(len(numbers), number))
        count += len(corners)
    return Facets(np.concatenate(points), np.concatenate(triangles), np.concatenate(owners))


def _face_triangles(face: Any) -> tuple[Array, Indices]:
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    place = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(TopoDS.Face(face), place)
    if mesh is None:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    corners = np.array([mesh.Node(number + 1).Coord() for number in range(mesh.NbNodes())])
    if not place.IsIdentity():
        motion = place.Transformation()
        matrix = np.array([[motion.Value(row, column) for column in (1, 2, 3, 4)] for row in (1, 2, 3)])
        x, y, z = corners.T[:, :, None]  # not by ``@``, whose rounding depends on how many corners there are
        corners = x * matrix[:, 0] + y * matrix[:, 1] + z * matrix[:, 2] + matrix[:, 3]
    numbers = np.array([mesh.Triangle(number + 1).Get() for number in range(mesh.NbTriangles())]) - 1
    inward = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    return corners, numbers[:, ::-1] if inward else numbers


def surface_kind(face: Any) -> str:
    """Return the kind of a face's surface: ``plane``, ``cylinder``, ``cone``, ``torus`` or another."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.TopoDS import TopoDS

    return str(BRepAdaptor_Surface(TopoDS.Face(face)).GetType()).rpartition("_")[2].lower()


def surfaces(body: Any) -> tuple[Surface, ...]:
    """Return the plane and cylindrical faces of a body with their own parameters."""
    surfaces_found: list[Surface] = []
    for number, face in enumerate(explored(body, "FACE")):
        kind = surface_kind(face)
        if kind == "plane":
            surfaces_found.append(_plane(number, face))
        elif kind == "cylinder":
            surfaces_found.append(_cylinder(number, face))
    return tuple(surfaces_found)


def _plane(number: int, face: Any) -> PlaneFace:
    area, centroid = _area(face)
    return PlaneFace(number, _outward(face, _adaptor(face).Plane()), area, centroid)


def _outward(face: Any, plane: Any) -> Array:
    """Return the outward normal: a plane's own sense, turned by its axes' hand and by the face's."""
    from OCP.TopAbs import TopAbs_Orientation

    direction = as_array(plane.Axis().Direction())
    inward = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    return -direction if inward == bool(plane.Direct()) else direction


def _cylinder(number: int, face: Any) -> CylinderFace:
    from OCP.TopAbs import TopAbs_Orientation

    adaptor = _adaptor(face)
    cylinder = adaptor.Cylinder()
    reversed_ = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    return CylinderFace(
        number,
        as_array(cylinder.Location()),
        as_array(cylinder.Axis().Direction()),
        float(cylinder.Radius()),
        float(adaptor.FirstVParameter()),
        float(adaptor.LastVParameter()),
        reversed_ == bool(cylinder.Position().Direct()),
        _area(face)[0],
        float(adaptor.LastUParameter() - adaptor.FirstUParameter()),
    )


def _adaptor(face: Any) -> Any:
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.TopoDS import TopoDS

    return BRepAdaptor_Surface(TopoDS.Face(face))


def as_array(xyz: Any) -> Array:
    """Return a point or direction of the kernel as (3,)."""
    return np.array([xyz.X(), xyz.Y(), xyz.Z()])


def area_mm2(face: Any) -> float:
    return _area(face)[0]


def _area(face: Any) -> tuple[float, Array]:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    props = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, props)
    return float(props.Mass()), as_array(props.CentreOfMass())
