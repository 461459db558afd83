"""Metal left around a hole, measured on the solid's own triangles.

A hole is a cylinder with a cone (or a flat) at its end. Its wall is the distance from its surface to any
surface of the crank but the one it enters and that surface's continuation: the triangles around the mouth
that hang together and face the drill within `CONTINUATION_RAD`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autobalance.solid.mesh.components import components
from autobalance.solid.mesh.mesh import Array, Indices, Mesh

CONTINUATION_RAD = math.radians(40.0)
"""A surface that turns further away from the drill than this is another surface (a 45° chamfer is)."""
DEPTH_TOLERANCE_MM = 1e-3
"""Depths found here are short of the exact limit by at most this, never beyond it."""
SLACK_MM = 2e-5
"""Rounding of float32 files at crank size; a wall may be thinner by this."""
BLOCK = 256
"""Triangles of a block: neighbours in the mesh's order, so that one box tells of all that a line misses."""
SAMPLES = 2000
BESIDE_MM = 1e-3
"""A line meets no triangle that stays further away from it than this; ample for rounding."""
EQUAL_MM = 1e-9
LEVELS = 30
MOST_PIECES = 400_000


@dataclass(frozen=True)
class HoleLimits:
    """What a hole must keep: its wall, and depths that matter (of the full diameter).

    ``half_point_rad`` is half of the point angle; π/2 for a flat bottom.
    """

    wall_mm: float
    half_point_rad: float
    least_mm: float
    most_mm: float


@dataclass(frozen=True, eq=False)
class Axis:
    """Where a hole starts and which way it goes, rotor frame.

    Local coordinates are (x, y, τ): τ is the depth along ``inward`` (unit) from ``entry_mm``.
    """

    entry_mm: Array
    inward: Array

    @cached_property
    def placement(self) -> Array:
        """Rigid motion (4, 4) from local coordinates to the rotor frame."""
        u = self.inward
        a, b, c = u.tolist()  # np.cross of two vectors takes as long as all the rest
        x = np.array(((0.0, -c, b), (c, 0.0, -a), (-b, a, 0.0))[int(np.argmin(np.abs(u)))])
        x /= math.hypot(*x)
        d, e, f = x.tolist()
        place = np.eye(4)
        place[:3, 0], place[:3, 1] = x, (b * f - c * e, c * d - a * f, a * e - b * d)
        place[:3, 2], place[:3, 3] = u, self.entry_mm
        return place

    def local(self, points_mm: Array) -> Array:
        """Return points (..., 3) of the rotor frame in local coordinates."""
        place = self.placement
        flat = points_mm.reshape(-1, 3) - place[:3, 3]  # one product; numpy would do one a triangle
        out: Array = (flat @ place[:3, :3]).reshape(points_mm.shape)
        return out


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles of the crank's boundary in the rotor frame.

    ``corners`` (m, 3, 3) and ``centre`` (m, 3), ``reach`` (m,) the distance of the farthest corner from it;
    ``vertex`` (m, 3) tells which corners are one point.
    """

    corners: Array
    vertex: Indices
    centre: Array
    reach: Array

    @classmethod
    def of(cls, mesh: Mesh, file_to_rotor: Array) -> Surface:
        """Return the whole boundary of a mesh that is given in file coordinates."""
        corners = mesh.moved(file_to_rotor).corners
        a, b, c = (corners[:, k] for k in range(3))
        centre = (a + b + c) / 3.0
        arms = ((corner - centre).T for corner in (a, b, c))
        reach = np.sqrt(np.maximum.reduce([x * x + y * y + z * z for x, y, z in arms]))
        return cls(corners, mesh.triangles, centre, reach)

    @cached_property
    def _blocks(self) -> tuple[Array, Array]:
        """Centres (b, 3) of balls that hold each block of triangles, and their radii (b,)."""
        begins = np.arange(0, len(self.reach), BLOCK)
        low = np.minimum.reduceat(self.centre - self.reach[:, None], begins, axis=0)
        high = np.maximum.reduceat(self.centre + self.reach[:, None], begins, axis=0)
        return 0.5 * (low + high), 0.5 * np.linalg.norm(high - low, axis=1)

    def _in_blocks(self, chosen: NDArray[np.bool_]) -> Indices:
        """Return the rows of the triangles in the chosen ones (b,) of the blocks."""
        first = np.flatnonzero(chosen)[:, None] * BLOCK
        rows = (first + np.arange(BLOCK)).reshape(-1)
        return rows[rows < len(self.reach)]

    def within(self, z_low_mm: float, z_high_mm: float) -> Surface:
        """Return the triangles that reach into a slab."""
        a, b, c = self.corners[:, :, 2].T
        above = np.maximum(np.maximum(a, b), c) >= z_low_mm
        return self.take(np.flatnonzero(above & (np.minimum(np.minimum(a, b), c) <= z_high_mm)))

    def beside_plane(self, out: Array, across: Array) -> Indices:
        """Return the rows of triangles that may meet the half plane from the origin along ``out`` (3,).

        ``across`` (3,) is its normal; both are unit vectors.
        """
        if not len(self.reach):
            return np.zeros(0, dtype=np.int64)

        def may(centre: Array, reach: Array) -> NDArray[np.bool_]:
            meets: NDArray[np.bool_] = (np.abs(centre @ across) <= reach) & (centre @ out >= -reach)
            return meets

        centre, reach = self._blocks
        rows = self._in_blocks(may(centre, reach * (1.0 + EQUAL_MM) + EQUAL_MM))
        return rows[may(self.centre[rows], self.reach[rows])]

    def around(self, axis: Axis, radius_mm: float) -> Surface:
        """Return the triangles that may come within ``radius_mm`` of the line along an axis."""
        return self.take(self.beside(axis, radius_mm))

    def beside(self, axis: Axis, radius_mm: float) -> Indices:
        """Return the rows of the triangles that may come within ``radius_mm`` of the line along an axis."""
        if not len(self.reach):
            return np.zeros(0, dtype=np.int64)
        a, b, c = axis.inward.tolist()

        def may(centre: Array, reach: Array) -> NDArray[np.bool_]:
            x, y, z = (centre - axis.entry_mm).T
            off2 = (x * x + y * y + z * z) - (a * x + b * y + c * z) ** 2
            meets: NDArray[np.bool_] = off2 <= (radius_mm + reach) ** 2
            return meets

        centre, reach = self._blocks
        rows = self._in_blocks(may(centre, reach + BESIDE_MM))
        return rows[may(self.centre[rows], self.reach[rows])]

    def take(self, rows: Indices) -> Surface:
        """Return some of the triangles."""
        return Surface(self.corners[rows], self.vertex[rows], self.centre[rows], self.reach[rows])

    def hits(self, axis: Axis) -> tuple[Array, Indices]:
        """Return where the line along an axis meets the triangles: τ, ascending, and the triangles' rows."""
        beside = self.beside(axis, BESIDE_MM)
        depth, rows = met(axis.local(self.corners[beside]))
        return depth, beside[rows]

    def obliquity_rad(self, axis: Axis, entry_row: int) -> float:
        """Return the angle between an axis and the normal of the triangle that it enters."""
        a, b, c = self.corners[entry_row]
        normal = np.cross(b - a, c - a)
        return math.acos(min(max(-float(normal @ axis.inward) / float(np.linalg.norm(normal)), -1.0), 1.0))

    def may_hold(self, axis: Axis, radius_mm: float, room: HoleLimits) -> bool:
        """Tell whether a sample of the triangles leaves room for a hole of the least depth.

        Those that do not face the drill, for they are no continuation of the entry.
        """
        corners = self.corners[:: max(1, len(self.corners) // SAMPLES)]
        points = axis.local(corners[~_facing(corners, axis), 0])
        s, depth = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
        return not (_clear(s, depth, depth, radius_mm, room) < room.least_mm - EQUAL_MM).any()

    def others(self, axis: Axis, entry_row: int) -> tuple[Array | None, float]:
        """Return the triangles (k, 3, 3) that are no continuation of the entry, and the entry's least τ.

        Both in local coordinates; None where the entry itself is too slanted to start a drill on.
        """
        facing = _facing(self.corners, axis)
        if not facing[entry_row]:
            return None, 0.0
        rows = np.flatnonzero(facing)
        same = rows[_connected(self.vertex[rows], int(np.searchsorted(rows, entry_row)))]
        other = np.ones(len(self.corners), dtype=bool)
        other[same] = False
        local = axis.local(self.corners)
        return local[other], float(local[same][:, :, 2].min())


def _facing(corners: Array, axis: Axis) -> NDArray[np.bool_]:
    """Tell which triangles (m, 3, 3) face a drill along an axis within `CONTINUATION_RAD`."""
    ux, uy, uz = (corners[:, 1] - corners[:, 0]).T
    vx, vy, vz = (corners[:, 2] - corners[:, 0]).T
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(x * x + y * y + z * z)
    a, b, c = axis.inward.tolist()
    facing: NDArray[np.bool_] = -(a * x + b * y + c * z) >= math.cos(CONTINUATION_RAD) * length
    facing &= length > 0.0
    return facing


def met(local: Array) -> tuple[Array, Indices]:
    """Return where the local axis meets triangles (k, 3, 3): τ, ascending, and the triangles' rows."""
    a, b, c = local[:, 0, :2], local[:, 1, :2], local[:, 2, :2]
    weights = np.stack([cross2(b, c), cross2(c, a), cross2(a, b)], axis=1)
    total = weights.sum(1)
    across = np.abs(total) > 1e-12  # seen edge-on, a triangle is met through its neighbours
    weights = weights[across] / total[across, None]
    inside = (weights >= -1e-9).all(1)  # a line through an edge meets both its triangles
    rows = np.flatnonzero(across)[inside]
    depth = (weights[inside] * local[rows][:, :, 2]).sum(1)
    order = np.argsort(depth, kind="stable")
    return depth[order], rows[order]


def edge_pairs(vertex: Indices) -> tuple[Indices, Indices]:
    """Return the pairs of triangles (rows) that share an edge."""
    edges = np.sort(vertex[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(vertex)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    twin = np.flatnonzero((edges[1:] == edges[:-1]).all(1))
    return owner[twin], owner[twin + 1]


def _connected(vertex: Indices, start: int) -> NDArray[np.bool_]:
    """Tell which triangles hang together with triangle ``start`` through shared edges."""
    label = components(np.stack(edge_pairs(vertex), axis=1), len(vertex))
    same: NDArray[np.bool_] = label == label[start]
    return same


def greatest_depth_mm(others: Array, radius_mm: float, room: HoleLimits) -> float:
    """Return how deep a hole may go and leave its wall all around; −inf if not even the least.

    A point at distance s from the axis and depth τ is clear of a hole of depth t, inflated by the wall, when
    τ − φ(s) ≥ t, where φ is the front of the inflated point. The least of that over all triangles is found
    by halving triangles, with the exact least s and τ of each piece as a bound.

    Parameters
    ----------
    others : (k, 3, 3) float
        Triangles in local coordinates.

    Returns
    -------
    float
        Depth of the full diameter [mm]; at most `DEPTH_TOLERANCE_MM` short of the exact limit.
    """
    front = radius_mm / math.tan(room.half_point_rad) + 2.0 * room.wall_mm
    best, pieces = _deciding(others, radius_mm, room, front)
    if best < room.least_mm:
        return -math.inf
    bound = np.zeros(0)
    for _ in range(LEVELS):
        bound = _bound(pieces, radius_mm, room)
        best = min(best, float(_value(pieces, radius_mm, room).min(initial=math.inf)))
        if best < room.least_mm:
            return -math.inf
        still = bound < best - DEPTH_TOLERANCE_MM
        pieces, bound = pieces[still], bound[still]
        if len(pieces) == 0:
            break
        if len(pieces) > MOST_PIECES:  # not resolved: stay on the safe side
            best = min(best, float(bound.min()))
            break
        pieces = _halved(pieces)
    else:
        best = min(best, float(bound.min()))
    if best < room.most_mm:
        best -= DEPTH_TOLERANCE_MM
    return best if best >= room.least_mm else -math.inf


def _deciding(others: Array, a: float, room: HoleLimits, front_mm: float) -> tuple[float, Array]:
    """Return the depth that single corners allow, and the triangles (k, 3, 3) that may allow less.

    The boxes around the triangles tell that of all others: few of a fine mesh are left.
    """
    (low_x, high_x), (low_y, high_y), (low, high) = (
        (np.minimum(np.minimum(p, q), r), np.maximum(np.maximum(p, q), r))
        for p, q, r in (others[:, :, axis].T for axis in range(3))
    )
    s = np.hypot(np.maximum(low_x, np.maximum(-high_x, 0.0)), np.maximum(low_y, np.maximum(-high_y, 0.0)))
    near = np.flatnonzero((low < room.most_mm + front_mm) & (s < a + room.wall_mm))
    x, y, z = others[near, 0].T
    best = min(room.most_mm, float(_clear(np.hypot(x, y), z, z, a, room).min(initial=math.inf)))
    undercut = _clear(s[near], low[near], high[near], a, room) < best + EQUAL_MM
    return best, others[near[undercut]]


def wall_left_mm(others: Array, radius_mm: float, depth_mm: float, half_point_rad: float) -> float:
    """Return the least distance from a hole's surface to other surfaces, to `DEPTH_TOLERANCE_MM`."""
    low, high = 0.0, radius_mm
    while _fits(others, radius_mm, depth_mm, half_point_rad, high) and high < 1e3:
        low, high = high, 2.0 * high
    while high - low > DEPTH_TOLERANCE_MM:
        middle = 0.5 * (low + high)
        if _fits(others, radius_mm, depth_mm, half_point_rad, middle):
            low = middle
        else:
            high = middle
    return low


def _fits(others: Array, radius_mm: float, depth_mm: float, half_point_rad: float, wall_mm: float) -> bool:
    deep = depth_mm + DEPTH_TOLERANCE_MM
    return (
        greatest_depth_mm(others, radius_mm, HoleLimits(wall_mm, half_point_rad, depth_mm, deep)) >= depth_mm
    )


def _front(s: Array, a: float, room: HoleLimits) -> Array:
    """Return how far ahead of the shoulder a point of radius ``a``, inflated by the wall, reaches at s."""
    cos, sin, wall = math.cos(room.half_point_rad), math.sin(room.half_point_rad), room.wall_mm
    tip = a * cos / sin + np.sqrt(np.maximum(wall**2 - s**2, 0.0))
    cone = ((a - s) * cos + wall) / sin
    edge = np.sqrt(np.maximum(wall**2 - (s - a) ** 2, 0.0))
    return np.where(s <= wall * cos, tip, np.where(s <= a + wall * cos, cone, edge))


def _bound(pieces: Array, a: float, room: HoleLimits) -> Array:
    """Return a depth (k,) that no point of a piece undercuts; inf for pieces out of reach."""
    depth = pieces[:, :, 2]
    bound = _clear(_distance_from_axis(pieces), depth.min(1), depth.max(1), a, room)
    beside = np.isfinite(bound) & (depth.min(1) >= -room.wall_mm)
    bound[beside] = np.maximum(bound[beside], _tangent_bound(pieces[beside], a, room))
    return bound


def _tangent_bound(pieces: Array, a: float, room: HoleLimits) -> Array:
    """Return a bound (k,) from the tangent at the pieces' middles, since τ − φ(s) is convex; −inf: none.

    It closes in with the square of a piece's size, where the least s and τ only do so with the size.
    """
    middle = pieces.mean(axis=1)
    s = np.hypot(middle[:, 0], middle[:, 1])
    valid = s < a + room.wall_mm - SLACK_MM
    outward = middle[:, :2] / np.maximum(s, 1e-12)[:, None]
    along = ((pieces[:, :, :2] - middle[:, None, :2]) * outward[:, None]).sum(2)
    rise = (pieces[:, :, 2] - middle[:, None, 2]) - _front_slope(s, a, room)[:, None] * along
    value = middle[:, 2] - _front(s, a, room) + rise.min(axis=1)
    return np.where(valid, value, -np.inf)


def _front_slope(s: Array, a: float, room: HoleLimits) -> Array:
    """Return the derivative of ``_front`` with s, for s short of the radius and the wall."""
    cos, sin, wall = math.cos(room.half_point_rad), math.sin(room.half_point_rad), room.wall_mm
    tip = -s / np.sqrt(np.maximum(wall**2 - s**2, 1e-12))
    edge = -(s - a) / np.sqrt(np.maximum(wall**2 - (s - a) ** 2, 1e-12))
    return np.where(s <= wall * cos, tip, np.where(s <= a + wall * cos, -cos / sin, edge))


def _value(pieces: Array, a: float, room: HoleLimits) -> Array:
    """Return the depths that corners and middles of pieces allow (k, 4)."""
    points = np.concatenate([pieces, pieces.mean(axis=1, keepdims=True)], axis=1)
    depth = points[:, :, 2]
    return _clear(np.hypot(points[:, :, 0], points[:, :, 1]), depth, depth, a, room)


def _clear(s: Array, low: Array, high: Array, a: float, room: HoleLimits) -> Array:
    """Return the depth that surfaces at distance s from the axis, τ from low to high, allow."""
    above = high < -room.wall_mm  # in the drill's way, not beside the hole
    depth = np.where(above, -np.inf, low - _front(s, a, room))
    depth[s >= a + np.where(above, 0.0, room.wall_mm) - SLACK_MM] = np.inf
    return depth


def _distance_from_axis(pieces: Array) -> Array:
    """Return the least distance (k,) of triangles from the local axis, exactly."""
    corners = pieces[:, :, :2]
    onward = np.roll(corners, -1, axis=1)
    edge = onward - corners
    length2 = (edge**2).sum(2)
    share = np.clip(-(corners * edge).sum(2) / np.where(length2 > 0.0, length2, 1.0), 0.0, 1.0)
    nearest = corners + share[:, :, None] * edge
    distance: Array = np.hypot(nearest[:, :, 0], nearest[:, :, 1]).min(axis=1)
    turn = cross2(corners, onward)
    distance[(turn > 0.0).all(1) | (turn < 0.0).all(1)] = 0.0
    return distance


def _halved(pieces: Array) -> Array:
    """Return each triangle's four parts, one after the other (4k, 3, 3)."""
    a, b, c = pieces[:, 0], pieces[:, 1], pieces[:, 2]
    ab, bc, ca = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.stack([np.stack(part, axis=1) for part in parts], axis=1).reshape(-1, 3, 3)


def cross2(p: Array, q: Array) -> Array:
    """Return the z components of the cross products of vectors (..., 2)."""
    out: Array = p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]
    return out


def segments_distance_mm(p0: Array, p1: Array, q0: Array, q1: Array) -> Array:
    """Return the least distances (k,) between straight segments or points, pair by pair (k, 3).

    References
    ----------
    C. Ericson, *Real-Time Collision Detection*, 2005, 5.1.9.
    """
    d1, d2, r = p1 - p0, q1 - q0, p0 - q0
    a, e, f = (d1 * d1).sum(1), (d2 * d2).sum(1), (d2 * r).sum(1)
    b, c = (d1 * d2).sum(1), (d1 * r).sum(1)
    crossing = a * e - b * b
    slanted = crossing > 1e-12 * a * e
    s = np.clip(np.where(slanted, b * f - c * e, 0.0) / np.where(slanted, crossing, 1.0), 0.0, 1.0)
    t = np.clip((b * s + f) / np.where(e > 0.0, e, 1.0), 0.0, 1.0)
    s = np.clip((b * t - c) / np.where(a > 0.0, a, 1.0), 0.0, 1.0)
    gap = r + s[:, None] * d1 - t[:, None] * d2
    distance: Array = np.sqrt((gap * gap).sum(1))
    return distance
