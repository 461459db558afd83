"""Lines, circles and cylinders fitted to many sets of points at once, without a loop over the sets."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from autobalance.solid.mesh.adjacency import unit
from autobalance.types import Array, Flags, Indices

STEPS = 12
"""Improvements of a cylinder that is fitted."""
CONVERGED_STEP_SHARE = 0.01
"""Step of a cylinder below which it has converged, as a share of the distance its points may be off."""
RIDGE = 1e-14
"""Share of its trace added to each set of normal equations, so that undetermined parameters stay."""


@dataclass(frozen=True, eq=False)
class Sets:
    """Sets of rows, one after the other; none is empty.

    Attributes
    ----------
    starts : (k,) int
        Where each set begins.
    count : int
        Rows in all.
    """

    starts: Indices
    count: int

    @classmethod
    def of(cls, number: Indices) -> Sets:
        """Return the sets of rows with one number each, which must not fall."""
        return cls(np.flatnonzero(np.diff(number, prepend=-1)), len(number))

    @cached_property
    def sizes(self) -> Indices:
        """Rows of each set (k,)."""
        return np.diff(self.starts, append=self.count)

    @cached_property
    def number(self) -> Indices:
        """The set of each row (count,)."""
        return np.repeat(np.arange(len(self.starts)), self.sizes)

    def sums(self, values: Array) -> Array:
        """Return the sums (k, ...) of values (count, ...)."""
        total: Array = np.add.reduceat(values, self.starts, axis=0)
        return total

    def means(self, values: Array) -> Array:
        """Return the means (k, ...) of values (count, ...)."""
        sizes = self.sizes.reshape(-1, *[1] * (values.ndim - 1))
        return self.sums(values) / sizes

    def most(self, values: Array) -> Array:
        """Return the largest (k, ...) of values (count, ...)."""
        greatest: Array = np.maximum.reduceat(values, self.starts, axis=0)
        return greatest

    def least(self, values: Array) -> Array:
        """Return the least (k, ...) of values (count, ...)."""
        lowest: Array = np.minimum.reduceat(values, self.starts, axis=0)
        return lowest

    def medians(self, values: Array) -> Array:
        """Return the medians (k,) of values (count,)."""
        ranked = values[np.lexsort((values, self.number))]
        middle: Array = 0.5 * (
            ranked[self.starts + (self.sizes - 1) // 2] + ranked[self.starts + self.sizes // 2]
        )
        return middle

    def rows(self, chosen: Flags) -> Indices:
        """Return the rows of some of the sets, flagged (k,)."""
        return np.flatnonzero(chosen[self.number])


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines nearest to sets of points: a point, the direction (k, 2), and the worst distance (k,)."""

    middle: Array
    direction: Array
    worst_mm: Array

    def of(self, chosen: Flags) -> Lines:
        """Return the lines of some of the sets, flagged (k,)."""
        return Lines(self.middle[chosen], self.direction[chosen], self.worst_mm[chosen])

    def with_(self, which: Indices, others: Lines) -> Lines:
        """Return the lines with others (m,) in place of some, by their numbers (m,)."""
        mine = [self.middle.copy(), self.direction.copy(), self.worst_mm.copy()]
        for values, new in zip(mine, (others.middle, others.direction, others.worst_mm), strict=True):
            values[which] = new
        return Lines(*mine)


def lines(points: Array, sets: Sets) -> Lines:
    """Fit a line to each set of points (n, 2)."""
    middle = sets.means(points)
    x, y = (points - middle[sets.number]).T
    xx, xy, yy = sets.sums(np.stack([x * x, x * y, y * y], axis=1)).T
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    direction: Array = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    along_x, along_y = direction[sets.number].T
    return Lines(middle, direction, sets.most(np.abs(along_x * y - along_y * x)))


@dataclass(frozen=True, eq=False)
class Circles:
    """Circles nearest to sets of points, in the algebraic sense; infinite where the points lie on a line."""

    centre: Array
    radius: Array
    worst_mm: Array


def circles(points: Array, sets: Sets) -> Circles:
    """Fit a circle to each set of points (n, 2).

    In axes along and across each set the normal equations are diagonal, so that a flat arc loses no digits.
    """
    line = lines(points, sets)
    cosine, sine = line.direction[sets.number].T
    x, y = (points - line.middle[sets.number]).T
    u, v = cosine * x + sine * y, cosine * y - sine * x
    square = u * u + v * v
    uu, vv, us, vs, ss = sets.means(np.stack([u * u, v * v, u * square, v * square, square], axis=1)).T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        a, b = 0.5 * us / uu, 0.5 * vs / vv
        radius = np.sqrt(ss + a * a + b * b)
        away = np.hypot(u - a[sets.number], v - b[sets.number]) - radius[sets.number]
    cosine, sine = line.direction.T
    centre: Array = line.middle + np.stack([cosine * a - sine * b, sine * a + cosine * b], axis=1)
    worst = sets.most(np.abs(away))
    flat = ~np.isfinite(worst)
    return Circles(centre, np.where(flat, np.inf, radius), np.where(flat, np.inf, worst))


def across(axes: Array) -> tuple[Array, Array]:
    """Return two directions (k, 3) square to each axis (k, 3) and to each other."""
    helper = np.eye(3)[np.argmin(np.abs(axes), axis=1)]
    one = unit(np.cross(axes, helper))
    return one, np.cross(axes, one)


def least_directions(vectors: Array, sets: Sets) -> Array:
    """Return the direction (k, 3) most nearly square to the vectors (n, 3) of each set."""
    x, y, z = vectors.T
    xx, xy, xz, yy, yz, zz = sets.sums(np.stack([x * x, x * y, x * z, y * y, y * z, z * z], axis=1)).T
    second = np.stack([xx, xy, xz, xy, yy, yz, xz, yz, zz], axis=1).reshape(-1, 3, 3)
    directions: Array = np.linalg.eigh(second)[1][:, :, 0]
    return directions


@dataclass(frozen=True, eq=False)
class Cylinders:
    """Cylinders fitted to sets of points: ``point``, ``axis`` (k, 3), ``radius``, ``worst_mm`` (k,).

    ``swept`` (k,) is the spread of the points' directions from the axis; a fit that did not converge has an
    infinite ``worst_mm``.
    """

    point: Array
    axis: Array
    radius: Array
    worst_mm: Array
    swept: Array


def cylinders(points: Array, sets: Sets, axis: Array, tight_mm: float, most_mm: float) -> Cylinders:
    """Fit cylinders of any axis to sets of points (n, 3), by Gauss-Newton steps from ``axis`` (k, 3).

    Those with a radius beyond ``most_mm`` are given up.
    """
    middle = sets.means(points)
    local = points - middle[sets.number]
    one, other = across(axis)
    plane = np.stack([_dot(local, one[sets.number]), _dot(local, other[sets.number])], axis=1)
    start = circles(plane, sets)
    good = np.isfinite(start.radius)
    flat = np.where(good[:, None], start.centre, 0.0)
    centre, radius = flat[:, :1] * one + flat[:, 1:] * other, np.where(good, start.radius, 1.0)
    active = good & (radius <= most_mm)
    good = active.copy()
    for _ in range(STEPS):
        rows = sets.rows(active)
        if len(rows) == 0:
            break
        some, which = Sets.of(sets.number[rows]), np.flatnonzero(active)
        step, sound = _step(local[rows], some, centre[which], axis[which], radius[which])
        sound &= radius[which] <= most_mm
        one, other = across(axis[which])
        moved = step[:, :1] * one + step[:, 1:2] * other
        turned = unit(axis[which] + step[:, 2:3] * one + step[:, 3:4] * other)
        kept = which[sound]
        centre[kept] += moved[sound]
        axis[kept] = turned[sound]
        radius[kept] += step[sound, 4]
        good[which[~sound]] = False
        small = np.abs(step[:, :2]).max(axis=1) + np.abs(step[:, 4]) < CONVERGED_STEP_SHARE * tight_mm
        active[which[~sound | small]] = False
    r, out = _away(local, centre[sets.number], axis[sets.number])[1:]
    worst = sets.most(np.abs(r - radius[sets.number]))
    one, other = across(axis)
    seen = np.stack([_dot(out, one[sets.number]), _dot(out, other[sets.number])], axis=1)
    swept = (sets.most(seen) - sets.least(seen)).max(axis=1)
    return Cylinders(centre + middle, axis, radius, np.where(good, worst, np.inf), swept)


def _step(points: Array, sets: Sets, centre: Array, axis: Array, radius: Array) -> tuple[Array, Flags]:
    """Return steps (k, 5) of centre, axis (both across it) and radius, and whether each is sound (k,)."""
    number = sets.number
    h, r, out = _away(points, centre[number], axis[number])
    one, other = across(axis)
    a, b = _dot(out, one[number]), _dot(out, other[number])
    reach = np.maximum(sets.most(np.abs(h)), 1e-300)
    lever = h / reach[number]
    rows = np.stack([a, b, lever * a, lever * b, np.ones(len(r))], axis=1)
    upper = np.triu_indices(5)
    second = sets.sums(rows[:, upper[0]] * rows[:, upper[1]])
    normal = np.zeros((len(radius), 5, 5))
    normal[:, upper[0], upper[1]] = normal[:, upper[1], upper[0]] = second
    normal += RIDGE * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(5)
    target = sets.sums(rows * (r - radius[number])[:, None])
    step = np.asarray(np.linalg.solve(normal, target[:, :, None])[:, :, 0], dtype=np.float64)
    step[:, 2:4] /= reach[:, None]
    return step, np.isfinite(step).all(axis=1) & (sets.least(r) > 0.0)


def _away(points: Array, centre: Array, axis: Array) -> tuple[Array, Array, Array]:
    """Return heights along axes, distances from them, and unit vectors away, row by row."""
    local = points - centre
    h = _dot(local, axis)
    away = local - h[:, None] * axis
    r = np.sqrt(_dot(away, away))
    return h, r, away / np.where(r > 0.0, r, 1.0)[:, None]


def _dot(one: Array, other: Array) -> Array:
    product: Array = np.einsum("ij,ij->i", one, other)
    return product
