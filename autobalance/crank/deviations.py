"""Distances of a scanned crank's surface from the cylinders, rims and planes recognised in it."""

from __future__ import annotations

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

REACH_MM = 0.5
"""Vertices farther from a cylinder than this do not belong to it: a fillet, a drilling."""


def deviations_mm(mesh: Mesh, anatomy: Anatomy) -> Array:
    """Return each vertex's deviation (n,) of a mesh in file axes, outside positive; NaN: on no surface."""
    placed = mesh.moved(anatomy.file_to_rotor).vertices
    off = np.full(len(placed), np.nan)
    for pin in (*anatomy.main_journals, *(throw.crankpin for throw in anatomy.throws)):
        low, high = pin.z_range_mm
        away = np.hypot(placed[:, 0] - pin.centre_mm[0], placed[:, 1] - pin.centre_mm[1])
        away -= 0.5 * pin.diameter_mm
        here = (placed[:, 2] > low) & (placed[:, 2] < high) & (np.abs(away) < REACH_MM)
        off[here] = away[here]
    for web in anatomy.webs:
        if web.outline is not None:
            away = np.hypot(placed[:, 0], placed[:, 1]) - web.outline.rim_radius_mm
            here = (placed[:, 2] > web.z_min_mm) & (placed[:, 2] < web.z_max_mm) & (np.abs(away) < REACH_MM)
            off[here] = away[here]
    for face in () if anatomy.scan is None else anatomy.scan.faces:
        corners = np.unique(mesh.triangles.take(face.rows, axis=0))
        off[corners] = (mesh.vertices.take(corners, axis=0) - face.centroid_mm) @ face.normal
    return off
