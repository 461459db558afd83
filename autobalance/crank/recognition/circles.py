"""Circles in outlines of cross-sections: a bearing's outline is a circle with, at most, pieces cut out."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from autobalance.types import Array
from autobalance.value_classes import dataclass

T = TypeVar("T", bound=np.generic)

TRIALS = (4, 24)
"""Circles tried through three corners spread over an outline, at first and if none of those is nearly whole;
one whose three corners miss keyways, flats and oil holes is enough."""
NEARLY_WHOLE = 0.97
"""Share of an outline on a circle from which on no other is tried; keyways and oil holes have the rest."""
ON_CIRCLE = 2e-4
"""Largest distance of a corner from its circle, as a share of the radius: rounding of a file's numbers and
the ellipse that a slightly oblique section makes."""
CHORD_SHARE = 0.02
"""Most that a corner may be inside as a share of the radius, because the plane met an edge between two
corners of the mesh; only as much as the outline's own steps suggest."""
LONGEST_STEP = 0.8
"""A straight piece longer than this share of the radius is a flat, not a facet: a circle has more than seven
facets."""
LEAST_COVER = 0.6
"""Share of the full angle that must lie on the circle: keyways, flats and drillings take the rest."""

HELD_COVER, HELD_GAP_RAD = 0.35, 0.8 * math.pi
"""Smallest share of its circle that a bore with slots has, and longest missing arc: a hole with keyways,
splines or a slot to another hole is a bore if it holds a pin. Slots of DIN ISO 14 splines leave 0.47. The two
ends of a long hole have half a circle each."""
TRIMMED_CIRCLES = 4
"""Fits of such a circle, each without the corners that the one before shows to be off it."""
HELD_TRIALS, HELD_STRIDES = 48, (3, 7, 11)
"""Circles tried through three corners a third, a seventh and an eleventh of such an outline apart."""
AT_A_TIME = 8192
"""Distances of corners from circles computed together."""

CREST, CREST_SHARE = 2.0, 0.1
"""Largest distance of the crests of a rough outline over that of the rest, and their share: σ = 0.05 mm."""

MAX_LENGTH_RATIO = 1.75
"""Largest length of an outline over its width. A circle with ``LEAST_COVER`` of its arc left, all of it
within its slack, is at most 1.6 times as long."""
MEASURED_DIRECTIONS = np.array(
    [[1.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)], [0.0, 1.0, math.sqrt(0.5), -math.sqrt(0.5)]]
)
"""Directions in which outlines are measured, as columns."""


@dataclass(frozen=True, eq=False)
class Circle:
    """A circle in a section: ``centre`` (2,) [mm] and ``radius`` [mm]."""

    centre: Array
    radius: float


def distances(points: Array, centre: Array) -> Array:
    """Return the distances of points (k, 2 or more) from ``centre`` (2,) in x and y, fast."""
    x, y = points[:, 0] - centre[0], points[:, 1] - centre[1]
    away: Array = np.sqrt(x * x + y * y)
    return away


def all_within(off_mm: Array, exact_mm: float, rough_mm: float) -> bool:
    """Return whether all vertices (k,) are within the exact distance, except crests of rough waves."""
    slack = exact_mm + rough_mm
    farthest = float(off_mm.max(initial=0.0))
    if rough_mm == 0.0 or farthest <= slack:
        return farthest <= slack
    return farthest <= CREST * slack and float((off_mm > slack).mean()) <= CREST_SHARE


def following(points: NDArray[T]) -> NDArray[T]:
    """Return the successor of each row of a closed ring, first after last; far faster than np.roll."""
    return np.concatenate([points[1:], points[:1]])


def preceding(points: NDArray[T]) -> NDArray[T]:
    """Return the predecessor of each row of a closed ring, the last before the first."""
    return np.concatenate([points[-1:], points[:-1]])


def corners_of(outline: Array, grain_mm: float) -> Array:
    """Return the corners (k, 2) of a closed outline, without those on a line between neighbours.

    ``grain_mm`` is a corner's largest distance from the line; every other one of a straight row goes in each
    pass.
    """
    points = outline
    parity = 0
    while len(points) > 8:
        straight = _in_line(points, grain_mm)
        if not straight.any():  # in a rough outline hardly one
            break
        for first in (parity, 1 - parity):
            goes = np.zeros(len(points), dtype=bool)
            goes[first::2] = straight[first::2]
            goes[-1] &= not goes[0]
            if goes.any():
                break
        else:
            break
        points = points[~goes]
        parity = 1 - first
    return points


def _in_line(points: Array, grain_mm: float) -> NDArray[np.bool_]:
    """Mark the corners (k,) of a closed outline on a line between their neighbours."""
    x, y = np.ascontiguousarray(points.T)
    before_x, before_y = preceding(x), preceding(y)
    along_x, along_y = following(x) - before_x, following(y) - before_y
    off = np.abs(along_x * (y - before_y) - along_y * (x - before_x))
    within: NDArray[np.bool_] = off <= (grain_mm * np.hypot(along_x, along_y) if grain_mm else 0.0)
    return within


@dataclass(frozen=True, eq=False)
class _Corners:
    """Corners (k, 2) of a closed outline, steps (k,) to the next ones, and the longer one of either side."""

    places: Array
    steps: Array
    reach: Array

    @classmethod
    def of(cls, places: Array) -> _Corners:
        x, y = np.ascontiguousarray(places.T)
        steps = np.sqrt((following(x) - x) ** 2 + (following(y) - y) ** 2)
        return cls(places, steps, np.maximum(steps, preceding(steps)))

    def cover(self, centres: Array, radii: Array, rough_mm: float) -> Array:
        """Return for each circle the share of the full angle that the outline follows.

        So many circles at a time that what lies between stays in the cache.
        """
        count, (x, y) = len(self.steps), np.ascontiguousarray(self.places.T)
        rows, covers = max(1, AT_A_TIME // count), np.zeros(len(radii))
        with np.errstate(over="ignore", invalid="ignore"):
            for begin in range(0, len(radii), rows):
                few = slice(begin, begin + rows)
                (at_x, at_y), radius = centres[few].T[:, :, None], radii[few, None]
                off, across = x - at_x, y - at_y
                off *= off
                across *= across
                off += across
                np.sqrt(off, out=off)
                off -= radius
                np.abs(off, out=off)
                on = off <= _slack(self.reach[None], radius, rough_mm)
                covers[few] = _cover(on, self.steps, radius)
        return covers

    def near(self, centre: Array, radius: float, rough_mm: float) -> Array:
        """Return the corners near a circle."""
        off = distances(self.places, centre) - radius
        return self.places[np.abs(off) <= _slack(self.reach, radius, rough_mm)]


def whole_circle(outline: Array, grain_mm: float, rough_mm: float = 0.0) -> Circle | None:
    """Return the circle of a closed outline (k, 2), without pieces cut out; None if it is not a circle.

    ``rough_mm`` is the largest distance of a rough surface's corners from it.
    """
    if _is_long(outline):
        return None
    return _whole(_Corners.of(corners_of(outline, grain_mm)), grain_mm, rough_mm)


def _whole(corners: _Corners, grain_mm: float, rough_mm: float) -> Circle | None:
    """Return the circle of an outline's corners; None if it is not a circle."""
    places, count = corners.places, len(corners.places)
    if count < 8:
        return None
    for trials in TRIALS:
        first = np.arange(0, count, max(1, count // trials))
        trio = places[np.stack([first, (first + count // 3) % count, (first + 2 * count // 3) % count])]
        centres, radii = _circumcircles(*trio)
        cover = corners.cover(centres, radii, rough_mm)
        best = int(np.argmax(cover))
        if cover[best] > NEARLY_WHOLE:
            break
    if cover[best] < LEAST_COVER:
        return None
    centre, radius = fit_circle(corners.near(centres[best], radii[best], rough_mm))
    away = np.abs(distances(places, centre) - radius)
    close = away <= max(
        4.0 * float(np.median(away)), grain_mm, rough_mm
    )  # without corners of the pieces cut out
    if close.sum() >= 8:
        centre, radius = fit_circle(places[close])
    outside = distances(places, centre) - radius
    if float(outside.max()) > 2.0 * _on_circle(radius, rough_mm) + float(
        _slack(corners.reach, radius, rough_mm).max()
    ):
        return None
    return Circle(centre, radius)


def hole_circles(outline: Array, grain_mm: float, rough_mm: float = 0.0) -> tuple[Circle, ...]:
    """Return the circles of a hole's outline (k, 2), counter-clockwise: those of round bores in it.

    That is one, except for two bores that a slot joins, and none in a window. Slots in a bore lie beyond its
    circle: nothing reaches into it. They are looked for in drawn surfaces alone.
    """
    is_long = _is_long(outline)
    if is_long and rough_mm > 0.0:
        return ()
    corners = _Corners.of(corners_of(outline, grain_mm))
    whole = None if is_long else _whole(corners, grain_mm, rough_mm)
    if whole is not None or rough_mm > 0.0:
        return () if whole is None else (whole,)
    places, count = corners.places, len(corners.places)
    if count < 8:
        return ()
    begins = np.arange(0, count, max(1, count // HELD_TRIALS))
    strides = {max(2, count // parts) for parts in HELD_STRIDES}
    steps = [begins + np.array([[0], [stride], [2 * stride]]) for stride in strides]
    trio = places[np.concatenate(steps, axis=1) % count]
    centres, radii = _circumcircles(*trio)
    found: list[Circle] = []
    cover = corners.cover(centres, radii, 0.0)
    for best in np.argsort(-cover, kind="stable"):
        if cover[best] < HELD_COVER:
            break
        if any(float(np.linalg.norm(centres[best] - one.centre)) < one.radius for one in found):
            continue
        circle = _fitted_without_outliers(corners.near(centres[best], radii[best], 0.0), grain_mm)
        if _is_held(places, corners.steps, corners.reach, circle):
            found.append(circle)
    return tuple(found)


def _fitted_without_outliers(near: Array, grain_mm: float) -> Circle:
    """Return the circle of points near it; a chord's, where a slot cuts it, are inside."""
    for _ in range(TRIMMED_CIRCLES):
        centre, radius = fit_circle(near)
        away = np.abs(distances(near, centre) - radius)
        close = away <= max(4.0 * float(np.median(away)), grain_mm)
        if close.all() or close.sum() < 6:
            break
        near = near[close]
    return Circle(centre, radius)


def _is_held(corners: Array, step: Array, reach: Array, circle: Circle) -> bool:
    """Return whether a pin of a circle passes a hole of some corners and is held in it from all sides."""
    off = distances(corners, circle.centre) - circle.radius
    on = off <= _slack(reach, circle.radius, 0.0)
    along = on & following(on) & (step <= LONGEST_STEP * circle.radius)
    sagitta = float(step[along].max(initial=0.0)) ** 2 / (8.0 * circle.radius)  # of a chord that a slot cuts
    if float(off.min()) < -1.1 * sagitta - ON_CIRCLE * circle.radius:
        return False
    angles = np.arctan2(corners[:, 1] - circle.centre[1], corners[:, 0] - circle.centre[0])
    ends = np.sort(np.concatenate([angles[along], following(angles)[along]]))
    gap = float(np.diff(ends, append=ends[0] + 2.0 * math.pi).max()) if len(ends) else math.inf
    half = np.arcsin(step[along] / (2.0 * circle.radius))
    return gap <= HELD_GAP_RAD and float(half.sum()) >= HELD_COVER * math.pi


def _is_long(outline: Array) -> bool:
    """Return quickly whether points are off any circle, as most sections of a shaft not cut square."""
    along = outline @ MEASURED_DIRECTIONS
    widths = along.max(axis=0) - along.min(axis=0)
    return bool(widths.max() > MAX_LENGTH_RATIO * widths.min())


def _on_circle(radius: Array | float, rough_mm: float) -> Array | float:
    return np.maximum(ON_CIRCLE * radius, rough_mm) if rough_mm else ON_CIRCLE * radius


def _slack(reach: Array, radius: Array | float, rough_mm: float) -> Array:
    slack: Array = reach**2 / (4.0 * radius)
    np.minimum(slack, CHORD_SHARE * radius, out=slack)
    slack += _on_circle(radius, rough_mm)
    return slack


def _cover(on: NDArray[np.bool_], step: Array, radius: Array) -> Array:
    """Return for each circle (rows) the share of the full angle that corners on it follow."""
    along = on.copy()
    along[:, :-1] &= on[:, 1:]
    along[:, -1] &= on[:, 0]
    if not float(step.max()) <= LONGEST_STEP * float(radius.min()):
        along &= step[None] <= LONGEST_STEP * radius
    half = np.arcsin(step[None] / (2.0 * radius), where=along, out=np.zeros(along.shape))
    half *= 2.0
    share: Array = half.sum(axis=1) / (2.0 * math.pi)
    return share


def _circumcircles(a: Array, b: Array, c: Array) -> tuple[Array, Array]:
    """Return centres (k, 2) and radii (k,) of the circles through three points each; huge if in line."""
    (at_x, at_y), (bx, by), (cx, cy) = a.T, (b - a).T, (c - a).T
    double = 2.0 * (bx * cy - by * cx)
    b_reach, c_reach = np.maximum(np.abs(bx), np.abs(by)), np.maximum(np.abs(cx), np.abs(cy))
    flat = np.abs(double) < 1e-12 * (b_reach * c_reach + 1e-300)
    double[flat] = 1.0
    bb, cc = bx * bx + by * by, cx * cx + cy * cy
    x = (cy * bb - by * cc) / double
    y = (bx * cc - cx * bb) / double
    radius = np.hypot(x, y)
    radius[flat] = 1e300
    return np.stack([at_x + x, at_y + y], axis=1), np.maximum(radius, 1e-300)


def fit_circle(points: Array) -> tuple[Array, float]:
    """Return centre (2,) and radius of the circle that fits points (k, 2) best."""
    local = np.ascontiguousarray(points.T)
    middle = local.mean(axis=1)
    local = local - middle[:, None]
    scale = float(np.abs(local).max())
    local /= scale
    rows = np.concatenate([2.0 * local, np.ones((1, len(points)))])
    solution = np.linalg.lstsq(rows @ rows.T, rows @ (local**2).sum(axis=0), rcond=None)[0]
    radius = math.sqrt(max(float(solution[2] + solution[:2] @ solution[:2]), 0.0))
    return middle + scale * solution[:2], scale * radius
