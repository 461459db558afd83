"""Cross-sections of a closed mesh at many heights at once, and the part between two heights."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.mesh.measure import Stretches
from autobalance.solid.mesh.mesh import CHUNK, least_and_greatest, ranked, summed
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Cross-sections of a closed mesh at many heights at once, straight from its triangles.


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


# Exact mass moments of the part of a solid between two heights, straight from its triangles.
#
# No boolean: triangles are clipped to the slab, and each spans a tetrahedron with a point of the lower
# plane, to which that plane's cut face adds nothing. The upper plane's cut face is known from the edges that
# clipping leaves.


@dataclass(frozen=True, eq=False)
class SlabPart:
    """Metal of a slab that counts: within a cylinder along z that bounds it there, or on one side of z.

    ``centre`` (2,) and ``radius_mm`` of the cylinder: no surface may cross it in the slab; ``side`` (2,):
    only where (x, y) · side ≥ 0.
    """

    centre: Array | None = None
    radius_mm: float = 0.0
    side: Array | None = None


WHOLE_SLAB = SlabPart()


@dataclass(frozen=True, eq=False)
class Slab:
    """A closed, outward mesh ready to be measured between many pairs of heights.

    ``vertices`` (n, 3) [mm], ``triangles`` (m, 3); corners within ``rounding_mm`` of a slab's plane are taken
    to lie on it.
    """

    vertices: Array
    triangles: Indices
    rounding_mm: float = 0.0

    @cached_property
    def _stretches(self) -> Stretches:
        """Smallest and largest z (m,) of each triangle."""
        return Stretches.of(self._axes[2], self.triangles)

    @cached_property
    def _axes(self) -> Array:
        """The vertices' x, y and z (3, n)."""
        return np.ascontiguousarray(self.vertices.T)

    def moments(
        self, z_range_mm: tuple[float, float], density_g_mm3: float, part: SlabPart = WHOLE_SLAB
    ) -> Moments:
        """Return the mass moments about the origin of the metal between two heights.

        Parameters
        ----------
        z_range_mm : (float, float)
            Lower and upper height [mm].
        density_g_mm3 : float
        part : SlabPart
            Part of the metal that counts.
        """
        z_low, z_high = z_range_mm
        if not z_high > z_low:
            return Moments.zero()
        reach = self._stretches
        height = z_high - z_low
        grain = min(self.rounding_mm, 0.01 * height)
        rows = reach.within(z_low + grain, z_high - grain)
        low, high = reach.least.take(rows), reach.greatest.take(rows)
        inside = (low >= z_low - grain) & (high <= z_high + grain) & (part.centre is None)
        if part.side is not None:
            beyond, before = self._on_side(rows, part.side)
            inside &= beyond
            there = np.flatnonzero(~before)
            rows, inside, high = rows.take(there), inside.take(there), high.take(there)
        whole, touching, crossing = rows[inside], rows[inside & (high >= z_high - grain)], rows[~inside]
        if part.centre is not None:
            crossing = crossing[self._meets(crossing, part.centre, part.radius_mm)]
        below, soup = (
            np.ascontiguousarray(self._corners(some, z_low, height, grain).T) for some in (touching, crossing)
        )
        volume = _slab_of_soup(soup, below, height, part) + summed(
            self._corners(whole[start : start + CHUNK], z_low, height, grain).swapaxes(0, 1)
            for start in range(0, len(whole), CHUNK)
        )
        local = volume.scaled(density_g_mm3)
        back = np.eye(4)
        back[2, 3] = z_low
        return local.moved(back)

    def _corners(self, rows: Indices, z_low: float, height: float, grain: float) -> Array:
        """Return axes × corners (3, 3, k) of triangles as seen from a slab's lower plane.

        Those within rounding of the slab's planes are on them.
        """
        corners = self._axes.take(self.triangles.take(rows, axis=0).T, axis=1)
        z = corners[2]
        z -= z_low
        for plane in (0.0, height):
            z[np.abs(z - plane) <= grain] = plane
        return corners

    def _on_side(self, rows: Indices, side: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Mark the triangles (k,) with all corners on a side of the axis, and those without one there."""
        over = side[0] * self._axes[0] + side[1] * self._axes[1] >= 0.0
        a, b, c = over.take(self.triangles.take(rows, axis=0).T)
        return a & b & c, ~(a | b | c)

    def _meets(self, rows: Indices, centre: Array, radius: float) -> NDArray[np.bool_]:
        """Mark the triangles (k,) whose boxes meet that of a circle, in x and y."""
        meets = np.ones(len(rows), dtype=bool)
        corners = self.triangles.take(rows, axis=0).T
        for column, middle in zip(self._axes, centre, strict=False):
            a, b, c = column.take(corners) - middle
            meets &= np.minimum(np.minimum(a, b), c) <= radius
            meets &= np.maximum(np.maximum(a, b), c) >= -radius
        return meets


def _slab_of_soup(soup: Array, below: Array, height: float, part: SlabPart) -> Moments:
    """Return the moments that loose triangles (k, 3, 3) contribute between z = 0 and ``height``.

    Triangles ``below`` (j, 3, 3), which end at the upper plane, contribute only the plane's share.
    """
    soup = _clipped(soup, np.array([0.0, 0.0, 1.0]), 0.0)
    edges = _upper_edges(np.concatenate([soup, below]), height)
    soup = _clipped(soup, np.array([0.0, 0.0, -1.0]), -height)
    if part.centre is not None:
        soup, edges = (_within(item, part.centre, part.radius_mm) for item in (soup, edges))
    if part.side is not None:
        soup = _clipped(soup, np.array([*part.side, 0.0]), 0.0)
        edges = _clipped_edges(edges, part.side)
    return summed([np.ascontiguousarray(soup.transpose(1, 2, 0))]) + _cone(edges, height)


def _clipped(soup: Array, normal: Array, height: float) -> Array:
    """Return the parts of loose triangles (k, 3, 3) with normal · r ≥ height."""
    over = (soup.reshape(-1, 3) @ normal - height).reshape(-1, 3)
    keep = over >= 0.0
    count = _count(keep)
    parts = [soup[count == 3]]
    for inside in (1, 2):
        rows = np.flatnonzero(count == inside)
        lone = (keep[rows] if inside == 1 else ~keep[rows]).argmax(axis=1)
        turn = (lone[:, None] + np.arange(3)) % 3
        p, q, r = (soup[rows, turn[:, k]] for k in range(3))
        hp, hq, hr = (over[rows, turn[:, k]] for k in range(3))
        pq = p + (hp / (hp - hq))[:, None] * (q - p)
        pr = p + (hp / (hp - hr))[:, None] * (r - p)
        if inside == 1:
            parts.append(np.stack([p, pq, pr], axis=1))
        else:
            parts += [np.stack([pq, q, r], axis=1), np.stack([pq, r, pr], axis=1)]
    return np.concatenate(parts)


def _count(marks: NDArray[np.bool_]) -> NDArray[np.int8]:
    a, b, c = marks.T.astype(np.int8)
    total: NDArray[np.int8] = a + b + c
    return total


def _upper_edges(soup: Array, height: float) -> Array:
    """Return the edges (k, 2, 2) of the section at ``height``, metal on their left, of loose triangles.

    A corner on the plane counts as above it: the section on the plane is that just below.
    """
    up = soup[:, :, 2] >= height
    count = _count(up)
    parts = []
    for inside in (1, 2):
        rows = np.flatnonzero(count == inside)
        lone = (up[rows] if inside == 1 else ~up[rows]).argmax(axis=1)
        turn = (lone[:, None] + np.arange(3)) % 3
        p, q, r = (soup[rows, turn[:, k]] for k in range(3))
        share_q, share_r = ((height - p[:, 2]) / (s[:, 2] - p[:, 2]) for s in (q, r))
        pq = (p + share_q[:, None] * (q - p))[:, :2]
        pr = (p + share_r[:, None] * (r - p))[:, :2]
        parts.append(np.stack([pq, pr] if inside == 1 else [pr, pq], axis=1))
    return np.concatenate(parts)


def _within(items: Array, centre: Array, radius: float) -> Array:
    x, y = (sum(corner) / len(corner) for corner in items.T[:2])
    kept: Array = items[np.hypot(x - centre[0], y - centre[1]) <= radius]
    return kept


def _clipped_edges(edges: Array, side: Array) -> Array:
    """Return the parts of edges on one side of the origin; the edges that close them lie in line with it."""
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
