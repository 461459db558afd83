"""Cross-sections of a closed mesh at many heights at once, straight from its triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalance.solid.mesh import Array, Indices


def cross_sections(vertices: Array, triangles: Indices, heights_mm: Array) -> list[list[Array]]:
    """Cut a closed, outward mesh by planes z = const.

    A corner on the plane counts as above it, so that every section closes whatever lies on the plane.

    Parameters
    ----------
    vertices : (n, 3) float
    triangles : (m, 3) int
    heights_mm : (k,) float
        Increasing [mm].

    Returns
    -------
    list of k lists of (j, 2) float
        For each height the closed outlines: counter-clockwise around metal, clockwise around holes. Corners
        stand where the plane meets the mesh's edges.
    """
    z = vertices[:, 2]
    at = z[triangles]
    low = np.minimum(np.minimum(at[:, 0], at[:, 1]), at[:, 2])
    high = np.maximum(np.maximum(at[:, 0], at[:, 1]), at[:, 2])
    first = np.searchsorted(heights_mm, low, side="right")
    crossings = np.searchsorted(heights_mm, high, side="right") - first
    hit = np.flatnonzero(crossings)
    crossings = crossings[hit]
    corner = np.repeat(triangles[hit], crossings, axis=0)
    before = np.cumsum(crossings) - crossings
    station = np.repeat(first[hit] - before, crossings) + np.arange(len(corner))
    start, end = _crossed_edges(corner, z[corner] >= heights_mm[station][:, None])
    points = _points_on(start, vertices, heights_mm[station])
    following = _following(start, end, station, len(vertices))
    sections: list[list[Array]] = [[] for _ in heights_mm]
    for loop in _cycles(following):
        sections[int(station[loop[0]])].append(points[loop])
    return sections


def _crossed_edges(corner: Indices, up: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Return the edges (k, 2) where the section enters and leaves each triangle, metal on its left."""
    row = np.arange(len(corner))
    a, b, c = up.T
    lone = np.where(b == c, 0, np.where(a == c, 1, 2))
    lone_up = up[row, lone]
    i, j, k = (corner[row, (lone + step) % 3] for step in range(3))
    one = np.stack([np.minimum(i, j), np.maximum(i, j)], axis=1)
    other = np.stack([np.minimum(k, i), np.maximum(k, i)], axis=1)
    return np.where(lone_up[:, None], one, other), np.where(lone_up[:, None], other, one)


def _points_on(edges: Indices, vertices: Array, height: Array) -> Array:
    a, b = vertices[edges[:, 0]], vertices[edges[:, 1]]
    share = (height - a[:, 2]) / (b[:, 2] - a[:, 2])
    points: Array = a[:, :2] + share[:, None] * (b[:, :2] - a[:, :2])
    return points


def _following(start: Indices, end: Indices, station: Indices, count: int) -> Indices:
    """Return for each segment the one that begins on the edge where it ends."""
    plane = station * (count * count)
    begins = np.argsort(plane + start[:, 0] * count + start[:, 1])
    ends = np.argsort(plane + end[:, 0] * count + end[:, 1])
    following = np.zeros(len(start), dtype=np.int64)
    following[ends] = begins
    return following


def _cycles(following: Indices) -> list[list[int]]:
    step = following.tolist()
    seen = bytearray(len(step))
    cycles = []
    for start in range(len(step)):
        if seen[start]:
            continue
        cycle = []
        place = start
        while not seen[place]:
            seen[place] = 1
            cycle.append(place)
            place = step[place]
        cycles.append(cycle)
    return cycles
