"""Possible faults of a scan in which no crank is recognised: half a crank, a stand, too rough a surface."""

from __future__ import annotations

import numpy as np

from autobalance.rigid_rotor.grade import listed_grade
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from autobalance.units import RAD_S_PER_RPM

CUT_SHARE = 0.12
"""No face of a whole crank holds so large a share of its surface; a cut through it, or a stand's, does."""
ONE_WAY, ONE_HEIGHT = 0.98, 2.0
"""Triangles are of one plane whose directions agree by this much and whose heights by so many mm."""
EXAMPLE_RPM = 6000.0
"""Speed [1/min] for which the grade is given as an example: no job is known here."""


def cut_or_stand(mesh: Mesh, directions: Array) -> str:
    """Return a hint at a plane that holds much of a mesh, empty where none does.

    ``directions`` (m, 3) are those of its triangles, smoothed.
    """
    area = 0.5 * mesh.doubled_areas
    cells = np.round(8.0 * directions).astype(np.int64) @ np.array([1 << 16, 1 << 8, 1])
    distinct, number = np.unique(cells, return_inverse=True)
    total = np.bincount(number, area, len(distinct))
    best = 0.0
    for cell in np.argsort(total)[-6:]:
        way = (directions[number == cell] * area[number == cell, None]).sum(axis=0)
        way /= max(float(np.linalg.norm(way)), 1e-300)
        rows = np.flatnonzero(directions @ way > ONE_WAY)
        height = mesh.vertices.take(mesh.triangles.take(rows, axis=0), axis=0).mean(axis=1) @ way
        share = np.bincount(((height - height.min()) / ONE_HEIGHT).astype(np.int64), area.take(rows))
        best = max(best, float((share[1:] + share[:-1]).max()) if len(share) > 1 else float(share[0]))
    if best < CUT_SHARE * float(area.sum()):
        return ""
    percent = 100.0 * best / float(area.sum())
    return f"one plane holds {percent:.0f} % of the surface: half a crank, or its stand with it?"


def grade_for(mesh: Mesh, roughness_mm: float) -> str:
    """Return the finest grade for which a skin of such roughness would do, as "G 40 at 6000 rpm"."""
    area = 0.5 * mesh.doubled_areas
    corners = mesh.corners - mesh.bounds.mean(axis=0)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    centre = volume @ corners.sum(axis=1) / 4.0 / volume.sum()
    off = area @ (corners.mean(axis=1) - centre)
    specific_mm = roughness_mm * float(np.linalg.norm(off)) / float(volume.sum())
    velocity = specific_mm * EXAMPLE_RPM * RAD_S_PER_RPM
    grade = listed_grade(velocity)
    return f"{'no grade' if grade is None else f'G {grade.grade_mm_s:g}'} at {EXAMPLE_RPM:.0f} rpm"
