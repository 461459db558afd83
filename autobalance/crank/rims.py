"""Rims of webs: parts of cylinders about the crank axis that a lathe can take off."""

from __future__ import annotations

import numpy as np

from autobalance.crank.anatomy import Anatomy, Face, Web
from autobalance.crank.recognition.circles import distances
from autobalance.crank.recognition.section_stack import rotated
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Indices

ON_RIM = 1e-3
"""A rim's corners are off its radius by less than this share of it."""
OUTWARD_COSINE = 0.9
"""A rim's triangles face away from the axis; triangles of a web's face may have three corners on the rim."""
LEAST_AREA_SHARE = 5e-3
"""Rims smaller than this share of the whole surface are of no use to a correction."""


def find_rims(mesh: Mesh, anatomy: Anatomy) -> tuple[Face, ...]:
    """Return the rim of each web with a counterweight, in the rotor frame; its id is ``w1-rim`` and so on.

    Its normal is the mean over its area, square to the axis.

    Parameters
    ----------
    mesh : Mesh
        In file coordinates [mm].
    anatomy : Anatomy
    """
    placed = Mesh(rotated(mesh.vertices, anatomy.file_to_rotor), mesh.triangles)
    away = distances(placed.vertices, np.zeros(2))
    least_mm2 = LEAST_AREA_SHARE * 0.5 * float(mesh.doubled_areas.sum())
    rims, first = [], np.ascontiguousarray(mesh.triangles[:, 0])
    for web in anatomy.webs:
        if web.outline is None:
            continue
        rows = _on_rim(placed, first, away, web, web.outline.rim_radius_mm)
        face = _rim(placed, rows, web, web.outline.rim_radius_mm)
        if face is not None and face.area_mm2 >= least_mm2:
            rims.append(face)
    return tuple(rims)


def _on_rim(placed: Mesh, first: Indices, away: Array, web: Web, radius: float) -> Indices:
    """Return the triangles on a rim; ``first`` (m,) are their first corners, by which most are left out."""
    z, slack = placed.vertices[:, 2], ON_RIM * radius
    corner = (np.abs(away - radius) <= slack) & (z >= web.z_min_mm - slack) & (z <= web.z_max_mm + slack)
    rows = np.flatnonzero(corner.take(first))
    rows = rows[corner.take(placed.triangles.take(rows, axis=0)).all(axis=1)]
    middle = placed.vertices.take(placed.triangles.take(rows, axis=0), axis=0).mean(axis=1)[:, :2]
    outward = (placed.area_vectors.take(rows, axis=0)[:, :2] * middle).sum(axis=1)
    on_rim: Indices = rows[outward > OUTWARD_COSINE * radius * placed.doubled_areas.take(rows)]
    return on_rim


def _rim(placed: Mesh, rows: Indices, web: Web, radius: float) -> Face | None:
    areas = 0.5 * placed.doubled_areas.take(rows)
    mean = (placed.area_vectors.take(rows, axis=0)).sum(axis=0) * np.array([1.0, 1.0, 0.0])
    length = float(np.linalg.norm(mean))
    if length <= ON_RIM * float(areas.sum()):
        return None  # a whole disc: it faces no way
    corners = placed.vertices.take(placed.triangles.take(rows, axis=0), axis=0)
    spread = float(np.abs(distances(corners.reshape(-1, 3), np.zeros(2)) - radius).max())
    centroid = areas @ corners.mean(axis=1) / areas.sum()
    number = web.number
    return Face(
        f"w{number}-rim", "cylinder", number, float(areas.sum()), mean / length, centroid, rows, spread
    )
