"""Alignment of a crank with another, and the distances of their surfaces."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.declare import UNWRITTEN, NotNegative, Pair, Positive, Triple
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.roughness import vertex_areas
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Alignment of a crank with another, as in a scan with its drawing: on axis and throws, then on all points.
#
# Distances are from the nearest of many points on the drawing, along the surface's own direction there
# (point to plane), and least squares over them gives the last of the alignment.


POINTS = 400_000
"""Points on the drawing's surface."""
COMPARED_POINTS = 2_000
"""Points of the scan by which alignments are compared ..."""
REFINED_POINTS = 20_000
"""... and by which the best one is refined, in so many rounds."""
ROUNDS = 12
OUTLIER = 4.0
"""Points farther off than so many times the typical distance do not count in the alignment: dents, cuts."""
MAX_ASIDE_SPACINGS = 3.0
"""Nearest points that lie aside by more spacings than this are not below: at an edge, or beyond a hole."""


@dataclass(frozen=True, eq=False)
class Aligned:
    """A crank aligned with another one.

    ``motion`` (4, 4) takes the other's rotor frame to this one's; ``turn`` (4, 4) does the same by axis and
    throws alone. ``distances_mm`` (n,) are those of this one's vertices from the other's surface, outside
    positive. ``weights`` (n,) are the areas that the vertices represent.
    """

    motion: Array
    turn: Array
    distances_mm: Array
    weights: Array


@dataclass(frozen=True, eq=False)
class Against:
    """Distances from the drawing's surface, outside positive, by area; differences are from it.

    ``distances_mm`` (n,) are those of all vertices.
    """

    file: str
    mean_mm: float
    rms_mm: NotNegative
    p95_mm: Annotated[NotNegative, "95 % of the surface lies within"]
    worst_mm: float
    worst_at_mm: Triple
    mass_g: Annotated[Positive, "the drawing's"]
    unbalance_g_mm: Annotated[Pair, "the drawing's, in this crank's rotor frame"]
    mass_difference_g: float
    unbalance_difference_g_mm: Pair
    distances_mm: Annotated[Array, UNWRITTEN]


def aligned(mesh: Mesh, anatomy: Anatomy, other: Mesh, other_anatomy: Anatomy) -> Aligned:
    """Align a crank with another, both meshes in their files' coordinates [mm]."""
    here, there = mesh.moved(anatomy.file_to_rotor), other.moved(other_anatomy.file_to_rotor)
    surface = _SurfacePoints.of(there)
    areas = vertex_areas(here)
    tried = _some(here.vertices, COMPARED_POINTS)
    turns = list(_turns(anatomy, other_anatomy))
    turn = min(turns, key=lambda each: float(np.median(np.abs(surface.distances(_back(tried, each))))))
    motion = _refined(_some(here.vertices, REFINED_POINTS), surface, turn)
    return Aligned(motion, turn, surface.distances(_back(here.vertices, motion)), areas)


def turned(anatomy: Anatomy, turn: Array) -> Anatomy:
    """Return a crank's axis, pins and fit in another's rotor frame; ``turn`` (4, 4) is from that to its own.

    Webs and datums are left out.
    """
    back = np.linalg.inv(turn)

    def placed(point: Array) -> Array:
        there: Array = back[:3, :3] @ point + back[:3, 3]
        return there

    throws = tuple(
        replace(each, crankpin=replace(each.crankpin, centre_mm=placed(each.crankpin.centre_mm)))
        for each in anatomy.throws
    )
    journals = tuple(replace(each, centre_mm=placed(each.centre_mm)) for each in anatomy.main_journals)
    scan = anatomy.scan
    if scan is not None:
        scan = replace(scan, axis_middle_mm=float(placed(np.array([0.0, 0.0, scan.axis_middle_mm]))[2]))
    return Anatomy(
        back @ anatomy.file_to_rotor, journals, throws, (), anatomy.journal_misalignment_mm, scan=scan
    )


def _some(points: Array, count: int) -> Array:
    return points[:: max(1, len(points) // count)]


def _back(points: Array, motion: Array) -> Array:
    placed: Array = (points - motion[:3, 3]) @ motion[:3, :3]
    return placed


def _turns(anatomy: Anatomy, other: Anatomy) -> Iterator[Array]:
    """Yield motions (4, 4) by which axis and crankpin 1 meet the other's throws, either end first."""
    for sense in (1.0, -1.0):
        for throw in other.throws:
            pin = throw.crankpin.centre_mm
            angle = -math.atan2(sense * pin[1], pin[0])
            c, s = math.cos(angle), math.sin(angle)
            turn = np.eye(4)
            about_z = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            turn[:3, :3] = about_z @ np.diag([1.0, sense, sense])
            turn[2, 3] = anatomy.throws[0].crankpin.centre_mm[2] - sense * pin[2]
            yield turn


@dataclass(frozen=True, eq=False)
class _SurfacePoints:
    """Points (n, 3) on a surface with the surface's normals (n, 3) there, and the points' typical spacing."""

    points: Array
    normals: Array
    spacing_mm: float
    tree: object

    @classmethod
    def of(cls, mesh: Mesh) -> _SurfacePoints:
        from scipy.spatial import cKDTree

        area = 0.5 * mesh.doubled_areas
        rng = np.random.default_rng(0)
        owner = np.searchsorted(np.cumsum(area), (np.arange(POINTS) + 0.5) * area.sum() / POINTS)
        owner = owner.clip(max=len(area) - 1)
        u, v = rng.random((2, POINTS))
        u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
        a, b, c = (mesh.vertices.take(column.take(owner), axis=0) for column in mesh.triangles.T)
        points = a + u[:, None] * (b - a) + v[:, None] * (c - a)
        normals = mesh.area_vectors.take(owner, axis=0) / mesh.doubled_areas.take(owner)[:, None]
        return cls(points, normals, math.sqrt(float(area.sum()) / POINTS), cKDTree(points))

    def below(self, points: Array) -> Indices:
        """Return the numbers (n,) of the surface's points that are nearest to points (n, 3)."""
        return np.asarray(self.tree.query(points)[1])  # type: ignore[attr-defined]

    def distances(self, points: Array) -> Array:
        """Return the distances of points (n, 3) from the surface, outside positive."""
        nearest = self.below(points)
        arm = points - self.points.take(nearest, axis=0)
        along = np.einsum("ij,ij->i", arm, self.normals.take(nearest, axis=0))
        whole = np.linalg.norm(arm, axis=1)
        aside = np.sqrt(np.maximum(whole**2 - along**2, 0.0)) > MAX_ASIDE_SPACINGS * self.spacing_mm
        return np.asarray(np.where(aside, np.copysign(whole, along), along))


def _refined(points: Array, surface: _SurfacePoints, turn: Array) -> Array:
    """Return a motion by which points lie on a surface best, by least squares point to plane."""
    motion = turn.copy()
    for _ in range(ROUNDS):
        local = _back(points, motion)
        nearest = surface.below(local)
        normals = surface.normals.take(nearest, axis=0)
        off = np.einsum("ij,ij->i", local - surface.points.take(nearest, axis=0), normals)
        typical = max(1.4826 * float(np.median(np.abs(off))), 1e-6)
        keep = np.abs(off) < OUTLIER * typical
        rows = np.concatenate([np.cross(local[keep], normals[keep]), normals[keep]], axis=1)
        step = np.linalg.lstsq(rows, -off[keep], rcond=None)[0]
        moved = np.eye(4)
        moved[:3, :3] = _turned(step[:3])
        moved[:3, 3] = step[3:]
        motion = motion @ np.linalg.inv(moved)
        if float(np.abs(step).max()) < 1e-7:
            break
    return motion


def _turned(vector: Array) -> Array:
    from scipy.spatial.transform import Rotation

    turn: Array = Rotation.from_rotvec(vector).as_matrix()
    return turn


# Distances of a scanned crank's surface from the cylinders, rims and planes recognised in it.


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
