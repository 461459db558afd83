"""Metal left around a hole, and its largest depth; pure numbers.

A hole is a cylinder with a cone (or a flat) at its end. Its wall is the distance from its surface to any
surface of the crank but the one it enters and that surface's continuation, which `surface` leaves out.
"""

from __future__ import annotations

import math

import numpy as np

from autobalance.types import Array
from autobalance.value_classes import dataclass

DEPTH_TOLERANCE_MM = 1e-3
"""Depths found here are short of the exact limit by at most this, never beyond it."""
SLACK_MM = 2e-5
"""Rounding of float32 files at crank size; a wall may be thinner by this."""
EQUAL_MM = 1e-9
"""Difference of two depths that counts as none: rounding of double precision."""
LEVELS = 30
"""Halvings of a piece of surface at most; if it is not resolved then the bound counts, on the safe side."""
MOST_PIECES = 400_000
"""Pieces at a time at most, as their tables take memory; beyond it the bound counts likewise."""


@dataclass(frozen=True)
class HoleLimits:
    """Limits of a hole: its wall, and its smallest and largest depth (of the full diameter).

    ``half_point_rad`` is half of the point angle; π/2 for a flat bottom.
    """

    wall_mm: float
    half_point_rad: float
    least_mm: float
    most_mm: float


def greatest_depth_mm(others: Array, radius_mm: float, room: HoleLimits) -> float:
    """Return the largest depth of a hole with its wall left all around; −inf if below the least.

    A point at distance s from the axis and depth τ is clear of a hole of depth t, inflated by the wall, when
    τ − φ(s) ≥ t, with φ the front of the inflated point. The smallest of that over all triangles is found by
    halving triangles. The exact smallest s and τ of each piece are the bound.

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

    The boxes around the triangles show that of all others: few of a fine mesh are left.
    """
    (low_x, high_x), (low_y, high_y), (low, high) = (
        (np.minimum(np.minimum(p, q), r), np.maximum(np.maximum(p, q), r))
        for p, q, r in (others[:, :, axis].T for axis in range(3))
    )
    s = np.hypot(np.maximum(low_x, np.maximum(-high_x, 0.0)), np.maximum(low_y, np.maximum(-high_y, 0.0)))
    near = np.flatnonzero((low < room.most_mm + front_mm) & (s < a + room.wall_mm))
    x, y, z = others[near, 0].T
    best = min(room.most_mm, float(clear_depth_mm(np.hypot(x, y), z, z, a, room).min(initial=math.inf)))
    undercut = clear_depth_mm(s[near], low[near], high[near], a, room) < best + EQUAL_MM
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
    """Return the reach at s, ahead of the shoulder, of a point of radius ``a`` inflated by the wall."""
    cos, sin, wall = math.cos(room.half_point_rad), math.sin(room.half_point_rad), room.wall_mm
    tip = a * cos / sin + np.sqrt(np.maximum(wall**2 - s**2, 0.0))
    cone = ((a - s) * cos + wall) / sin
    edge = np.sqrt(np.maximum(wall**2 - (s - a) ** 2, 0.0))
    return np.where(s <= wall * cos, tip, np.where(s <= a + wall * cos, cone, edge))


def _bound(pieces: Array, a: float, room: HoleLimits) -> Array:
    """Return a depth (k,) that no point of a piece undercuts; inf for pieces out of reach."""
    depth = pieces[:, :, 2]
    bound = clear_depth_mm(_distance_from_axis(pieces), depth.min(1), depth.max(1), a, room)
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
    return clear_depth_mm(np.hypot(points[:, :, 0], points[:, :, 1]), depth, depth, a, room)


def clear_depth_mm(s: Array, low: Array, high: Array, a: float, room: HoleLimits) -> Array:
    """Return the depth that surfaces at distance s from the axis, τ from low to high, allow."""
    above = high < -room.wall_mm  # in the drill's way, not beside the hole
    depth = np.where(above, -np.inf, low - _front(s, a, room))
    depth[s >= a + np.where(above, 0.0, room.wall_mm) - SLACK_MM] = np.inf
    return depth


def _distance_from_axis(pieces: Array) -> Array:
    """Return the least distance (k,) of triangles from the local axis, exactly."""
    corners = pieces[:, :, :2]
    onward = corners.take((1, 2, 0), axis=1)
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
