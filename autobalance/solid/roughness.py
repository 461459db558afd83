"""Noise on the surface of a mesh: its presence and its size."""

from __future__ import annotations

import math

import numpy as np

from autobalance.solid.mesh.mesh import Mesh, hash_rows
from autobalance.types import Array, Flags, Indices

# Recognition of scanned meshes, and their roughness: drawn faces are plane except for rounding.


LOOKED_AT = 3000
"""Vertices that are sampled, wherever they are."""
FLAT_RAD = 1e-4
"""Triangles that meet at less are one plane: neighbours of a scan differ by more, be it waved by 1 µm."""
MAX_ROUNDING_STEPS = 4.0
"""... or are out of one plane by less than so many steps of single precision over their height."""
SCANNED, DRAWN = 0.06, 0.3
"""Shares of triangles in one plane with a neighbour: below the first the mesh was scanned, above the second
it was drawn. A crank waved by 2 µm has 2 %. A V12 scanned at edges of 3 mm and waved by 5 µm has 4.4 %; its
faces were half a millimetre off as those of a drawn one. Webs' faces and halves of facets give drawn meshes
their share. Between the two are free-form cranks (v-hacd's crank.off: 7 %) and smooth ones that were
decimated."""
MIN_TRIANGLES = 4000
"""A mesh of fewer triangles is too small to be noisy: a scan of a crank has 10 000 at least."""
NEIGHBOURHOODS = 400
"""Neighbourhoods that are sampled."""
ROUGHNESS_QUANTILE = 0.35
"""Quantile of the neighbourhoods that counts as the roughness; edges have more."""
SINGLE_PRECISION = 2.0**-24
"""Rounding of a number of single precision, as a share of it."""


def flat_share(mesh: Mesh, least: int = MIN_TRIANGLES) -> float:
    """Return the share of a mesh's triangles that lie in one plane with a neighbour; 1 of a small mesh.

    It is estimated from some triangles, and does not depend on the order of triangles or vertices. Small is a
    mesh of less than ``least`` triangles.
    """
    if len(mesh.triangles) < least:
        return 1.0
    one, two = _neighbours(mesh)
    sizes = mesh.doubled_areas
    real = (sizes.take(one) > 0.0) & (sizes.take(two) > 0.0)
    one, two = one[real], two[real]
    if len(one) == 0:
        return 1.0
    a, b = (mesh.area_vectors.take(rows, axis=0) / sizes.take(rows)[:, None] for rows in (one, two))
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    height = np.minimum(sizes.take(one), sizes.take(two)) / _longest(mesh, one, two)
    reach = float(np.abs(mesh.bounds).max())
    slack = FLAT_RAD + MAX_ROUNDING_STEPS * SINGLE_PRECISION * reach / np.maximum(height, 1e-12)
    flat = (sine < slack) & ((a * b).sum(axis=1) > 0.0)
    number = np.unique(np.concatenate([one, two]), return_inverse=True)[1]
    beside = np.bincount(number, np.tile(flat, 2)) > 0
    return float(beside.mean())


def _neighbours(mesh: Mesh) -> tuple[Indices, Indices]:
    """Return the two triangles (k,) beside each of the edges at some of the vertices."""
    chosen = spread(mesh, LOOKED_AT)
    a, b, c = mesh.triangles.T
    rows = np.flatnonzero(chosen.take(a) | chosen.take(b) | chosen.take(c))
    triangles = mesh.triangles.take(rows, axis=0)
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner = np.tile(rows, 3)
    low, high = ends.min(axis=1), ends.max(axis=1)
    key = low * len(mesh.vertices) + high
    order = np.argsort(key, kind="stable")
    same = np.flatnonzero(key[order][1:] == key[order][:-1])
    return owner[order[same]], owner[order[same + 1]]


def spread(mesh: Mesh, count: int) -> Flags:
    """Mark some of the vertices (n,), chosen by their coordinates alone."""
    every = np.uint64(max(1, len(mesh.vertices) // count))
    marked: Flags = hash_rows(mesh.vertices.astype(np.float32)) % every == 0
    return marked


def _longest(mesh: Mesh, one: Indices, two: Indices) -> Array:
    longest = np.zeros(len(one))
    for rows in (one, two):
        corners = mesh.vertices.take(mesh.triangles.take(rows, axis=0), axis=0)
        for k in range(3):
            longest = np.maximum(longest, np.linalg.norm(corners[:, k] - corners[:, k - 1], axis=1))
    return longest


def smoothed_normals(mesh: Mesh, rounds: int = 3) -> Array:
    """Return each triangle's direction (m, 3), averaged with its neighbours' in so many ``rounds``."""
    directions = mesh.area_vectors
    a, b, c = mesh.triangles.T
    for _ in range(rounds):
        at = unit_at_vertices(mesh, directions)
        directions = at.take(a, axis=0) + at.take(b, axis=0) + at.take(c, axis=0)
        directions *= (mesh.doubled_areas / np.maximum(np.linalg.norm(directions, axis=1), 1e-300))[:, None]
    unit: Array = directions / np.maximum(np.linalg.norm(directions, axis=1), 1e-300)[:, None]
    return unit


def local_roughness_mm(mesh: Mesh, within_mm: float) -> float:
    """Return the typical distance of vertices from a paraboloid through those around them [mm].

    Waves longer than the neighbourhood are shape to it: the roughness of a whole face is greater.

    Parameters
    ----------
    mesh : Mesh
    within_mm : float
        Radius of the neighbourhood.
    """
    from scipy.spatial import cKDTree

    normals = unit_at_vertices(mesh, mesh.area_vectors)
    chosen = np.flatnonzero(spread(mesh, NEIGHBOURHOODS))
    tree = cKDTree(mesh.vertices, balanced_tree=False, compact_nodes=False)  # built four times as fast
    residuals = []
    around = tree.query_ball_point(mesh.vertices[chosen], within_mm, return_sorted=False)
    for place, those in zip(chosen, around, strict=True):
        near = np.array(those)
        facing = near[normals[near] @ normals[place] > 0.9]
        if len(facing) < 12:
            continue
        residual = off_paraboloid(mesh.vertices[facing] - mesh.vertices[place], normals[place])
        residuals.append(
            1.4826 * float(np.median(np.abs(residual))) * math.sqrt(len(facing) / (len(facing) - 6))
        )
    return float(np.quantile(residuals, ROUGHNESS_QUANTILE)) if residuals else 0.0


def off_paraboloid(points: Array, normal: Array) -> Array:
    """Return the height (n,) of points (n, 3) above the best-fitting paraboloid over ``normal``."""
    side = _cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    side /= np.linalg.norm(side)
    x, y, h = points @ side, points @ _cross(normal, side), points @ normal
    rows = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    residual: Array = h - rows @ np.linalg.lstsq(rows, h, rcond=None)[0]
    return residual


def _cross(a: Array, b: Array) -> Array:
    """Return the cross product of two vectors (3,), in a tenth of the time that np.cross takes."""
    (a_x, a_y, a_z), (b_x, b_y, b_z) = a.tolist(), b.tolist()
    return np.array([a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x])


def at_vertices(mesh: Mesh, values: Array) -> Array:
    """Return the sum (n,) over the triangles at each vertex."""
    total = np.zeros(len(mesh.vertices))
    for k in range(3):
        total += np.bincount(mesh.triangles[:, k], values, len(total))
    return total


def unit_at_vertices(mesh: Mesh, vectors: Array) -> Array:
    """Return the directions (n, 3) of the sums over the triangles at each vertex."""
    at = np.stack([at_vertices(mesh, np.ascontiguousarray(column)) for column in vectors.T], axis=1)
    at /= np.maximum(np.linalg.norm(at, axis=1), 1e-300)[:, None]
    return at


def vertex_areas(mesh: Mesh) -> Array:
    """Return the area (n,) that each vertex stands for: a third of its triangles' [mm²]."""
    third = mesh.doubled_areas / 6.0
    return at_vertices(mesh, third)
