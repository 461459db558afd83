"""STEP files through the CAD kernel: exact mass properties, and fine triangles; needs the extra ``step``."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any, Final

import numpy as np

from autobalance.errors import FormatError
from autobalance.rotor.moments import Moments
from autobalance.solid.brep import has_kernel, properties, silence
from autobalance.solid.mesh import Array, Indices
from autobalance.solid.raw import Raw, soup_of

SAG_SHARE: Final = 2e-5
"""Greatest distance of a triangle from the true surface, as a share of the diagonal."""
TURN_RAD: Final = 0.1
"""Greatest angle between neighbouring triangles on one surface."""


def read_step(data: bytes) -> Raw:
    """Read the solids of a STEP file as triangles [mm] whose corners lie on the true surface.

    Where the file holds one solid, its exact moments come along.

    Raises
    ------
    FormatError
        If the CAD kernel is not installed, or the file is no STEP file or holds no solid.
    """
    if not has_kernel():
        raise FormatError(
            "STEP needs the CAD kernel, which is not installed: pip install 'autobalance[step]'"
        )
    if b"ISO-10303-21" not in data[:256]:
        raise FormatError("the STEP file does not begin with ISO-10303-21")
    solids = _solids(_transferred(data))
    if not solids:
        raise FormatError("the STEP file holds no solid; needed a closed body, not surfaces or wires")
    parts = [_triangles(solid) for solid in solids]
    offsets = np.cumsum([0, *(len(points) for points, _ in parts[:-1])])
    numbers = np.concatenate([faces + shift for (_, faces), shift in zip(parts, offsets, strict=True)])
    soup = soup_of(np.concatenate([points for points, _ in parts]), numbers, "STEP")
    exact: Moments | None = properties(solids[0]) if len(solids) == 1 else None
    return Raw(soup, "mm", 1.0, exact=exact)


def _transferred(data: bytes) -> Any:
    """Return the file's shape, in mm whatever its unit."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPControl import STEPControl_Reader

    silence()
    reader = STEPControl_Reader()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "crank.step"
        path.write_bytes(data)
        if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
            raise FormatError("the STEP file cannot be read")
        reader.TransferRoots()
    return reader.OneShape()


def _solids(shape: Any) -> list[Any]:
    from OCP.TopAbs import TopAbs_ShapeEnum

    return [] if shape.IsNull() else _explored(shape, TopAbs_ShapeEnum.TopAbs_SOLID)


def _explored(shape: Any, kind: Any) -> list[Any]:
    from OCP.TopExp import TopExp_Explorer

    explorer, found = TopExp_Explorer(shape, kind), []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def _triangles(solid: Any) -> tuple[Array, Indices]:
    """Return corners (n, 3) and outward triangles (m, 3); neighbours have equal corners."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_ShapeEnum

    box = Bnd_Box()
    BRepBndLib.Add_s(solid, box)
    sag = SAG_SHARE * float(np.sqrt(box.SquareExtent()))
    BRepMesh_IncrementalMesh(solid, sag, False, TURN_RAD, False)
    points: list[Array] = []
    triangles: list[Indices] = []
    count = 0
    for face in _explored(solid, TopAbs_ShapeEnum.TopAbs_FACE):
        corners, numbers = _face_triangles(face)
        points.append(corners)
        triangles.append(numbers + count)
        count += len(corners)
    return np.concatenate(points), np.concatenate(triangles)


def _face_triangles(face: Any) -> tuple[Array, Indices]:
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_Orientation
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    place = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(TopoDS.Face(face), place)
    if mesh is None:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    motion = place.Transformation()
    nodes = (mesh.Node(number + 1).Transformed(motion) for number in range(mesh.NbNodes()))
    corners = np.array([(node.X(), node.Y(), node.Z()) for node in nodes])
    numbers = np.array([mesh.Triangle(number + 1).Get() for number in range(mesh.NbTriangles())]) - 1
    inward = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    return corners, numbers[:, ::-1] if inward else numbers
