"""Holes that a scanner left open: their edges, the surface around them, and their closing."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from autobalance.errors import SolidError
from autobalance.solid.csg.region import triangulated
from autobalance.solid.mesh.mesh import CHUNK, Mesh, hash_numbers
from autobalance.solid.roughness import off_paraboloid, unit_at_vertices
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# The surface around a hole of a scan: a plane, a cylinder, or a thin plate through the points there.


Surface = Literal["plane", "cylinder", "smooth", "bore"]
Lift = Callable[[Array], Array]
"""Moves points (n, 3) near a patch onto the surface."""

SIMPLER_SURFACE_LIMITS = (1.3, 2e-3)
"""A simpler surface is taken where its residual is no more than so many times, and mm above, another's."""
OFF_MM = 0.15
"""... and small: rougher surfaces are not judged anyhow."""
MIN_RADIUS_RATIO = 0.95
"""A cylinder's radius is at least half a hole's width over this."""
PLATE_POINTS = 400
"""Points that a thin plate goes by, at most."""
BLIND_ERROR_SHARE = 0.25
"""Error of a bore closed where the scanner saw no farther, as a share of its width, everywhere."""
MIN_FACING_COMPONENT = 0.45
"""Triangles at a rim that face along the hole by less than this on average lead into something."""


@dataclass(frozen=True, eq=False)
class HoleRim:
    """A rim: its vertices' rows in the sense in which a patch runs, its middle, direction and width."""

    rim: Indices
    centre: Array
    normal: Array
    width: float
    along: float


def surface_around(points: Array, normals: Array, hole: HoleRim) -> tuple[Surface, Lift, float]:
    """Return the kind of surface around a hole, the `Lift` onto it, and the spread of points about it."""
    if (
        hole.along < MIN_FACING_COMPONENT
    ):  # nothing around it goes on over it: the end of what the scanner saw of a bore
        return "smooth", lambda at: at, BLIND_ERROR_SHARE * hole.width
    middle, up = points.mean(axis=0), hole.normal
    flat = np.linalg.svd(points - middle, full_matrices=False)[2][2]
    flat = flat if flat @ up > 0.0 else -flat
    off_plane = _spread((points - middle) @ flat)
    bent = _spread(off_paraboloid(points - hole.centre, up))
    cylinder = _cylinder(points, normals, hole)
    factor, more = SIMPLER_SURFACE_LIMITS
    best = min(bent, off_plane, math.inf if cylinder is None else cylinder[1])
    most = min(factor * best + more, OFF_MM)
    if off_plane <= most:
        return "plane", lambda at: at - np.outer((at - middle) @ flat, flat), off_plane
    if cylinder is not None and cylinder[1] <= most:
        return "cylinder", cylinder[0], cylinder[1]
    return "smooth", _plate(points, hole), bent


def _spread(values: Array) -> float:
    """Return a robust standard deviation, from the median: fillets and edges lie around a hole too."""
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def _cylinder(points: Array, normals: Array, hole: HoleRim) -> tuple[Lift, float] | None:
    """Return the `Lift` onto the cylinder through points and their spread about it, if there is one."""
    from scipy.optimize import least_squares

    axis = np.linalg.eigh(normals.T @ normals)[1][:, 0]
    side = np.cross(axis, hole.normal)
    if np.linalg.norm(side) < 0.5:
        return None
    side /= np.linalg.norm(side)
    up = np.cross(side, axis)
    x, y, z = (points - hole.centre) @ side, (points - hole.centre) @ up, (points - hole.centre) @ axis
    rows = np.column_stack([x, y, np.ones_like(x)])
    a, b, c = np.linalg.lstsq(rows, x**2 + y**2, rcond=None)[0]
    radius = math.sqrt(max(c + 0.25 * (a * a + b * b), 1e-12))

    def away(values: Array) -> Array:
        cx, cy, sx, sy, r = values
        off: Array = np.hypot(x - cx - sx * z, y - cy - sy * z) - r
        return off

    fit = least_squares(away, [0.5 * a, 0.5 * b, 0.0, 0.0, radius], loss="soft_l1", f_scale=0.05)
    cx, cy, sx, sy, radius = fit.x
    if radius < 0.5 * hole.width / MIN_RADIUS_RATIO:
        return None
    turned = axis + sx * side + sy * up
    turned /= np.linalg.norm(turned)
    place = hole.centre + cx * side + cy * up

    def lift(at: Array) -> Array:
        arm = at - place
        arm -= np.outer(arm @ turned, turned)
        away = np.linalg.norm(arm, axis=1)
        lifted: Array = at + arm * ((radius - away) / np.maximum(away, 1e-12))[:, None]
        return lifted

    return lift, _spread(away(fit.x))


def _plate(points: Array, hole: HoleRim) -> Lift:
    """Return the `Lift` onto a thin plate over the plane of a rim, through the points around it."""
    from scipy.interpolate import RBFInterpolator

    side = np.cross(hole.normal, np.eye(3)[int(np.argmin(np.abs(hole.normal)))])
    side /= np.linalg.norm(side)
    axes = np.stack([side, np.cross(hole.normal, side)])
    chosen = points[:: max(1, len(points) // PLATE_POINTS)]
    local = chosen - hole.centre
    plate = RBFInterpolator(local @ axes.T, local @ hole.normal, smoothing=1e-3 * hole.width)

    def lift(at: Array) -> Array:
        arm = at - hole.centre
        height = plate(arm @ axes.T) - arm @ hole.normal
        lifted: Array = at + np.outer(height, hole.normal)
        return lifted

    return lift


# Open edges of a mesh: those that no two triangles share, and the rims that they make.


def is_closed(triangles: Indices) -> bool:
    """Return whether triangles (m, 3) run through each edge equally often in both directions.

    By sums of a hash of the edges, one for each direction: no sorting, and wrong once in 2⁶⁴ times.
    """
    count = int(triangles.max(initial=0)) + 1
    balance = np.zeros(1, dtype=np.uint64)
    for begin in range(0, len(triangles), CHUNK):
        start = np.ascontiguousarray(triangles[begin : begin + CHUNK].T)
        end = start[[1, 2, 0]]
        key = hash_numbers(np.minimum(start, end) * count + np.maximum(start, end))
        balance += np.where(start < end, key, ~key + np.uint64(1)).sum()  # two's complement: less the key
    return not balance.any()


def open_edges(triangles: Indices) -> Indices:
    """Return the edges (k, 2) that are not run through equally often in both directions."""
    if is_closed(triangles):  # as usual
        return np.zeros((0, 2), dtype=np.int64)
    start, end = triangles.reshape(-1), triangles[:, [1, 2, 0]].reshape(-1)
    key = np.minimum(start, end) * (int(triangles.max()) + 1) + np.maximum(start, end)
    upward = start < end
    ordered = np.sort(2 * key + upward)  # an edge and its twins stand side by side
    edge, sense = ordered >> 1, 2 * (ordered & 1) - 1
    first = np.flatnonzero(np.diff(edge, prepend=-1))
    unbalanced = edge.take(first[np.add.reduceat(sense, first) != 0])
    place = np.searchsorted(unbalanced, key).clip(max=len(unbalanced) - 1)
    rows = np.flatnonzero(unbalanced.take(place) == key)
    bad = rows[np.unique(key.take(rows), return_index=True)[1]]
    return np.stack([start[bad], end[bad]], axis=1)


def rims(edges: Indices) -> list[Indices]:
    """Chain the reversed open edges (k, 2) to closed loops; a rim that touches itself falls into several."""
    following: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        following.setdefault(end, []).append(start)
    loops: list[Indices] = []
    for first in list(following):
        path, seen = [first], {first: 0}
        while following.get(path[-1]):
            at = following[path[-1]].pop()
            if at in seen:  # a loop closes here: take it off the path
                loop, path = path[seen[at] :], path[: seen[at] + 1]
                for corner in loop[1:]:
                    del seen[corner]
                if len(loop) > 2:
                    loops.append(np.array(loop, dtype=np.int64))
            else:
                seen[at] = len(path)
                path.append(at)
    return loops


def doubled_area_vector(rim: Array) -> Array:
    """Return twice the area within a closed rim (k, 3), along its normal."""
    local = rim - rim.mean(axis=0)
    vector: Array = np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)
    return vector


# Permission to close holes of an open mesh.


@dataclass(frozen=True)
class OpenHoles:
    """Treatment of a mesh's holes: close those up to ``fill_mm`` wide; ``keep_open`` are bores' places.

    ``keep_open`` None: it is unknown which rims are bores; empty: none is.
    """

    fill_mm: float = 0.0
    keep_open: tuple[tuple[float, float, float], ...] | None = None


# Closing of holes that a scanner left open by the surface around them, or joining of a bore's two ends.
#
# A rim in a plane or a cylinder is closed by that surface, any other by a thin plate through the points
# around it (Duchon 1977). Where the triangles at a rim are along the hole the scanner looked into something:
# whether that is a bore is the user's to state.


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
class ClosedHole:
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


def filled(mesh: Mesh, allowed: OpenHoles) -> tuple[Mesh, tuple[ClosedHole, ...]]:
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


def listed(holes: Sequence[HoleRim]) -> str:
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


def _holes(mesh: Mesh) -> list[HoleRim]:
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
        holes.append(HoleRim(rim, corners.mean(axis=0), unit, width, along))
    return holes


# --- bores --------------------------------------------------------------------------------------------------
def _bores(holes: Sequence[HoleRim], allowed: OpenHoles) -> list[tuple[HoleRim, HoleRim]]:
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
    pairs: list[tuple[HoleRim, HoleRim]] = []
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


def _face_each_other(one: HoleRim, other: HoleRim) -> bool:
    """Return whether the line through both middles is on both rims of equal width."""
    way = other.centre - one.centre
    length = float(np.linalg.norm(way))
    alike = 0.7 < one.width / other.width < 1.0 / 0.7
    upright = min(abs(float(one.normal @ way)), abs(float(other.normal @ way))) > 0.8 * length
    return alike and upright and float(one.normal @ other.normal) < 0.0


def _tube(mesh: Mesh, one: HoleRim, other: HoleRim) -> Indices:
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


def _wall(mesh: Mesh, one: HoleRim, other: HoleRim) -> ClosedHole:
    length = float(np.linalg.norm(other.centre - one.centre))
    around = np.linalg.norm(np.diff(mesh.vertices.take([*one.rim, one.rim[0]], axis=0), axis=0), axis=1).sum()
    edge = around / len(one.rim)
    area = float(around) * length
    return ClosedHole(0.5 * (one.centre + other.centre), one.width, area, "bore", 0.1 * float(edge) * area)


# --- patches ------------------------------------------------------------------------------------------------
class _Surroundings:
    """Vertices around the holes of a mesh, with their directions."""

    def __init__(self, mesh: Mesh) -> None:
        from scipy.spatial import cKDTree

        self.mesh, self.normals = mesh, unit_at_vertices(mesh, mesh.area_vectors)
        self.tree = cKDTree(mesh.vertices)

    def patched(self, hole: HoleRim, count: int) -> tuple[Array, Indices, ClosedHole]:
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
        patch = ClosedHole(hole.centre, hole.width, area, surface, PATCH_SIGMAS_95 * area * off)
        return placed, rows[corners], patch

    def _around(self, rim: Array, normal: Array, reach: float) -> tuple[Array, Array]:
        rows = np.unique(np.concatenate([np.array(near) for near in self.tree.query_ball_point(rim, reach)]))
        same = rows[self.normals[rows] @ normal > SAME_SIDE]
        rows = same if len(same) >= len(rim) else rows
        return self.mesh.vertices.take(rows, axis=0), self.normals.take(rows, axis=0)


def _flat_patch(rim: Array, hole: HoleRim, edge: float) -> tuple[Array, Array, Indices]:
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
