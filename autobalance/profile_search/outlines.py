"""The free part of a counterweight as a cubic B-spline, its moments, and its outlines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache, cached_property
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from autobalance.errors import JobError
from autobalance.profile_search.input import LighteningHole
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array
from autobalance.value_classes import dataclass

# The free part of a counterweight as a cubic B-spline, and its exact area moments with their gradients.
#
# The outline of a free part runs from the hold radius out along the first edge of its sector and along the
# spline to the second edge. It returns along that edge and the arc of the hold radius. Green's theorem turns
# the moments of the area into integrals along that outline. On the spline they are polynomials, which
# Gauss's rule integrates exactly.


DEGREE = 3
GAUSS_POINTS = 8
"""Exact to degree 15; the second moments of a cubic have degree 14 (x³ y')."""
SAGITTA_MM = 0.004
"""Largest deviation of the hold radius's facets; all metal of a design uses the same facets."""
SPLINE_SAGITTA_MM = 0.002
"""Largest deviation of a written outline's facets from the spline."""
SAMPLES_PER_SPAN = 16


@dataclass(frozen=True, eq=False)
class AreaMoments:
    """Area, first moments (2,), second moments ∫ r rᵀ dA (2, 2); gradients have a leading axis more."""

    area_mm2: Any
    first_mm3: Array
    second_mm4: Array


@dataclass(frozen=True, eq=False)
class Profile:
    """Angles of a free part's control points, and the radius that bounds it inwards.

    Attributes
    ----------
    angles_rad : (n,) float
        Of the control points, rising; the first and last are the sector's edges.
    hold_radius_mm : float
        Radius within which metal is held.
    """

    angles_rad: Array
    hold_radius_mm: float

    @classmethod
    def even(cls, sector_rad: tuple[float, float], count: int, hold_radius_mm: float) -> Profile:
        """Return a profile with control points where their basis functions act, which follows circles.

        These places are the means of three neighbouring knots (Greville).
        """
        knots = clamped_knots(count)
        share = np.array([knots[k + 1 : k + 1 + DEGREE].mean() for k in range(count)])
        low, high = sector_rad
        return cls(low + (high - low) * share, hold_radius_mm)

    @property
    def count(self) -> int:
        """Number of control points."""
        return len(self.angles_rad)

    @cached_property
    def knots(self) -> Array:
        """Clamped knots on [0, 1], even between the ends."""
        return clamped_knots(self.count)

    @cached_property
    def directions(self) -> Array:
        """Unit vectors (n, 2) to the control points."""
        return np.stack([np.cos(self.angles_rad), np.sin(self.angles_rad)], axis=1)

    @cached_property
    def least_radius_mm(self) -> float:
        """Common radius of all control points whose spline just touches the hold radius [mm]."""
        places = np.linspace(0.0, 1.0, 8 * self.count)
        return self.hold_radius_mm / float(np.linalg.norm(self.basis(places) @ self.directions, axis=1).min())

    @cached_property
    def least_radii_mm(self) -> Array:
        """Radii (n,) of control points at any spacing whose spline just touches the hold radius."""
        apart = np.cos(np.diff(self.angles_rad))
        radii = np.ones(self.count)
        radii[1:-1] = 6.0 / (4.0 + apart[:-1] + apart[1:])
        places = np.linspace(0.0, 1.0, 32 * self.count)
        least = float(np.linalg.norm(self.basis(places) @ self.control_points_mm(radii), axis=1).min())
        result: Array = self.hold_radius_mm / min(least, 1.0) * radii
        return result

    def control_points_mm(self, radii_mm: Array) -> Array:
        return np.asarray(radii_mm)[:, None] * self.directions

    def basis(self, places: Array, derivative: int = 0) -> Array:
        """Return the values (k, n) of the basis functions, or of their derivatives, at places in [0, 1]."""
        spline = BSpline(self.knots, np.eye(self.count), DEGREE)
        values: Array = spline(places, nu=derivative)
        return values

    @cached_property
    def _rule(self) -> tuple[Array, Array, Array]:
        """Basis (k, n), its derivative (k, n) and weights (k,) of Gauss's rule on every span."""
        points, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        breaks = np.unique(self.knots)
        half, middle = 0.5 * np.diff(breaks), 0.5 * (breaks[1:] + breaks[:-1])
        places = (middle[:, None] + half[:, None] * points).reshape(-1)
        return self.basis(places), self.basis(places, 1), (half[:, None] * weights).reshape(-1)

    @cached_property
    def sample_places(self) -> Array:
        """Places along the spline at which clearances and curvature are evaluated."""
        breaks = np.unique(self.knots)
        return np.linspace(0.0, 1.0, SAMPLES_PER_SPAN * (len(breaks) - 1) + 1)

    @cached_property
    def sample_basis(self) -> tuple[Array, Array, Array]:
        """Basis and its first two derivatives at the sample places."""
        places = self.sample_places
        return self.basis(places), self.basis(places, 1), self.basis(places, 2)

    def outline_mm(self, radii_mm: Array) -> Array:
        points: Array = self.sample_basis[0] @ self.control_points_mm(radii_mm)
        return points

    def curvature_radii_mm(self, radii_mm: Array) -> Array:
        """Return the radii of curvature (k,) along the spline, inf where it is straight."""
        control = self.control_points_mm(radii_mm)
        first, second = self.sample_basis[1] @ control, self.sample_basis[2] @ control
        cross = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
        speed = np.linalg.norm(first, axis=1) ** 3
        with np.errstate(divide="ignore"):
            return np.where(cross > 0.0, speed / np.maximum(cross, 1e-300), np.inf)

    def moments(self, radii_mm: Array) -> tuple[AreaMoments, AreaMoments]:
        """Return the area moments of the free part, and their gradients with the radii.

        Along a ray from the centre both ∮ x dy − y dx and its moments vanish, so the sector's edges add
        nothing. With w = x dy − y dx: A = ½∮w, ∫x dA = ⅓∮x w, ∫x y dA = ¼∮x y w.
        """
        control = self.control_points_mm(radii_mm)
        value, slope, weight = self._rule
        (x, y), (dx, dy) = (value @ control).T, (slope @ control).T
        turn = x * dy - y * dx
        ux, uy = self.directions.T
        # derivatives of x, y and the turn with each radius (k, n)
        x_r, y_r = value * ux, value * uy
        turn_r = x_r * dy[:, None] + x[:, None] * slope * uy - y_r * dx[:, None] - y[:, None] * slope * ux
        w, w_r = weight * turn, weight[:, None] * turn_r
        area, area_r = 0.5 * w.sum(), 0.5 * w_r.sum(axis=0)
        first = np.array([x @ w, y @ w]) / 3.0
        first_r = np.stack([w @ x_r + x @ w_r, w @ y_r + y @ w_r], axis=1) / 3.0
        second, second_r = np.zeros((2, 2)), np.zeros((self.count, 2, 2))
        for i, (p, p_r) in enumerate(((x, x_r), (y, y_r))):
            for j, (q, q_r) in enumerate(((x, x_r), (y, y_r))):
                if j < i:  # symmetric
                    second[i, j], second_r[:, i, j] = second[j, i], second_r[:, j, i]
                    continue
                second[i, j] = 0.25 * float((p * q) @ w)
                second_r[:, i, j] = 0.25 * ((q * w) @ p_r + (p * w) @ q_r + (p * q) @ w_r)
        inner = self._held_part
        return (
            AreaMoments(float(area) - inner.area_mm2, first - inner.first_mm3, second - inner.second_mm4),
            AreaMoments(area_r, first_r, second_r),
        )

    @cached_property
    def _held_part(self) -> AreaMoments:
        """Return the moments of the sector within the hold radius, by the facets of the written outline."""
        arc = self.arc_mm
        nxt = np.roll(np.concatenate([[[0.0, 0.0]], arc]), -1, axis=0)
        here = np.concatenate([[[0.0, 0.0]], arc])
        turn = here[:, 0] * nxt[:, 1] - here[:, 1] * nxt[:, 0]
        both = here + nxt
        second = (
            np.einsum("k,ki,kj->ij", turn, here, here)
            + np.einsum("k,ki,kj->ij", turn, nxt, nxt)
            + np.einsum("k,ki,kj->ij", turn, both, both)
        ) / 24.0
        return AreaMoments(float(turn.sum()) / 2.0, (turn[:, None] * both).sum(axis=0) / 6.0, second)

    @cached_property
    def arc_mm(self) -> Array:
        """Points (k, 2) on the hold radius, from the first edge to the second."""
        span = float(self.angles_rad[-1] - self.angles_rad[0])
        step = 2.0 * math.acos(1.0 - min(SAGITTA_MM / self.hold_radius_mm, 0.5))
        angles = np.linspace(self.angles_rad[0], self.angles_rad[-1], max(int(span / step) + 2, 8))
        return self.hold_radius_mm * np.stack([np.cos(angles), np.sin(angles)], axis=1)

    def spline_points_mm(self, radii_mm: Array, count: int | None = None) -> Array:
        """Return ``count`` points (k, 2) along the spline, or as many as ``SPLINE_SAGITTA_MM`` needs.

        Chords of a step h cut off ∫ C'' h²/12. Inner points are moved outwards by as much, so that the area
        within the facets is that within the spline, and a design's balance is that of its true surface.
        """
        control = self.control_points_mm(radii_mm)
        if count is None:
            bend = np.abs(self.sample_basis[2] @ control).sum(axis=1).max()
            count = int(math.sqrt(bend / (8.0 * SPLINE_SAGITTA_MM))) + 9
        places = np.linspace(0.0, 1.0, count)
        points: Array = self.basis(places) @ control
        points[1:-1] -= (self.basis(places[1:-1], 2) @ control) / (12.0 * (count - 1) ** 2)
        return points

    def polygon_mm(self, radii_mm: Array, count: int | None = None) -> Array:
        """Return the outline (k, 2) of the free part, counter-clockwise; ``count`` as for its spline."""
        return np.concatenate([self.spline_points_mm(radii_mm, count), self.arc_mm[::-1]])


def clamped_knots(count: int) -> Array:
    """Return the knots of ``count`` control points on [0, 1], even between the ends."""
    inner = np.linspace(0.0, 1.0, count - DEGREE + 1)
    return np.concatenate([np.zeros(DEGREE), inner, np.ones(DEGREE)])


def fitted_radii_mm(profile: Profile, angles_rad: Array, radii_mm: Array) -> tuple[Array, float]:
    """Return control radii (n,) whose spline follows an outline (radii at angles), and the largest error.

    Least squares, repeated with the spline's angle at each place updated.
    """
    places = profile.sample_places
    value = profile.basis(places)
    control_mm = np.interp(profile.angles_rad, angles_rad, radii_mm)
    for _ in range(8):
        points = value @ profile.control_points_mm(control_mm)
        angle = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
        angle = angle + math.tau * round((profile.angles_rad[0] - angle[0]) / math.tau)
        target_mm = np.interp(angle, angles_rad, radii_mm)
        along = value * np.cos(profile.angles_rad[None, :] - angle[:, None])
        control_mm = np.linalg.lstsq(along, target_mm, rcond=None)[0]
    points = value @ profile.control_points_mm(control_mm)
    angle = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    angle = angle + math.tau * round((profile.angles_rad[0] - angle[0]) / math.tau)
    target_mm = np.interp(angle, angles_rad, radii_mm)
    return control_mm, float(np.abs(np.linalg.norm(points, axis=1) - target_mm).max())


def refuse_crossing(points_mm: Array, name: str) -> None:
    """Refuse control points whose polygon crosses itself.

    Raises
    ------
    JobError
        If it crosses itself; the message names the two sides.
    """
    starts, ends = points_mm[:-1], points_mm[1:]
    for i in range(len(starts)):
        for j in range(i + 2, len(starts)):
            if _cross(starts[i], ends[i], starts[j], ends[j]):
                raise JobError(
                    f"{name}.start_points_mm cross: the side from point {i + 1} to {i + 2} meets that from "
                    f"{j + 1} to {j + 2}; list points in order around the axis"
                )


def _cross(a: Array, b: Array, c: Array, d: Array) -> bool:
    def side(p: Array, q: Array, r: Array) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0


# Outlines of profiles as plane regions and prisms (rotor frame).


PAST_MM = 1e-5
"""Distance by which a cut passes the ends of the free metal: anything thinner is not metal."""


def sector_mm(profile: Profile, far_mm: float) -> Array:
    """Return the outline of a sector between the hold radius and ``far_mm``, in the profile's axes."""
    arc = profile.arc_mm
    return np.concatenate([arc * (far_mm / profile.hold_radius_mm), arc[::-1]])


def past(z_mm: tuple[float, float]) -> tuple[float, float]:
    """Return a range widened by ``PAST_MM`` at both ends."""
    return z_mm[0] - PAST_MM, z_mm[1] + PAST_MM


def prism(outline: Array, matrix: Array, z_mm: tuple[float, float]) -> Solid:
    """Return the prism of an outline in a profile's axes, turned to a web by its matrix (2, 2)."""
    return Solid.prism(Region.of([outline @ matrix.T]), *z_mm)


def placed_along(start_mm: Array, along: Array) -> Array:
    """Return the motion (4, 4) that takes the origin to a point and z to a direction."""
    helper = np.eye(3)[int(np.abs(along).argmin())]
    x = np.cross(helper, along)
    x = x / np.linalg.norm(x)
    motion = np.eye(4)
    motion[:3, :3] = np.column_stack([x, np.cross(along, x), along])
    motion[:3, 3] = start_mm
    return motion


# Sections of a free part at each height: its profile reduced by draft, holes and rounded corners.
#
# Draft takes the same length off every control radius for each millimetre away from the throw's crankpin. So
# the walls are ruled surfaces and the area moments are polynomials of the height: Gauss's rule integrates
# them exactly.


STRAIGHT_NODES, DRAFTED_NODES = 2, 4
"""Nodes of Gauss's rule along z: exact to z² of a prism, and to the sixth degree of a drafted one."""
HOLE_SEGMENTS = 96
ROUNDING_SAGITTA_MM = 0.01


def round_mm(diameter_mm: float, centre_mm: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Return a hole's outline (k, 2), a polygon of the circle's own area."""
    step = math.tau / HOLE_SEGMENTS
    radius = 0.5 * diameter_mm * math.sqrt(step / math.sin(step))
    angle = np.arange(HOLE_SEGMENTS) * step
    outline: Array = np.asarray(centre_mm) + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return outline


@dataclass(frozen=True, eq=False)
class FreeBody:
    """Metal of a part from its control radii and thickness, with sections that shrink by draft.

    Attributes
    ----------
    profile : Profile
    slope : float
        Length that draft takes off the control radii for each millimetre.
    corner_radius_mm : float
        Of the corners where the spline meets the sector's edges; 0: sharp.
    holes : sequence of LighteningHole
    """

    profile: Profile
    slope: float = 0.0
    corner_radius_mm: float = 0.0
    holes: Sequence[LighteningHole] = ()

    @cached_property
    def _holes_region(self) -> Region:
        return Region.of([round_mm(hole.diameter_mm, hole.centre_mm) for hole in self.holes])

    @cached_property
    def _holes_moments(self) -> AreaMoments:
        return AreaMoments(*self._holes_region.area_moments())

    def refuse_holes_outside(self, name: str) -> None:
        """Refuse holes that are not wholly in the sector, beyond the hold radius.

        Raises
        ------
        JobError
            If one is not; the message names it.
        """
        low, high = float(self.profile.angles_rad[0]), float(self.profile.angles_rad[-1])
        for number, hole in enumerate(self.holes, 1):
            x, y = hole.centre_mm
            far, around, radius = math.hypot(x, y), math.atan2(y, x), 0.5 * hole.diameter_mm
            past = (around - low) % math.tau
            reach = math.asin(min(radius / far, 1.0)) if far > 0.0 else math.pi
            if far - radius < self.profile.hold_radius_mm or not reach <= past <= high - low - reach:
                raise JobError(
                    f"{name}.holes[{number}] at ({x:g}, {y:g}) mm reaches into held metal; expected wholly "
                    f"in the sector, beyond {self.profile.hold_radius_mm:.4g} mm"
                )

    def radii_at(self, radii_mm: Array, depth_mm: float) -> Array:
        """Return the control radii at a distance from the face towards the crankpin."""
        radii: Array = np.asarray(radii_mm) - self.slope * depth_mm
        return radii

    def rounded(self, radii_mm: Array) -> Region | None:
        """Return the largest section and the held metal within it, corners rounded; None: they are sharp."""
        if self.corner_radius_mm == 0.0:
            return None
        whole = np.concatenate([self.profile.spline_points_mm(radii_mm), [[0.0, 0.0]]])
        return Region.of([whole]).rounded(self.corner_radius_mm, ROUNDING_SAGITTA_MM)

    def nodes(self, thickness_mm: float) -> tuple[Array, Array]:
        """Return distances from the face towards the crankpin and weights that integrate over them."""
        points, weights = _gauss_rule(DRAFTED_NODES if self.slope else STRAIGHT_NODES)
        return 0.5 * thickness_mm * (points + 1.0), 0.5 * thickness_mm * weights

    def moments(self, radii_mm: Array, depths_mm: Array) -> list[tuple[AreaMoments, AreaMoments]]:
        """Return the area moments at distances from the face towards the crankpin, and their gradients.

        The loss at rounded corners counts in the moments, but not in the gradients.
        """
        if not self.slope:
            return [self._section(radii_mm, 0.0)] * len(depths_mm)
        return [self._section(radii_mm, float(depth)) for depth in depths_mm]

    def _section(self, radii_mm: Array, depth_mm: float) -> tuple[AreaMoments, AreaMoments]:
        own, gradient = self.profile.moments(self.radii_at(radii_mm, depth_mm))
        rounded = self.rounded(radii_mm)
        if rounded is not None:
            count = len(self.profile.spline_points_mm(radii_mm))
            sharp = Region.of([self.profile.polygon_mm(self.radii_at(radii_mm, depth_mm), count)])
            own = _less(own, AreaMoments(*(sharp - rounded).area_moments()))
        return _less(own, self._holes_moments) if self.holes else own, gradient


@cache
def _gauss_rule(count: int) -> tuple[Array, Array]:
    return np.polynomial.legendre.leggauss(count)


def _less(one: AreaMoments, other: AreaMoments) -> AreaMoments:
    return AreaMoments(
        one.area_mm2 - other.area_mm2, one.first_mm3 - other.first_mm3, one.second_mm4 - other.second_mm4
    )
