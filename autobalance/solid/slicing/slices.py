"""Cross-sections of a closed mesh at many heights at once, straight from its triangles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalance.solid.mesh.mesh import least_and_greatest, ranked
from autobalance.types import Array, Indices

Numbers = NDArray[np.unsignedinteger[Any]]

FEW_CORNERS = 16
"""Outlines of no more corners are left as they are."""
MIN_THINNING_GAIN = 0.9
"""Share of the corners left by a round of thinning below which another is worth its time."""


@dataclass(frozen=True, eq=False)
class Spans:
    """Places of triangles among heights: for each, the number of heights at or below its corners.

    ``low`` (m,) counts for the lowest corner, ``high`` for the highest; a height is crossed when its number
    is at least the first and less than the second.
    """

    low: Numbers
    high: Numbers

    @classmethod
    def of(cls, vertices: Array, triangles: Indices, heights_mm: Array) -> Spans:
        """Return the spans of triangles (m, 3) among increasing heights (k,)."""
        count = np.searchsorted(heights_mm, vertices[:, 2], side="right")
        return cls(*least_and_greatest(count.astype(np.min_scalar_type(len(heights_mm))), triangles))

    def among(self, chosen: Indices) -> Spans:
        """Return the spans among some of the heights, chosen by number, increasing."""
        fewer = np.searchsorted(chosen, np.arange(int(self.high.max()) + 1)).astype(self.low.dtype)
        return Spans(fewer.take(self.low), fewer.take(self.high))


def cross_sections(
    vertices: Array, triangles: Indices, heights_mm: Array, spans: Spans | None = None
) -> list[list[Array]]:
    """Cut a closed, outward mesh by planes z = const.

    A corner on the plane counts as above it, so that every section closes.

    Parameters
    ----------
    vertices : (n, 3) float
    triangles : (m, 3) int
    heights_mm : (k,) float
        Increasing [mm].
    spans : Spans, optional
        Of the triangles among the heights, where they are known.

    Returns
    -------
    list of k lists of (j, 2) float
        For each height the closed outlines: counter-clockwise around metal, clockwise around holes. Corners
        are where the plane meets the mesh's edges.
    """
    spans = spans or Spans.of(vertices, triangles, heights_mm)
    hit = np.flatnonzero(spans.low != spans.high)
    first = spans.low[hit].astype(np.int64)
    crossings = spans.high[hit] - first
    corner = np.repeat(triangles[hit], crossings, axis=0)
    before = np.cumsum(crossings) - crossings
    station = np.repeat(first - before, crossings) + np.arange(len(corner))
    start, end = crossed_edges(corner, vertices[corner, 2] >= heights_mm[station][:, None])
    points = _points_on(start, vertices, heights_mm[station])
    following = following_of(start, end, station, len(vertices))
    sections: list[list[Array]] = [[] for _ in heights_mm]
    for loop in _cycles(following):
        sections[int(station[loop[0]])].append(points[loop])
    return sections


def thinned(outline: Array, within_mm: float) -> Array:
    """Return a closed outline (k, 2) without the corners that are in line with those beside them.

    Of neighbours only one goes at a time, so that the outline moves by ``within_mm`` in a round at most, and
    a curve of many short chords keeps as many as that takes. Rounds end when little more is in line.
    """
    x, y = np.ascontiguousarray(outline.T)
    before = math.inf
    while FEW_CORNERS < len(x) < MIN_THINNING_GAIN * before:
        before = len(x)
        for first in (0, 1):
            along, across = _steps(x), _steps(y)
            u, v, p, q = along[:-1], across[:-1], along[1:], across[1:]  # sides before and after each corner
            aside = (u * q - v * p) ** 2 > within_mm**2 * ((p + u) ** 2 + (q + v) ** 2)
            aside[first::2] = True
            aside[-1] = True  # of an odd number, it and the first are of one kind
            x, y = x[aside], y[aside]
    return np.stack([x, y], axis=1)


def _steps(places: Array) -> Array:
    """Return the differences (k + 1,) of successive numbers (k,) on a closed way, the first repeated last."""
    steps = np.zeros(len(places) + 1)
    np.subtract(places[1:], places[:-1], out=steps[1:-1])
    steps[0] = steps[-1] = places[0] - places[-1]
    return steps


def crossed_edges(corner: Indices, up: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Return the edges (k, 2), lower number first, where a section enters and leaves triangles (k, 3).

    ``up`` (k, 3) marks corners above it; metal is on its left.
    """
    row = np.arange(len(corner))
    a, b, c = up.T
    lone = np.where(b == c, 0, np.where(a == c, 1, 2))
    lone_up = up[row, lone]
    i, j, k = (corner[row, (lone + step) % 3] for step in range(3))
    one = np.stack([np.minimum(i, j), np.maximum(i, j)], axis=1)
    other = np.stack([np.minimum(k, i), np.maximum(k, i)], axis=1)
    return np.where(lone_up[:, None], one, other), np.where(lone_up[:, None], other, one)


def _points_on(edges: Indices, vertices: Array, height: Array) -> Array:
    i, j = edges.T
    x, y, z = vertices.T
    share = (height - z[i]) / (z[j] - z[i])
    return np.stack([axis[i] + share * (axis[j] - axis[i]) for axis in (x, y)], axis=1)


def following_of(start: Indices, end: Indices, station: Indices, count: int) -> Indices:
    """Return the segment that follows each one: it begins on the edge where that ends, in the same section.

    Parameters
    ----------
    start, end : (k, 2) int
        Edges.
    station : (k,) int
        The section that each segment is in.
    count : int
        Vertices in all.
    """
    plane = station * (count * count)
    begins = ranked(plane + start[:, 0] * count + start[:, 1])[1]
    ends = ranked(plane + end[:, 0] * count + end[:, 1])[1]
    following = np.zeros(len(start), dtype=np.int64)
    following[ends] = begins
    return following


def _cycles(following: Indices) -> list[Indices]:
    """Return the cycles of a permutation, by their smallest members."""
    step = following.tolist()
    left = np.ones(len(step), dtype=bool)
    cycles = []
    start = 0
    while left[start:].any():
        start += int(left[start:].argmax())
        cycle = [start]
        place = step[start]
        while place != start:
            cycle.append(place)
            place = step[place]
        cycles.append(np.array(cycle))
        left[cycles[-1]] = False
    return cycles
