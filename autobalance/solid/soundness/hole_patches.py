"""Closing of holes that a scanner left open by the surface around them, or joining of a bore's two ends.

A rim in a plane or a cylinder is closed by that surface, any other by a thin plate through the points around
it (Duchon 1977). Where the triangles at a rim are along the hole the scanner looked into something: whether
that is a bore is the user's to state.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.errors import SolidError
from autobalance.solid.csg.region import triangulated
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.roughness.estimate import unit_at_vertices
from autobalance.solid.soundness.hole_surfaces import MIN_FACING_COMPONENT, Hole, Surface, surface_around
from autobalance.solid.soundness.open_edges import doubled_area_vector, open_edges, rims
from autobalance.solid.soundness.open_holes import OpenHoles
from autobalance.types import Array, Indices

MAX_LISTED_HOLES = 6
"""Holes that a refusal lists."""
MIN_AREA = 1e-300
"""Smallest area, and addition to a length, of triangles so small that it is 0."""
MAX_RIM_WIDTH_SHARE = 0.4
"""Width of a rim, as a share of the mesh's diagonal, beyond which a part of the crank is missing."""
FIT_DISTANCE_SHARE = 0.7
"""Surfaces are fitted to points within this share of a hole's width of its rim ..."""
FIT_DISTANCE_EDGES = 4.0
"""... and at least so many of the rim's edges."""
SAME_SIDE = 0.2
"""Points are of the surface around a hole when their directions' part along the hole's is above this."""
PATCH_SIGMAS_95 = 2.0
"""A patch may be off by so many times the spread of its surroundings about its surface (95 %)."""
FINEST, LONGEST = 16.0, 1.5
"""A patch's edges are as long as its rim's, or its width over the first; at most the second times as long."""
NEIGHBOUR_WEIGHT = 0.35
"""A point midway between two follows each of them off the surface by so much: together less than they do."""


@dataclass(frozen=True, eq=False)
class Patch:
    """Closed hole: its centre (3,), its size, the surface that closes it, and the metal that may be off."""

    centre_mm: Array
    width_mm: float
    area_mm2: float
    surface: Surface
    volume_pm_mm3: float

    @property
    def text(self) -> str:
        """Note on the hole and its closing, in a line."""
        how = {
            "plane": "closed by the plane around it",
            "cylinder": "closed by the cylinder around it",
            "smooth": "closed by a smooth patch",
            "bore": "kept open: joined to the other end of the bore",
        }[self.surface]
        return (
            f"hole of {self.width_mm:.3g} mm around {_place(self.centre_mm)}, {self.area_mm2:.3g} mm²: {how}"
        )


def filled(mesh: Mesh, allowed: OpenHoles) -> tuple[Mesh, tuple[Patch, ...]]:
    """Close the holes of a mesh as far as ``allowed``; return it with the patches.

    Raises
    ------
    SolidError
        If one is wider than allowed, may be a bore that was not named, or is a bore without other end.
    """
    holes = _holes(mesh)
    if not holes or allowed.fill_mm <= 0.0:
        return mesh, ()
    wide = [hole for hole in holes if hole.width > allowed.fill_mm]
    if wide:
        raise SolidError(
            f"the mesh is open: {listed(wide)}; expected none wider than the {allowed.fill_mm:g} mm of"
            " fill_holes_mm (--fill-holes-mm)"
        )
    bores = _bores(holes, allowed)
    in_bores = {id(hole) for pair in bores for hole in pair}
    vertices, triangles, patches, count = [mesh.vertices], [mesh.triangles], [], len(mesh.vertices)
    for one, other in bores:
        triangles.append(_tube(mesh, one, other))
        patches.append(_wall(mesh, one, other))
    surroundings = _Surroundings(mesh)
    for hole in holes:
        if id(hole) not in in_bores:
            points, corners, patch = surroundings.patched(hole, count)
            count += len(points)
            vertices.append(points)
            triangles.append(corners)
            patches.append(patch)
    return Mesh(np.concatenate(vertices), np.concatenate(triangles)), tuple(patches)


def listed(holes: Sequence[Hole]) -> str:
    """Return the number of holes, with their widths and places, the widest first."""
    ordered = sorted(holes, key=lambda hole: -hole.width)
    shown = ", ".join(
        f"{hole.width:.3g} mm around {_place(hole.centre)}" for hole in ordered[:MAX_LISTED_HOLES]
    )
    more = ", ..." if len(holes) > MAX_LISTED_HOLES else ""
    return f"{len(holes)} hole{'s' * (len(holes) > 1)}: {shown}{more}"


def open_holes_text(mesh: Mesh) -> str:
    """Return a hint on the holes of an open mesh and their closing; empty if no open edges make a rim."""
    holes = _holes(mesh)
    if not holes:
        return ""
    if max(hole.width for hole in holes) > MAX_RIM_WIDTH_SHARE * mesh.diagonal_mm:
        return f"{listed(holes)}: a part of the crank only; scan it from all sides"
    return f"{listed(holes)}; fill_holes_mm (--fill-holes-mm) closes holes up to that width"


def _place(point: Array) -> str:
    x, y, z = point
    return f"({x:.4g}, {y:.4g}, {z:.4g}) mm"


def _holes(mesh: Mesh) -> list[Hole]:
    edges = open_edges(mesh.triangles)
    if len(edges) == 0:
        return []
    count = len(mesh.vertices)
    loose = np.isin(mesh.triangles, np.unique(edges)).sum(axis=1) >= 2
    rows = np.flatnonzero(loose)
    a, b, c = mesh.triangles.take(rows, axis=0).T
    owner = np.concatenate([rows, rows, rows])
    key = np.concatenate([a * count + b, b * count + c, c * count + a])
    order = np.argsort(key)
    holes = []
    for rim in rims(edges):
        corners = mesh.vertices.take(rim, axis=0)
        normal = doubled_area_vector(corners)
        size = float(np.linalg.norm(normal))
        width = float(np.linalg.norm(corners[:, None] - corners[None], axis=2).max())
        unit = normal / max(size, MIN_AREA)
        opposite = np.roll(rim, -1) * count + rim
        beside = owner[order[np.searchsorted(key, opposite, sorter=order).clip(max=len(key) - 1)]]
        areas = np.maximum(mesh.doubled_areas.take(beside), MIN_AREA)
        facing = mesh.area_vectors.take(beside, axis=0) / areas[:, None]
        length = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1) + MIN_AREA
        along = float(np.average(np.abs(facing @ unit), weights=length))
        holes.append(Hole(rim, corners.mean(axis=0), unit, width, along))
    return holes


# --- bores --------------------------------------------------------------------------------------------------
def _bores(holes: Sequence[Hole], allowed: OpenHoles) -> list[tuple[Hole, Hole]]:
    """Return pairs of rims that are the ends of one bore.

    Raises
    ------
    SolidError
        If a rim may be a bore's and none was named, or a named one has no other end.
    """
    if allowed.keep_open is None:
        doubtful = [hole for hole in holes if hole.along < MIN_FACING_COMPONENT]
        if doubtful:
            raise SolidError(
                f"the mesh is open, and may be at bores: {listed(doubtful)}; keep_open = [[x, y, z], ...]"
                " (--keep-open X,Y,Z) names a place at each bore, which is joined to its other end;"
                " keep_open = [] (--keep-open none) closes all"
            )
        return []
    pairs: list[tuple[Hole, Hole]] = []
    for place in allowed.keep_open:
        away = [float(np.linalg.norm(hole.centre - place)) for hole in holes]
        one = holes[int(np.argmin(away))]
        if min(away) > one.width:
            raise SolidError(
                f"keep_open names {_place(np.array(place))}; found no hole there: {listed(holes)}"
            )
        if any(one is hole for pair in pairs for hole in pair):
            continue
        ends = [hole for hole in holes if hole is not one and _face_each_other(one, hole)]
        if not ends:
            raise SolidError(
                f"keep_open names the hole around {_place(one.centre)}; found no other end of a bore opposite"
                " to it: scan a blind bore again, or model it"
            )
        pairs.append((one, min(ends, key=lambda hole: float(np.linalg.norm(hole.centre - one.centre)))))
    return pairs


def _face_each_other(one: Hole, other: Hole) -> bool:
    """Return whether the line through both middles is on both rims of equal width."""
    way = other.centre - one.centre
    length = float(np.linalg.norm(way))
    alike = 0.7 < one.width / other.width < 1.0 / 0.7
    upright = min(abs(float(one.normal @ way)), abs(float(other.normal @ way))) > 0.8 * length
    return alike and upright and float(one.normal @ other.normal) < 0.0


def _tube(mesh: Mesh, one: Hole, other: Hole) -> Indices:
    """Return triangles (k, 3) of a straight wall between two rims."""
    first, second = one.rim, other.rim[::-1]
    start = mesh.vertices.take(second, axis=0) - mesh.vertices[first[0]]
    along = other.centre - one.centre
    start -= np.outer(start @ along / (along @ along), along)
    second = np.roll(second, -int(np.argmin(np.linalg.norm(start, axis=1))))
    near, far = (mesh.vertices.take([*rim, rim[0]], axis=0) for rim in (first, second))
    i = j = 0
    corners = []
    while i < len(first) or j < len(second):
        a, b = first[i % len(first)], second[j % len(second)]
        onward = i < len(first) and (
            j == len(second) or np.linalg.norm(near[i + 1] - far[j]) <= np.linalg.norm(near[i] - far[j + 1])
        )
        if onward:
            i += 1
            corners.append((a, first[i % len(first)], b))
        else:
            j += 1
            corners.append((second[j % len(second)], b, a))
    return np.array(corners, dtype=np.int64)


def _wall(mesh: Mesh, one: Hole, other: Hole) -> Patch:
    length = float(np.linalg.norm(other.centre - one.centre))
    around = np.linalg.norm(np.diff(mesh.vertices.take([*one.rim, one.rim[0]], axis=0), axis=0), axis=1).sum()
    edge = around / len(one.rim)
    area = float(around) * length
    return Patch(0.5 * (one.centre + other.centre), one.width, area, "bore", 0.1 * float(edge) * area)


# --- patches ------------------------------------------------------------------------------------------------
class _Surroundings:
    """Vertices around the holes of a mesh, with their directions."""

    def __init__(self, mesh: Mesh) -> None:
        from scipy.spatial import cKDTree

        self.mesh, self.normals = mesh, unit_at_vertices(mesh, mesh.area_vectors)
        self.tree = cKDTree(mesh.vertices)

    def patched(self, hole: Hole, count: int) -> tuple[Array, Indices, Patch]:
        """Return a hole's new vertices, numbered from ``count``, its new triangles, and the patch."""
        rim = self.mesh.vertices.take(hole.rim, axis=0)
        edge = float(np.linalg.norm(rim - np.roll(rim, 1, axis=0), axis=1).mean())
        points, normals = self._around(
            rim, hole.normal, max(FIT_DISTANCE_SHARE * hole.width, FIT_DISTANCE_EDGES * edge)
        )
        surface, lift, off = surface_around(points, normals, hole)
        flat, shares, corners = _flat_patch(rim, hole, max(edge, hole.width / FINEST))
        inner = flat[len(rim) :]
        placed = lift(inner) + shares[len(rim) :] @ (rim - lift(rim)) if len(inner) else inner
        rows = np.concatenate([hole.rim, count + np.arange(len(inner))])
        both = np.concatenate([rim, placed])[corners]
        doubled = np.cross(both[:, 1] - both[:, 0], both[:, 2] - both[:, 0])
        area = 0.5 * float(np.linalg.norm(doubled, axis=1).sum())
        if surface == "smooth" and len(inner):
            off = max(off, 0.5 * float(np.abs((placed - inner) @ hole.normal).max()))
        patch = Patch(hole.centre, hole.width, area, surface, PATCH_SIGMAS_95 * area * off)
        return placed, rows[corners], patch

    def _around(self, rim: Array, normal: Array, reach: float) -> tuple[Array, Array]:
        rows = np.unique(np.concatenate([np.array(near) for near in self.tree.query_ball_point(rim, reach)]))
        same = rows[self.normals[rows] @ normal > SAME_SIDE]
        rows = same if len(same) >= len(rim) else rows
        return self.mesh.vertices.take(rows, axis=0), self.normals.take(rows, axis=0)


def _flat_patch(rim: Array, hole: Hole, edge: float) -> tuple[Array, Array, Indices]:
    """Return points (n, 3) of a flat patch, the rim's first, their shares of the rim's (n, m), and triangles.

    The rim is closed between its own corners; then edges inside are halved until none is much longer than
    ``edge``. A point follows the rim's corners off the surface by its shares of them: less and less.
    """
    flat = rim - np.outer((rim - hole.centre) @ hole.normal, hole.normal)
    axes = np.linalg.svd(flat - hole.centre, full_matrices=False)[2][:2]
    if np.cross(axes[0], axes[1]) @ hole.normal < 0.0:
        axes = axes[::-1]
    points, shares = list(flat), list(np.eye(len(rim)))
    corners = [tuple(row) for row in triangulated((flat - hole.centre) @ axes.T).reshape(-1, 3).tolist()]
    around = {frozenset((k, (k + 1) % len(rim))) for k in range(len(rim))}
    long = [
        (float(np.linalg.norm(points[a] - points[b])), a, b)
        for a, b in {tuple(sorted(side)) for row in corners for side in _sides(row)}
        if frozenset((a, b)) not in around
    ]
    heapq.heapify(queue := [(-length, a, b) for length, a, b in long])
    beside: dict[frozenset[int], list[int]] = {}
    for number, row in enumerate(corners):
        for side in _sides(row):
            beside.setdefault(frozenset(side), []).append(number)
    while queue and -queue[0][0] > LONGEST * edge:
        _, a, b = heapq.heappop(queue)
        middle = len(points)
        points.append(0.5 * (points[a] + points[b]))
        shares.append(NEIGHBOUR_WEIGHT * (shares[a] + shares[b]))
        for number in beside.pop(frozenset((a, b))):
            row = corners[number]
            corners[number] = tuple(middle if corner == b else corner for corner in row)
            corners.append(tuple(middle if corner == a else corner for corner in row))
            (apex,) = set(row) - {a, b}
            beside.setdefault(frozenset((a, middle)), []).append(number)
            beside.setdefault(frozenset((b, middle)), []).append(len(corners) - 1)
            beside[frozenset((middle, apex))] = [number, len(corners) - 1]
            other = beside[frozenset((b, apex))]
            other[other.index(number)] = len(corners) - 1
            heapq.heappush(queue, (-float(np.linalg.norm(points[middle] - points[apex])), middle, apex))
        half = float(np.linalg.norm(points[middle] - points[a]))
        for end in (a, b):
            heapq.heappush(queue, (-half, end, middle))
    return np.array(points), np.array(shares), np.array(corners, dtype=np.int64)


def _sides(row: Sequence[int]) -> tuple[tuple[int, int], ...]:
    return (row[0], row[1]), (row[1], row[2]), (row[2], row[0])
