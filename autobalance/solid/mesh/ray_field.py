"""Fields of parallel rays through a closed mesh: where along them metal counts twice, or as negative.

Going up a ray, a triangle that is entered adds one to the winding number and one that is left takes one away;
in a solid the number is 0 or 1 everywhere. All rays of a field are followed at once, without a loop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalance.solid.mesh.mesh import CHUNK, Array, Indices, Mesh

DEPTH_BITS = 32
"""Depths along a ray are told apart to so many bits of the body's length: half a nanometre in a metre."""
LENGTH_LEAST = 1e-8
"""Shorter stretches, as a share of the diagonal, are rounding where surfaces touch."""
Whole = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Doubled:
    """What a field of rays sees of metal that counts twice or as negative.

    Attributes
    ----------
    volume_mm3 : float
        Of it, counted as often as it is too much or too little.
    low_mm, high_mm : (3,) float
        Least and greatest coordinates of the stretches of rays within it; meaningless without any.
    stretches : int
        On how many stretches of rays it was seen.
    pitch_mm : float
        Distance of the rays.
    """

    volume_mm3: float
    low_mm: Array
    high_mm: Array
    stretches: int
    pitch_mm: float


def frame_along(direction: Array, across: Array) -> Array:
    """Return a right-handed frame (3, 3), in rows: its last axis a direction, its first nearly ``across``."""
    along = direction / np.linalg.norm(direction)
    second = np.cross(along, across)
    second /= np.linalg.norm(second)
    return np.stack([np.cross(second, along), second, along])


def doubled_metal(mesh: Mesh, rays: int, axes: Array, shift: tuple[float, float]) -> Doubled:
    """Follow parallel rays through a closed, outward mesh and add up where it is not there just once.

    Parameters
    ----------
    mesh : Mesh
    rays : int
        About how many rays, over the rectangle that the mesh fills as seen along them.
    axes : (3, 3) float
        Two directions across the rays and that of the rays, a right-handed frame, in rows.
    shift : (float, float)
        Where in its cell of the field each ray stands, 0 to 1.
    """
    places = axes @ mesh.vertices.T
    low, high = places.min(axis=1), places.max(axis=1)
    size = np.maximum(high - low, 1e-12 * mesh.diagonal_mm)
    pitch = float(np.sqrt(size[0] * size[1] / rays))
    columns = int(size[0] / pitch) + 2
    step = np.array([pitch, pitch, size[2] / ((1 << DEPTH_BITS) - 1)])
    start = low - step * np.array([*shift, 0.0])
    places -= start[:, None]
    places /= step[:, None]
    event = np.concatenate(_crossings(places, mesh.triangles, columns))
    event.sort()
    winding = np.cumsum(1 - 2 * (event & 1).astype(np.int8), dtype=np.int32)
    wrong = np.flatnonzero((winding < 0) | (winding > 1))  # each ray ends at 0, where the next one begins
    times = np.where(winding[wrong] > 1, winding[wrong] - 1, -winding[wrong])
    ends = np.stack([event[wrong], event[wrong + 1]])
    depth = (ends >> 1) & ((1 << DEPTH_BITS) - 1)
    length = (depth[1] - depth[0]) * step[2]
    volume = float(length @ times) * pitch * pitch
    long = length > LENGTH_LEAST * mesh.diagonal_mm
    row, column = np.divmod(ends[:, long] >> (DEPTH_BITS + 1), columns)
    seen = start + step * np.stack([column, row, depth[:, long]], axis=-1).reshape(-1, 3)
    if not len(seen):
        return Doubled(volume, low, low, 0, pitch)
    seen = seen @ axes
    return Doubled(volume, seen.min(axis=0), seen.max(axis=0), int(long.sum()), pitch)


def _crossings(places: Array, triangles: Indices, columns: int) -> list[Whole]:
    """Return where rays that stand at whole numbers of u and v cross triangles (m, 3).

    Each crossing is one number: the ray, the depth, and whether metal is left (1) or entered (0). Most
    triangles of a fine mesh lie between the rays.
    """
    u_ceiling, v_ceiling = np.ceil(places[:2]).astype(np.int32)
    found = []
    for start in range(0, len(triangles), CHUNK):
        corners = np.ascontiguousarray(triangles[start : start + CHUNK].T)
        first_row, end_row = _range(v_ceiling.take(corners))
        rows = end_row - first_row
        met = np.flatnonzero(rows)
        first_column, end_column = _range(u_ceiling.take(corners.take(met, axis=1)))
        met = met[end_column > first_column]
        if len(met):
            corners = corners.take(met, axis=1)
            which, row = _expanded(first_row[met].astype(np.int64), rows[met])
            which, row, column = _crossed(places[0].take(corners), places[1].take(corners), which, row)
            found.append(_events(places.take(corners.take(which, axis=1), axis=1), row, column, columns))
    return found or [np.zeros(0, dtype=np.int64)]


def _range(numbers: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    a, b, c = numbers
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def _expanded(first: Whole, count: Whole | NDArray[np.int32]) -> tuple[Indices, Whole]:
    """Return for runs of whole numbers which run each number belongs to, and the numbers."""
    which = np.repeat(np.arange(len(first)), count)
    before = np.cumsum(count, dtype=np.int64) - count
    return which, np.arange(len(which)) + (first - before).take(which)


def _crossed(u: Array, v: Array, which: Indices, row: Whole) -> tuple[Indices, Whole, Whole]:
    """Return the rays that cross triangles, given each row that a triangle meets: triangle, row and column.

    An edge is cut at the same place for both of its triangles, so that no ray slips between them or meets
    both.
    """
    (u0, u1, u2), (v0, v1, v2) = _by_height(u, v)
    upper = row >= v1.take(which)
    low, middle, high = which, which + len(v0), which + 2 * len(v0)
    across, height = np.concatenate([u0, u1, u2]), np.concatenate([v0, v1, v2])
    long = _cut(across, height, low, high, row)
    short = _cut(across, height, np.where(upper, middle, low), np.where(upper, high, middle), row)
    begin = np.ceil(np.minimum(long, short)).astype(np.int64)
    count = np.ceil(np.maximum(long, short)).astype(np.int64) - begin
    hit = np.flatnonzero(count)
    place, column = _expanded(begin[hit], count[hit])
    place = hit.take(place)
    return which.take(place), row.take(place), column


def _by_height(u: Array, v: Array) -> tuple[list[Array], list[Array]]:
    """Sort the three corners of triangles by v."""
    us, vs = list(u), list(v)
    for one, other in ((0, 1), (1, 2), (0, 1)):
        turned = vs[one] > vs[other]
        for values in (us, vs):
            a, b = values[one], values[other]
            values[one], values[other] = np.where(turned, b, a), np.where(turned, a, b)
    return us, vs


def _cut(u: Array, v: Array, low: Indices, high: Indices, row: Whole) -> Array:
    """Return where edges, from their lower to their higher end, meet rows."""
    low_u, low_v = u.take(low), v.take(low)
    place: Array = low_u + (row - low_v) / (v.take(high) - low_v) * (u.take(high) - low_u)
    return place


def _events(corners: Array, row: Whole, column: Whole, columns: int) -> Whole:
    """Return the crossings of triangles, axes × corners (3, 3, k), each with one ray."""
    u, v, w = corners
    det = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0])
    x, y = column - u[0], row - v[0]
    depth = (w[1] - w[0]) * (x * (v[2] - v[0]) - y * (u[2] - u[0]))
    depth += (w[2] - w[0]) * (y * (u[1] - u[0]) - x * (v[1] - v[0]))
    depth = w[0] + depth / np.where(det == 0.0, 1.0, det)
    depth = np.clip(depth, w.min(axis=0), w.max(axis=0))  # a steep triangle's plane leaves it within rounding
    event: Whole = (
        ((row * columns + column) << (DEPTH_BITS + 1)) | (depth.astype(np.int64) << 1) | (det > 0.0)
    )
    return event
