"""Faces that lie in one plane are told apart by their own outlines."""

import numpy as np

from autobalance.correction.faces.trace import FaceTrace
from autobalance.correction.trace import Before, Metal
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid

GROOVE = Region.circle(14.0, 48) - Region.circle(10.0, 48)
PLATE = Solid.prism(Region.rectangle([-30.0, -30.0], [30.0, 30.0]), 0.0, 10.0) - Solid.prism(
    GROOVE, 6.0, 11.0
)
ANATOMY = Anatomy(np.eye(4), (), (), (), 0.0)


def top(name: str, beyond_mm: float, within_mm: float) -> Face:
    """Return the part of the top whose triangles' corners lie between two distances from the axis."""
    corners = PLATE.mesh.corners
    away = np.linalg.norm(corners[:, :, :2], axis=2)
    rows = np.flatnonzero(
        (np.abs(corners[:, :, 2] - 10.0) < 1e-9).all(axis=1)
        & (away > beyond_mm).all(axis=1)
        & (away < within_mm).all(axis=1)
    )
    area = 0.5 * PLATE.mesh.doubled_areas[rows]
    centroid = area @ corners[rows].mean(axis=1) / area.sum()
    return Face(name, "plane", None, float(area.sum()), np.array([0.0, 0.0, 1.0]), centroid, rows, 0.0)


def read_face(cut: Solid) -> str:
    faces = top("boss", -1.0, 10.5), top("rest", 13.5, 99.0)
    corners = PLATE.mesh.corners
    crank = Before(PLATE.mesh, ANATOMY, faces, tuple(corners[face.triangles].mean(axis=1) for face in faces))
    metal = Metal((PLATE & cut,), 7.85e-3, crank, None, 1.0, 1e-6)
    item = {"kind": "shoulder", "normal": [0.0, 0.0, 1.0], "sector_deg": None}
    return str(FaceTrace(item).read(metal)["face"])


def test_metal_around_a_boss_is_not_the_boss() -> None:
    """The middle of the metal lies in the boss: its triangles are nearer than those of the face cut."""
    outside = Region.rectangle([-40.0, -40.0], [40.0, 40.0]) - Region.circle(12.0, 48)
    assert read_face(Solid.prism(outside, 9.5, 10.5)) == "rest"
    assert read_face(Solid.prism(Region.circle(12.0, 48), 9.5, 10.5)) == "boss"
