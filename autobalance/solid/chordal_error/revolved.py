"""Surfaces of revolution fitted to a mesh."""

from __future__ import annotations

from dataclasses import field
from functools import cached_property

import numpy as np

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.mesh.adjacency import unit
from autobalance.types import Array, Flags, Floats, Indices
from autobalance.value_classes import dataclass

# Surfaces about an axis (cylinders, cones and tori) and the volume between them and flat triangles.


THREE_POINTS = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]]), np.full(3, 1.0 / 3.0)
"""Quadrature of degree 2 on a triangle: barycentric points and weights."""
_A, _B = 0.445948490915965, 0.091576213509771
"""Barycentric coordinates of the points of degree 4, Dunavant 1985."""
SIX_POINTS = (
    np.array(
        [[1 - 2 * a if k == j else a for k in range(3)] for a in (_A, _B) for j in range(3)],
    ),
    np.array([0.223381589678011] * 3 + [0.109951743655322] * 3),
)
"""Quadrature of degree 4, Dunavant 1985."""
_QUARTERS = np.array(
    [
        [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5]],
        [[0.5, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.5, 0.5]],
        [[0.5, 0.0, 0.5], [0.0, 0.5, 0.5], [0.0, 0.0, 1.0]],
        [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]],
    ]
)
IN_QUARTERS = np.concatenate([SIX_POINTS[0] @ each for each in _QUARTERS]), np.tile(SIX_POINTS[1] / 4.0, 4)
"""The same over each quarter of a triangle."""


@dataclass(frozen=True, eq=False)
class RevolvedSurface:
    """A surface about an axis: a cylinder or cone r = r0 + slope h, or a torus of tube radius ``tube_mm``.

    ``h`` runs along ``axis`` from ``point``; the tube's centre is at (``r0``, ``h0``).
    """

    point: Array
    axis: Array
    r0: float
    slope: float = 0.0
    h0: float = 0.0
    tube_mm: float = 0.0

    def off(self, points: Array) -> Array:
        """Return the distance (n,) of points (n, 3) from the surface, outside positive [mm]."""
        h, r, _ = cylindrical(points, self.point, self.axis)
        if self.tube_mm:
            return np.hypot(r - self.r0, h - self.h0) - self.tube_mm
        off: Array = (r - self.r0 - self.slope * h) / np.hypot(1.0, self.slope)
        return off

    def normal(self, points: Array) -> Array:
        """Return the surface's direction (n, 3) at points near it."""
        h, r, out = cylindrical(points, self.point, self.axis)
        if self.tube_mm:
            return unit((r - self.r0)[:, None] * out + (h - self.h0)[:, None] * self.axis)
        return unit(out - self.slope * self.axis)


def cylindrical(points: Array, point: Array, axis: Array) -> tuple[Array, Array, Array]:
    """Return height along an axis, distance from it, and the unit vector away from it, of points (n, 3)."""
    h, r, out = _cylindrical(np.ascontiguousarray(points.T), point, axis)
    return h, r, out.T


def _cylindrical(places: Array, point: Array, axis: Array) -> tuple[Array, Array, Array]:
    """Return `cylindrical` of points (3, n): numpy is several times as fast along columns."""
    local = places - point[:, None]
    h = axis @ local
    local -= axis[:, None] * h
    x, y, z = local
    r = np.sqrt(x * x + y * y + z * z)
    local /= np.where(r > 0.0, r, 1.0)
    return h, r, local


def between(
    surface: RevolvedSurface, corners: Array, doubled: Array, rule: tuple[Array, Array]
) -> tuple[Array, Array, Array]:
    """Return base points, directions and weights (3, k) of ∫ (base + t·direction)ⁿ up to the surface.

    Points of a triangle are moved to the surface along the direction away from the axis, or from the centre
    of the tube. The volume they sweep is exact for any size of the triangle, up to the quadrature. The first
    point of every triangle comes first, then the second of every one.
    """
    points, shares = rule
    places = (points @ np.ascontiguousarray(corners.transpose(2, 1, 0))).reshape(3, -1)
    flow = (0.5 * shares[:, None] * doubled.T[:, None, :]).reshape(3, -1)  # normal times area
    h, r, out = _cylindrical(places, surface.point, surface.axis)
    r = np.maximum(r, 1e-12)
    if not surface.tube_mm:
        base = surface.point[:, None] + surface.axis[:, None] * h
        through = (flow * out).sum(axis=0)
        end = surface.r0 + surface.slope * h
        powers = zip(range(2, 5), _powers(end), _powers(r), strict=False)
        weights = [(far - near) / (k * r) * through for k, far, near in powers]
        return base, out, np.array(weights)
    across, up = r - surface.r0, h - surface.h0
    rho = np.maximum(np.sqrt(across * across + up * up), 1e-12)
    cosine = across / rho
    direction = cosine * out + surface.axis[:, None] * (up / rho)
    base = (surface.point + surface.h0 * surface.axis)[:, None] + surface.r0 * out
    through = (flow * direction).sum(axis=0) / (r * rho)
    swept = [(surface.tube_mm**k - power) / k for k, power in enumerate(_powers(rho), start=2)]
    weights = [through * (surface.r0 * swept[k] + cosine * swept[k + 1]) for k in range(3)]
    return base, direction, np.array(weights)


def _powers(values: Array) -> tuple[Array, Array, Array, Array]:
    """Return the square and the powers up to the fifth; numpy's own beyond the square are slow."""
    square = values * values
    fourth = square * square
    return square, square * values, fourth, fourth * values


@dataclass(frozen=True, eq=False)
class Lens:
    """Volume between some facets and their surface: its moments, and sums of magnitudes.

    ``gross_at`` are ∫ z and ∫ z² of the gross unbalance, across and along the z axis; ``volumes`` (m,) lie
    over each facet, whose middles are off by ``sag_mm`` at most. ``spread`` is the error bar, at the same
    places, of a lens known from a sample of its facets: its mass, and its first moment across z;
    ``rows`` (m,) are their numbers in the mesh.
    """

    moments: Moments
    gross_mass_g: float
    gross_unbalance_g_mm: float
    gross_at: Array
    volumes: Array
    sag_mm: float
    spread: tuple[float, float] = (0.0, 0.0)
    rows: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


def lens(
    surface: RevolvedSurface, corners: Array, doubled: Array, density_g_mm3: float, rule: tuple[Array, Array]
) -> Lens:
    """Integrate between a surface and triangles (m, 3, 3); ``doubled`` (m, 3) is twice their area vectors."""
    base, out, weights = between(surface, corners, doubled, rule)
    w0, w1, w2 = density_g_mm3 * weights
    first = w0 * base + w1 * out
    second = first @ base.T + (w1 * base + w2 * out) @ out.T
    size, z = np.sqrt(first[0] ** 2 + first[1] ** 2), base[2]  # hypot takes ten times as long
    return Lens(
        Moments(float(w0.sum()), first.sum(axis=1), second),
        float(np.abs(w0).sum()),
        float(size.sum()),
        np.array([size @ z, size @ z**2]),
        np.abs(weights[0]).reshape(len(rule[1]), len(corners)).sum(axis=0),
        float(np.abs(surface.off(corners.mean(axis=1))).max(initial=0.0)),
    )


# Chord error of a mesh after a cut: the facets left are recognised by their planes.


SAME_PLANE = 4e-6
"""Distance of corners from a facet's plane, as a share of the part's reach: roundings of float32."""
SAME_WAY = 5e-3
"""Largest lean of a triangle against its facet [rad]; thin ones that lean more hide nothing."""
LOOKED_AT = 4
"""Facets of nearly one plane that are compared with a triangle."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """Surfaces fitted to facets, in the rotor frame.

    Attributes
    ----------
    surfaces : tuple of RevolvedSurface
    normals, heights : (k, 3), (k,) float
        Planes of the facets.
    number : (k,) int
        Surface that each facet stands for.
    diagonal_mm : float
        Size of the part.
    density_g_mm3 : float
    """

    surfaces: tuple[RevolvedSurface, ...]
    normals: Array
    heights: Array
    number: Indices
    diagonal_mm: float
    density_g_mm3: float

    def missing(self, soup: Floats, frame: Array) -> Moments:
        """Return the metal between the true surface and loose triangles (m, 3, 3) left of the facets.

        Triangles on other planes, those of cuts, hide nothing. ``frame`` (4, 4) takes the triangles to the
        rotor frame.
        """
        if len(self.number) == 0:
            return Moments.zero()
        reach = self.diagonal_mm + float(np.abs(soup).max(initial=0.0))
        corners = soup.astype(np.float64) @ frame[:3, :3].T + frame[:3, 3]
        doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        number = self._numbers(corners, doubled, SAME_PLANE * reach)
        total = Moments.zero()
        for one in np.unique(number[number >= 0]):
            mine = np.flatnonzero(number == one)
            surface = self.surfaces[int(one)]
            total = (
                total + lens(surface, corners[mine], doubled[mine], self.density_g_mm3, SIX_POINTS).moments
            )
        return total

    def _numbers(self, corners: Array, doubled: Array, flat_mm: float) -> Indices:
        """Return the surface that each triangle's facet stands for (m,), or −1."""
        from scipy.spatial import cKDTree

        scale = self.diagonal_mm  # a leaning plane passes that far from where it should, at the other end
        normal = unit(doubled)
        planes = cKDTree(np.column_stack([scale * self.normals, self.heights]))
        height = np.einsum("ij,ij->i", corners.mean(axis=1), normal)
        count = min(LOOKED_AT, len(self.number))
        _, near = planes.query(np.column_stack([scale * normal, height]), k=count)
        number = np.full(len(corners), -1)
        best = np.full(len(corners), np.inf)
        for column in np.asarray(near).reshape(len(corners), count).T:
            plane = self.normals[column]
            aligned = np.einsum("ij,ij->i", plane, normal) > 1.0 - 0.5 * SAME_WAY**2
            apart = np.abs(np.einsum("mkd,md->mk", corners, plane) - self.heights[column, None]).max(axis=1)
            rows = np.flatnonzero(aligned & (apart < np.minimum(best, flat_mm)))
            best[rows], number[rows] = apart[rows], self.number[column[rows]]
        return number


# Lines, circles and cylinders fitted to many sets of points at once, without a loop over the sets.


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

    def thinned(self, most: int) -> tuple[Indices, Indices]:
        """Return rows (m,) spread over each set, at most ``most`` of one, and how many each represents."""
        step = (1 + (self.sizes - 1) // most)[self.number]
        kept = np.flatnonzero((np.arange(self.count) - self.starts[self.number]) % step == 0)
        return kept, step.take(kept)

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
