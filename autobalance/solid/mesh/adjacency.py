"""Pairs of adjacent triangles of a mesh, the angles between them, and edges that more than two share."""

from __future__ import annotations

import numpy as np

from autobalance.solid.mesh.mesh import CHUNK, Mesh, longest_sides, numbered_components, ranked
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

# Pairs of adjacent triangles of a closed mesh, and the angles between them.


FLAT_RAD = 1e-4
"""Triangles that meet at less are one plane face; a circle would need 60 000 segments."""
MAX_ROUNDING_STEPS = 2.0
"""... and those that are out of one plane by less than so many steps of single precision: the corners of a
flat facet that was split into small triangles."""
LEAST_HEIGHT = 1e-6
"""Height of a triangle below which its direction means nothing, as a share of the mesh's diagonal."""


@dataclass(frozen=True, eq=False)
class Edges:
    """The edges of a closed mesh.

    Attributes
    ----------
    left, right : (k,) int
        Triangles on the two sides.
    ends : (k, 2) int
        Vertices.
    angle_rad : (k,) float
        Between the triangles' normals, 0 in one plane; 0 too beside a triangle without direction.
    flat : (k,) bool
        Whether the triangles are of one plane face; a triangle without direction joins the face beside its
        longest edge.
    """

    left: Indices
    right: Indices
    ends: Indices
    angle_rad: Array
    flat: Flags


@dataclass(frozen=True, eq=False)
class Sides:
    """The sides of triangles, those on one edge together; side 3 t + k runs from corner k of triangle t.

    Attributes
    ----------
    start, end : (3 m,) int
        Vertices of each side.
    order : (3 m,) int
        The sides, edge by edge.
    first, count : (k,) int
        Start of each edge in ``order``, and its number of sides.
    """

    start: Indices
    end: Indices
    order: Indices
    first: Indices
    count: Indices

    @property
    def of_two(self) -> tuple[Indices, Indices]:
        """The sides of the edges that have just two."""
        two = self.first[self.count == 2]
        return self.order[two], self.order[two + 1]


def sides_of(triangles: Indices) -> Sides:
    """Sort the sides of triangles (m, 3) by their edges; any number may lie on one."""
    start, end = triangles.reshape(-1), triangles[:, [1, 2, 0]].reshape(-1)
    key = np.minimum(start, end) * (int(triangles.max()) + 1) + np.maximum(start, end)
    ordered, order = ranked(key)
    first = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    return Sides(start, end, order, first, np.diff(np.append(first, len(order))))


def rim_of(mesh: Mesh, rows: Indices) -> Indices:
    """Return the sides (k, 2) of some triangles whose edges no other of them has, from start to end.

    They rise by their lower, then by their higher vertex.
    """
    count = len(mesh.vertices)
    sides = (3 * rows[:, None] + np.arange(3)).reshape(-1)
    if mesh.twin_sides is not None:
        among = np.zeros(len(mesh.triangles), dtype=bool)
        among[rows] = True
        sides = sides[~among.take(mesh.twin_sides.take(sides) // 3)]
    corners = mesh.triangles.reshape(-1)
    tail, head = corners.take(sides), corners.take(sides + np.where(sides % 3 == 2, -2, 1))
    edge = 2 * (np.minimum(tail, head) * count + np.maximum(tail, head)) + (tail > head)
    edge.sort()  # an edge and its twin stand side by side
    differs = np.diff(edge // 2, prepend=-1, append=-1) != 0
    alone = edge[differs[:-1] & differs[1:]]
    rim = np.stack(np.divmod(alone // 2, count), axis=1)
    rim[alone % 2 == 1] = rim[alone % 2 == 1, ::-1]
    return rim


def unit(vectors: Array) -> Array:
    """Return vectors (..., 3) scaled to length 1; zero ones stay zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def edges_of(mesh: Mesh) -> Edges:
    """Pair the triangles of a closed mesh at their edges."""
    left, right, ends = _paired(mesh)
    angle = _angles(mesh, left, right)
    known = _has_direction(mesh)
    sure = np.ones(len(left), dtype=bool) if known.all() else known.take(left) & known.take(right)
    flat = sure & (angle <= FLAT_RAD)
    bent = np.flatnonzero(sure & ~flat)
    off = _out_of_plane_mm(mesh, left.take(bent), right.take(bent), ends.take(bent, axis=0), angle.take(bent))
    flat[bent] = off <= rounding_mm(mesh)
    if not sure.all():
        flat |= _longest_of_slivers(mesh, left, right, ends, known)
    return Edges(left, right, ends, np.where(sure, angle, 0.0), flat)


def _paired(mesh: Mesh) -> tuple[Indices, Indices, Indices]:
    """Return the triangles at each edge (k,), the lower number first, and its vertices (k, 2)."""
    if mesh.twins is not None:
        up, down = mesh.twins
        side = up.astype(np.int64)
        one, other = side // 3, down.astype(np.int64) // 3
        corners = mesh.triangles.reshape(-1)
        ends = np.stack([corners.take(side), corners.take(side + np.where(side % 3 == 2, -2, 1))], axis=1)
        return np.minimum(one, other), np.maximum(one, other), ends
    sides = sides_of(mesh.triangles)
    first = sides.first[sides.count > 1]  # of four triangles at an edge, the first two
    side = sides.order.take(first)
    start, end = sides.start.take(side), sides.end.take(side)
    ends = np.stack([np.minimum(start, end), np.maximum(start, end)], axis=1)
    return side // 3, sides.order.take(first + 1) // 3, ends


def _angles(mesh: Mesh, left: Indices, right: Indices) -> Array:
    """Return the angles (k,) between the directions of pairs of triangles [rad]."""
    size = mesh.doubled_areas
    columns = np.ascontiguousarray(
        mesh.area_vectors.T
    )  # products of columns are many times as fast as of rows
    columns /= np.where(size > 0.0, size, 1.0)
    angles = np.zeros(len(left))
    for begin in range(0, len(left), CHUNK):
        part = slice(begin, begin + CHUNK)
        (ax, ay, az), (bx, by, bz) = columns.take(left[part], axis=1), columns.take(right[part], axis=1)
        across = (ay * bz - az * by) ** 2 + (az * bx - ax * bz) ** 2 + (ax * by - ay * bx) ** 2
        np.arctan2(np.sqrt(across), ax * bx + ay * by + az * bz, out=angles[part])
    return angles


def rounding_mm(mesh: Mesh) -> float:
    """Return the rough displacement of corners by rounding to single precision."""
    return MAX_ROUNDING_STEPS * float(np.spacing(np.float32(np.abs(mesh.bounds).max())))


def _out_of_plane_mm(mesh: Mesh, left: Indices, right: Indices, ends: Indices, angle: Array) -> Array:
    """Return the height of the smaller triangle at each edge above the other's plane (k,)."""
    along = mesh.vertices.take(ends[:, 1], axis=0) - mesh.vertices.take(ends[:, 0], axis=0)
    length = np.sqrt(np.einsum("ij,ij->i", along, along))
    least = np.minimum(mesh.doubled_areas.take(left), mesh.doubled_areas.take(right))
    height: Array = least / np.where(length > 0.0, length, 1.0)
    return angle * height


def _longest_of_slivers(mesh: Mesh, left: Indices, right: Indices, ends: Indices, known: Flags) -> Flags:
    """Mark, for each triangle without direction, its longest edge."""
    rows = np.flatnonzero(~(known[left] & known[right]))
    span = mesh.vertices[ends[rows]]
    length = np.linalg.norm(span[:, 1] - span[:, 0], axis=1)
    edge = np.concatenate([rows[~known[left[rows]]], rows[~known[right[rows]]]])
    size = np.concatenate([length[~known[left[rows]]], length[~known[right[rows]]]])
    triangle = np.concatenate([left[rows][~known[left[rows]]], right[rows][~known[right[rows]]]])
    order = np.lexsort((size, triangle))
    last = np.append(triangle[order][1:] != triangle[order][:-1], True)
    longest = np.zeros(len(left), dtype=bool)
    longest[edge[order][last]] = True
    return longest


def _has_direction(mesh: Mesh) -> Flags:
    """Mark the triangles (m,) that are high enough above their longest side; large ones always are."""
    least = LEAST_HEIGHT * mesh.diagonal_mm
    known: Flags = mesh.doubled_areas > 2.0 * least * mesh.diagonal_mm
    small = np.flatnonzero(~known)
    for begin in range(0, len(small), CHUNK):
        rows = small[begin : begin + CHUNK]
        sides = longest_sides(mesh.vertices.take(mesh.triangles.take(rows, axis=0), axis=0))
        known[rows] = mesh.doubled_areas.take(rows) > sides * least
    return known


def plane_faces(mesh: Mesh, edges: Edges) -> tuple[Indices, int]:
    """Return each triangle's face (m,), where a face is a connected set in one plane, and their number."""
    links = np.stack([edges.left[edges.flat], edges.right[edges.flat]], axis=1)
    return numbered_components(links, len(mesh.triangles))


# Pairing of triangles at edges shared by more than two, in meshes that touch themselves.


# Needed by files of two bodies that lie against each other, as tests/geometry/test_solid_pinched.py draws.


SAME_RAD = 1e-6
"""Directions about an edge that are one: faces that lie against each other."""


def linked_triangles(mesh: Mesh) -> Indices:
    """Return the pairs of triangles (k, 2) between which the inside of a closed, outward mesh lies.

    At most edges there are just two. Where parts touch along an edge there are more; of these, two belong
    together that follow each other about the edge with the inside between them. Faces that lie against each
    other have nothing between them and stay apart.
    """
    if mesh.twins is not None:
        return mesh.twins.T.astype(np.int64) // 3
    sides = sides_of(mesh.triangles)
    pairs = [np.stack(sides.of_two, axis=1) // 3]
    crowded = sides.count > 2
    for at, many in zip(sides.first[crowded], sides.count[crowded], strict=True):
        around = sides.order[at : at + many]
        runs_up = sides.start[around] < sides.end[around]
        angle = _angles_about_edge(mesh, around, runs_up)
        pairs.append(around[_wedges(angle, runs_up)] // 3)
    return np.concatenate(pairs)


def _angles_about_edge(mesh: Mesh, sides: Indices, runs_up: Flags) -> Array:
    """Return the direction of triangles about their common edge (k,) [rad]; ``sides`` are 3 t + corner."""
    triangle, corner = mesh.triangles[sides // 3], sides % 3
    row = np.arange(len(sides))
    begin, end, apex = (mesh.vertices[triangle[row, (corner + k) % 3]] for k in range(3))
    low, high = (begin[0], end[0]) if runs_up[0] else (end[0], begin[0])
    along = (high - low) / np.linalg.norm(high - low)
    away = apex - low
    away = away - np.outer(away @ along, along)
    x = away[0] / (np.linalg.norm(away[0]) or 1.0)
    y = np.cross(along, x)
    angles: Array = np.arctan2(away @ y, away @ x)
    return angles


def _wedges(angle: Array, runs_up: Flags) -> Indices:
    """Return pairs (k, 2) of places: from a triangle that runs down, about the edge, to one that runs up.

    Outward triangles that run up the edge have the inside before them, those that run down behind them.
    """
    order = np.argsort(np.mod(np.where(runs_up, angle - SAME_RAD, angle), 2.0 * np.pi), kind="stable")
    depth = np.cumsum(np.where(runs_up[order], -1, 1))
    order = np.roll(order, -(int(depth.argmin()) + 1))  # begins outside of every wedge
    begun: list[int] = []
    wedges = []
    for place in order.tolist():
        if not runs_up[place]:
            begun.append(place)
        elif begun:
            wedges.append((begun.pop(), place))
    return np.array(wedges, dtype=np.int64).reshape(-1, 2)
