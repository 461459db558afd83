"""Exact mass moments of the part of a solid between two heights, straight from its triangles.

No boolean: triangles are clipped to the slab, and each spans a tetrahedron with a point of the lower plane,
to which that plane's cut face adds nothing. The upper plane's cut face is known from the edges that clipping
leaves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.rotor.moments import Moments
from autobalance.solid.measure import volume_moments
from autobalance.solid.mesh import Array, Indices


@dataclass(frozen=True, eq=False)
class Part:
    """Which metal of a slab counts: within a cylinder along z that bounds it there, or on one side of z.

    ``centre`` (2,) and ``radius_mm`` of the cylinder: no surface may cross it in the slab; ``side`` (2,):
    only where (x, y) · side ≥ 0.
    """

    centre: Array | None = None
    radius_mm: float = 0.0
    side: Array | None = None


EVERYTHING = Part()


def slab_moments(
    vertices: Array,
    triangles: Indices,
    z_range_mm: tuple[float, float],
    density_g_mm3: float,
    part: Part = EVERYTHING,
) -> Moments:
    """Return the mass moments about the origin of the metal between two heights.

    Parameters
    ----------
    vertices : (n, 3) float
        Of a closed, outward mesh [mm].
    triangles : (m, 3) int
    z_range_mm : (float, float)
        Lower and upper height [mm].
    density_g_mm3 : float
    part : Part
        Leaves part of the metal out.
    """
    z_low, z_high = z_range_mm
    if not z_high > z_low:
        return Moments.zero()
    apex = np.array([0.0, 0.0, z_low])
    a, b, c = (vertices[column, 2] for column in triangles.T)
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    inside = (low >= z_low) & (high < z_high) if part is EVERYTHING else np.zeros(len(low), dtype=bool)
    met = (high > z_low) & (low < z_high) & ~inside
    soup = _clipped(vertices[triangles[met]] - apex, np.array([0.0, 0.0, 1.0]), 0.0)
    edges = _upper_edges(soup, z_high - z_low)
    soup = _clipped(soup, np.array([0.0, 0.0, -1.0]), z_low - z_high)
    if part.centre is not None:
        soup, edges = (_within(item, part.centre, part.radius_mm) for item in (soup, edges))
    if part.side is not None:
        soup = _clipped(soup, np.array([*part.side, 0.0]), 0.0)
        edges = _clipped_edges(edges, part.side)
    local = volume_moments(soup.reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3))
    local = local + _cone(edges, z_high - z_low)
    if inside.any():
        local = local + volume_moments(vertices - apex, triangles[inside])
    local = local.scaled(density_g_mm3)
    back = np.eye(4)
    back[:3, 3] = apex
    return local.moved(back)


def _clipped(soup: Array, normal: Array, height: float) -> Array:
    """Return the parts of loose triangles (k, 3, 3) with normal · r ≥ height."""
    over = soup @ normal - height
    keep = over >= 0.0
    count = keep.sum(axis=1)
    parts = [soup[count == 3]]
    for wanted in (1, 2):
        rows = np.flatnonzero(count == wanted)
        lone = (keep[rows] if wanted == 1 else ~keep[rows]).argmax(axis=1)
        turn = (lone[:, None] + np.arange(3)) % 3
        p, q, r = (soup[rows, turn[:, k]] for k in range(3))
        hp, hq, hr = (over[rows, turn[:, k]] for k in range(3))
        pq = p + (hp / (hp - hq))[:, None] * (q - p)
        pr = p + (hp / (hp - hr))[:, None] * (r - p)
        if wanted == 1:
            parts.append(np.stack([p, pq, pr], axis=1))
        else:
            parts += [np.stack([pq, q, r], axis=1), np.stack([pq, r, pr], axis=1)]
    return np.concatenate(parts)


def _upper_edges(soup: Array, height: float) -> Array:
    """Return the edges (k, 2, 2) of the section at ``height``, metal on their left, of loose triangles.

    A corner on the plane counts as above it: what lies on the plane is the section just below.
    """
    up = soup[:, :, 2] >= height
    count = up.sum(axis=1)
    parts = []
    for wanted in (1, 2):
        rows = np.flatnonzero(count == wanted)
        lone = (up[rows] if wanted == 1 else ~up[rows]).argmax(axis=1)
        turn = (lone[:, None] + np.arange(3)) % 3
        p, q, r = (soup[rows, turn[:, k]] for k in range(3))
        share_q, share_r = ((height - p[:, 2]) / (s[:, 2] - p[:, 2]) for s in (q, r))
        pq = (p + share_q[:, None] * (q - p))[:, :2]
        pr = (p + share_r[:, None] * (r - p))[:, :2]
        parts.append(np.stack([pq, pr] if wanted == 1 else [pr, pq], axis=1))
    return np.concatenate(parts)


def _within(items: Array, centre: Array, radius: float) -> Array:
    away = np.linalg.norm(items.mean(axis=1)[:, :2] - centre, axis=1)
    kept: Array = items[away <= radius]
    return kept


def _clipped_edges(edges: Array, side: Array) -> Array:
    """Return the parts of edges on one side of the origin; what closes them lies in line with it."""
    over = edges @ side
    edges, over = edges[(over >= 0.0).any(axis=1)], over[(over >= 0.0).any(axis=1)]
    p, q = edges[:, 0], edges[:, 1]
    fall = over[:, 0] - over[:, 1]
    share = (over[:, 0] / np.where(fall == 0.0, 1.0, fall))[:, None]
    cut = p + share * (q - p)
    start = np.where(over[:, :1] < 0.0, cut, p)
    end = np.where(over[:, 1:] < 0.0, cut, q)
    return np.stack([start, end], axis=1)


def _cone(edges: Array, height: float) -> Moments:
    """Return volume and moments of the cone from the origin to a flat region at z = ``height``."""
    p, q = edges[:, 0], edges[:, 1]
    det = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    total = p + q
    area = float(det.sum()) / 2.0
    flat_first = det @ total / 6.0
    flat_second = (
        sum(((det[:, None] * corner).T @ corner for corner in (total, p, q)), np.zeros((2, 2))) / 24.0
    )
    first = np.array([*flat_first, height * area])
    second = np.zeros((3, 3))
    second[:2, :2] = flat_second
    second[:2, 2] = second[2, :2] = height * flat_first
    second[2, 2] = height**2 * area
    return Moments(height * area / 3.0, height * first / 4.0, height * second / 5.0)
