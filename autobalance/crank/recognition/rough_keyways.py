"""A keyway in a scanned shaft: a floor and two walls fitted to triangles below the shaft's own surface."""

from __future__ import annotations

import math

import numpy as np

from autobalance.solid.mesh.mesh import components
from autobalance.types import Array, Indices

SUNK_RADII, SUNK_MM = 0.03, 0.3
"""Triangles below the shaft's surface by this share of its radius, or by so much, do not belong to it."""
MAX_DEPTH_RATIO = 0.7
"""Triangles nearer to the axis than the radius less this share of it belong to a bore along it."""
FACING_COSINE = math.cos(math.radians(35.0))
"""Triangles of floor and walls face within 35° as they should: noise turns small ones by as much."""
PARALLEL_WALL_COSINE = math.cos(math.radians(5.0))
"""The fitted walls look at each other within 5°."""
MAX_AXIAL_COMPONENT = 0.35
"""They are parallel to the axis: the axial part of their triangles' directions is at most this."""
MAX_OVERRUN_RADII = 0.3
"""A shaft reaches so many radii past the last sections that show its circle, at most."""
OUTLIER_RATIO = 3.0
"""Points that are off a wall by more than so many times the usual are of its corners."""
MIN_TRIANGLES = 8
"""Smallest number of triangles on a floor or a wall; fewer may be chance."""


class RoughKeyway:
    """A slot in a shaft, in axes turned to the crank's: angle [rad], width, depth, radius and ends [mm]."""

    def __init__(
        self, angle_rad: float, width: float, depth: float, radius: float, z: tuple[float, float]
    ) -> None:
        self.angle_rad, self.width, self.depth, self.radius, self.z = angle_rad, width, depth, radius, z


def rough_keyway(
    vertices: Array, triangles: Indices, normals: Array, shaft: Array, keys: tuple[tuple[float, float], ...]
) -> RoughKeyway | None:
    """Return the one keyway in a shaft; None without.

    Parameters
    ----------
    vertices : (n, 3) float
        Of the mesh, z along the crank axis, which is x = y = 0 [mm].
    triangles : (m, 3) int
    normals : (m, 3) float
        Their directions.
    shaft : (k, 2) float
        Heights, rising, and the shaft's radii there [mm].
    keys : two pairs of float
        Smallest and largest width and depth as shares of the shaft's diameter.
    """
    corners = vertices.take(triangles, axis=0)
    middle = corners.mean(axis=1)
    past = MAX_OVERRUN_RADII * float(shaft[:, 1].mean())
    inside = (middle[:, 2] > shaft[0, 0] - past) & (middle[:, 2] < shaft[-1, 0] + past)
    rows = np.flatnonzero(inside)
    below = np.interp(middle[rows, 2], *shaft.T)
    away = np.hypot(*middle[rows, :2].T)
    sunk = (below - away > np.maximum(SUNK_RADII * below, SUNK_MM)) & (away > (1.0 - MAX_DEPTH_RATIO) * below)
    sunk &= np.abs(normals[rows, 2]) < MAX_AXIAL_COMPONENT
    rows = rows[sunk]
    number = _connected(triangles.take(rows, axis=0), len(vertices))
    for each in np.flatnonzero(np.bincount(number) >= 3 * MIN_TRIANGLES):
        own = rows[number == each]
        key = _as_key(corners[own], normals[own], shaft, keys)
        if key is not None:
            return key
    return None


def _connected(triangles: Indices, vertices: int) -> Indices:
    """Return for each triangle the number of its connected piece of surface."""
    lowest = components(triangles, vertices).take(triangles[:, 0])
    piece: Indices = np.unique(lowest, return_inverse=True)[1]
    return piece


def _as_key(
    corners: Array, facing: Array, shaft: Array, keys: tuple[tuple[float, float], ...]
) -> RoughKeyway | None:
    """Return the keyway of triangles with corners (n, 3, 3) and directions (n, 3); None if they form none."""
    place = corners.mean(axis=1)
    out = _unit((place[:, :2] / np.hypot(*place[:, :2].T)[:, None]).sum(axis=0))
    walls: list[Indices] = []
    for _ in range(3):
        across = np.array([-out[1], out[0]])
        aside, look = place[:, :2] @ across, facing[:, :2] @ across
        walls = [
            np.flatnonzero((sign * look < -FACING_COSINE) & (sign * aside > 0.0)) for sign in (-1.0, 1.0)
        ]
        walls = [_without_corners(wall, aside) for wall in walls if len(wall) >= MIN_TRIANGLES]
        if len(walls) < 2:
            return None
        towards = [_unit(_line(place[wall, :2], out)) for wall in walls]
        if float(towards[0] @ towards[1]) < PARALLEL_WALL_COSINE:
            return None
        out = _unit(sum(place[wall, :2].mean(axis=0) for wall in walls))  # surer than such short walls
    across = np.array([-out[1], out[0]])
    left, right = (float(np.median(place[wall, :2] @ across)) for wall in walls)
    floor = np.flatnonzero(facing[:, :2] @ out > FACING_COSINE)
    floor = floor[np.abs(place[floor, :2] @ across - 0.5 * (left + right)) < 0.4 * (right - left)]
    if len(floor) < MIN_TRIANGLES:
        return None
    z = corners[np.concatenate(walls), :, 2]
    radius = float(np.interp(np.median(z), *shaft.T))
    found = RoughKeyway(
        math.atan2(out[1], out[0]),
        right - left,
        radius - float(np.median(place[floor, :2] @ out)),
        radius,
        (float(z.min()), float(z.max())),
    )
    shares = found.width / (2.0 * radius), found.depth / (2.0 * radius)
    sized = all(low <= share <= high for share, (low, high) in zip(shares, keys, strict=True))
    centred = abs(left + right) < 0.2 * found.width
    return found if sized and centred and found.z[1] - found.z[0] > found.width else None


def _without_corners(wall: Indices, aside: Array) -> Indices:
    """Return the rows of a wall near its median plane."""
    off = np.abs(aside[wall] - np.median(aside[wall]))
    kept: Indices = wall[off <= OUTLIER_RATIO * max(float(np.median(off)), 1e-6)]
    return kept


def _line(points: Array, out: Array) -> Array:
    """Return the direction (2,) of points (n, 2) in a row, outward."""
    way = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    along: Array = way if float(way @ out) > 0.0 else -way
    return along


def _unit(vector: Array) -> Array:
    unit: Array = vector / np.linalg.norm(vector)
    return unit
