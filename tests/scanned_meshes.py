"""Scans of any closed mesh: its signed distance, meshed and waved as those of `tests/scans.py`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from autobalance.crank.anatomy import Anatomy
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array
from tests.generated import random_placement
from tests.scans import FAR_MM, Field, Scan, gradient, meshed, noise

NEAREST = 4
"""Triangles that are looked at for the nearest place on the surface."""
DENSE = 0.4
"""Spacing of the points by which those are found, as a share of the scan's edges."""

SLIVER_MM = 0.02
"""Triangles that are not as high have no direction to tell inside from outside; those beside them do."""
ROUNDED = 0.35
"""Radius over which edges are rounded, as a share of the scan's edges: vertices do not meet there."""


class Inside:
    """Which voxels of a closed mesh lie inside, by sections through their middles.

    The nearest triangle's direction may be wrong: at slivers, and at walls thinner than a step.
    """

    def __init__(self, mesh: Mesh, step_mm: float) -> None:
        self.step_mm = step_mm
        low, high = (np.asarray(end) for end in mesh.bounds)
        self.low = low - 2.0 * step_mm
        self.shape = np.ceil((high - self.low) / step_mm).astype(int) + 2
        solid = Solid.from_mesh(mesh)
        layers = [self._layer(solid, self.low[2] + (k + 0.5) * step_mm) for k in range(self.shape[2])]
        self.voxels = np.stack(layers, axis=2)

    def _layer(self, solid: Solid, z_mm: float) -> NDArray[np.bool_]:
        """Return which voxels (x, y) of a layer have an odd number of outlines on their left."""
        nx, ny = self.shape[:2]
        toggled = np.zeros((nx + 1, ny), dtype=np.int64)
        for polygon in solid.section(z_mm).polygons:
            a = (polygon - self.low[:2]) / self.step_mm - 0.5
            b = np.roll(a, -1, axis=0)
            for row in range(ny):
                cross = (a[:, 1] > row) != (b[:, 1] > row)
                (x0, y0), (x1, y1) = a[cross].T, b[cross].T
                at = np.ceil(x0 + (row - y0) / (y1 - y0) * (x1 - x0)).astype(int)
                np.add.at(toggled, (np.clip(at, 0, nx), row), 1)
        inside: NDArray[np.bool_] = np.cumsum(toggled, axis=0)[:nx] % 2 == 1
        return inside

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """Return whether the voxels in which points (n, 3) lie are inside."""
        at = np.floor((points - self.low) / self.step_mm).astype(int)
        known: NDArray[np.bool_] = np.all((at >= 0) & (at < self.shape), axis=1)
        i, j, k = np.where(known[:, None], at, 0).T
        held: NDArray[np.bool_] = known & self.voxels[i, j, k]
        return held


def mesh_field(mesh: Mesh, spacing_mm: float) -> Field:
    """Return the signed distance of a closed mesh, by the nearest of some triangles around a point.

    Farther than a voxel from the surface, sections say which side a point is on.
    """
    inside = Inside(mesh, spacing_mm)
    sides = np.linalg.norm(mesh.corners - np.roll(mesh.corners, 1, axis=1), axis=2).max(axis=1)
    mesh = mesh.part(mesh.doubled_areas > SLIVER_MM * sides)
    area = 0.5 * mesh.doubled_areas
    many = np.maximum(np.ceil(area / spacing_mm**2), 3).astype(np.int64)
    owner = np.repeat(np.arange(len(area)), many)
    u, v = np.random.default_rng(0).random((2, len(owner)))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    a, b, c = (mesh.vertices[column[owner]] for column in mesh.triangles.T)
    corners = np.arange(len(area)).repeat(3)
    points = np.concatenate([a + u[:, None] * (b - a) + v[:, None] * (c - a), mesh.corners.reshape(-1, 3)])
    owner = np.concatenate([owner, corners])
    tree = cKDTree(points)
    normals = mesh.area_vectors / np.maximum(mesh.doubled_areas, 1e-300)[:, None]

    def field(at: Array) -> Array:
        near = owner[tree.query(at, k=NEAREST)[1]]
        best, sign = np.full(len(at), np.inf), np.ones(len(at))
        steep = np.zeros(len(at))
        for rows in near.T:
            place = _nearest_on_triangles(at, *(mesh.vertices[mesh.triangles[rows, k]] for k in range(3)))
            arm = at - place
            away = np.linalg.norm(arm, axis=1)
            along = (arm * normals[rows]).sum(axis=1)
            lean = np.abs(along) / np.maximum(away, 1e-12)
            nearer = (away < best - 1e-9) | ((away < best + 1e-9) & (lean > steep))
            best, steep = np.where(nearer, np.minimum(away, best), best), np.where(nearer, lean, steep)
            sign = np.where(nearer, np.where(along < 0.0, -1.0, 1.0), sign)
        far = best > spacing_mm
        sign[far] = np.where(inside.holds(at[far]), -1.0, 1.0)
        clipped: Array = np.clip(sign * best, -FAR_MM, FAR_MM)
        return clipped

    return field


def _nearest_on_triangles(p: Array, a: Array, b: Array, c: Array) -> Array:
    """Return the nearest points (n, 3) of triangles (n, 3) each: inside, else on the nearest edge."""
    ab, ac, ap = b - a, c - a, p - a
    d00, d01, d11 = (ab * ab).sum(1), (ab * ac).sum(1), (ac * ac).sum(1)
    d20, d21 = (ap * ab).sum(1), (ap * ac).sum(1)
    area = np.maximum(d00 * d11 - d01 * d01, 1e-300)
    v, w = (d11 * d20 - d01 * d21) / area, (d00 * d21 - d01 * d20) / area
    inside = (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
    best = a + v[:, None] * ab + w[:, None] * ac
    away = np.where(inside, ((p - best) ** 2).sum(1), np.inf)
    for start, way in ((a, ab), (a, ac), (b, c - b)):
        t = np.clip(((p - start) * way).sum(1) / np.maximum((way * way).sum(1), 1e-300), 0.0, 1.0)
        place = start + t[:, None] * way
        off = ((p - place) ** 2).sum(1)
        nearer = ~inside & (off < away)
        best, away = np.where(nearer[:, None], place, best), np.where(nearer, off, away)
    return np.asarray(best)


def rounded(field: Field, radius_mm: float) -> Field:
    """Return a distance with its edges rounded: the mean of four points around each."""
    around = radius_mm * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / math.sqrt(3.0)

    def mean(points: Array) -> Array:
        found: Array = np.mean([field(points + way) for way in around], axis=0)
        return found

    return mean


def scan_of_mesh(mesh: Mesh, truth: Anatomy, sigma_mm: float, *, edge_mm: float, seed: int = 0) -> Scan:
    """Return a scan of a closed mesh [mm], whose ``truth`` is its anatomy."""
    rng = np.random.default_rng([seed, 79])
    field = rounded(mesh_field(mesh, DENSE * edge_mm), ROUNDED * edge_mm)
    turn = random_placement(rng)[:3, :3]
    vertices, triangles = meshed(field, np.asarray(mesh.bounds), edge_mm, turn, seed)
    placement = random_placement(rng, 200.0)
    move = noise(vertices, sigma_mm, rng) if sigma_mm else np.zeros(len(vertices))
    noisy = vertices + move[:, None] * gradient(field, vertices)
    placed = Anatomy(
        truth.file_to_rotor @ np.linalg.inv(placement),
        truth.main_journals,
        truth.throws,
        truth.webs,
        truth.journal_misalignment_mm,
        truth.datums,
    )
    return Scan(
        Mesh(noisy, triangles).moved(placement), Mesh(vertices, triangles).moved(placement), placed, placement
    )


def scaled_to_crank(mesh: Mesh, smallest_mm: float = 60.0) -> Mesh:
    """Return a mesh of a file without unit at the size of a crank, by a power of ten."""
    power = max(0, math.ceil(math.log10(smallest_mm / mesh.diagonal_mm)))
    return Mesh(10.0**power * mesh.vertices, mesh.triangles)
