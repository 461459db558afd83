"""Size of a mesh where a triangulated surface is curved."""

from __future__ import annotations

import math

import numpy as np

from autobalance.types import Array, Indices

SHARPEST_RAD = math.radians(30.0)
"""A steeper edge is a true edge, not a facet of a curved surface; netgen draws the line there too."""
FLATTEST_RAD = 1e-3
MAX_REFINEMENT = 12.0
"""A local size is never less than the mesh's own over this: a fillet of 0.01 mm is not resolved."""
MOST_POINTS = 200_000


def curvature_sizes(
    vertices_mm: Array, triangles: Indices, size_mm: float, share_of_radius: float
) -> tuple[Array, Array]:
    """Return points (k, 3) on curved parts of a surface and the element size (k,) wanted there [mm].

    A facet edge with dihedral angle θ between triangles of altitudes h₁, h₂ over it lies on a surface of
    radius (h₁ + h₂)/(2 θ).

    Parameters
    ----------
    vertices_mm : (n, 3) float
    triangles : (m, 3) int
        Closed and outward.
    size_mm : float
        Size elsewhere [mm].
    share_of_radius : float
        Element size over the radius of curvature.
    """
    edges, pairs = _edges(triangles)
    corners = vertices_mm[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(normals, axis=1)
    unit = normals / np.maximum(doubled, 1e-300)[:, None]
    first, second = unit[pairs[:, 0]], unit[pairs[:, 1]]
    angle = np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), (first * second).sum(axis=1))
    ends = vertices_mm[edges]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    altitudes = doubled[pairs].sum(axis=1) / np.maximum(length, 1e-300)
    curved = (angle > FLATTEST_RAD) & (angle < SHARPEST_RAD) & (length > 0.0)
    edge_mm = share_of_radius * altitudes[curved] / (2.0 * angle[curved])
    finer = edge_mm < size_mm
    sizes = np.maximum(edge_mm[finer], size_mm / MAX_REFINEMENT)
    return _along(ends[curved][finer], length[curved][finer], sizes)


def _edges(triangles: Indices) -> tuple[Indices, Indices]:
    """Return each edge's vertices (e, 2) and its two triangles (e, 2)."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    sides.sort(axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    sides, owner = sides[order], owner[order]
    same = (sides[:-1] == sides[1:]).all(axis=1)
    at = np.flatnonzero(same)
    return sides[at], np.column_stack([owner[at], owner[at + 1]])


def _along(ends: Array, length: Array, sizes: Array) -> tuple[Array, Array]:
    """Return points along each edge no further apart than its size, and their sizes."""
    counts = np.ceil(length / sizes).astype(np.int64) + 1
    if counts.sum() > MOST_POINTS:
        counts = np.full(len(sizes), 2)
    row = np.repeat(np.arange(len(sizes)), counts)
    place = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (place / np.maximum(counts[row] - 1, 1))[:, None]
    return ends[row, 0] * (1.0 - share) + ends[row, 1] * share, sizes[row]
