"""Cones, tori and further cylinders about known axes, from the profiles of their corners."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from autobalance.solid.chordal_error.fits import Lines, Sets, circles, lines
from autobalance.solid.chordal_error.look import ON_SURFACE, Look, lies_on, tight_mm
from autobalance.solid.chordal_error.revolved import Revolved, cylindrical
from autobalance.solid.chordal_error.strips import FEW
from autobalance.solid.mesh.components import numbered_components
from autobalance.types import Array, Indices

ON_TUBE, LONGEST = 3e-4, 2.0
"""Distance of corners from a torus's arc, as a share of its radius, which counts as so many times the patch's
size at most. Any few points lie roughly on some arc; those of a tapered nose with a keyway lay on one of two
metres."""
MAX_ASIDE_RAD = 0.2
"""Largest angle of a facet's direction to the half-plane through its middle and the axis [rad]."""
MAX_AXIAL_SHARE = 0.01
"""Share of a facet's direction along the axis, at most, of a possible cylinder about it."""
IDLE_AXES = 8
"""Axes in a row without a surface about them that end the search, as for a free-form surface."""
AXES_MOST = 40
"""Axes tried for cones and tori, those of the largest cylinders."""
OUTER_ROUNDS, OUTER_SPREAD = 3, 3.0
"""Times that a line is fitted again to the points not farther in than so many times their median distance."""
OUTER_LEAST = 0.9
"""Share of the points that must lie on such a line: of a barrel's three to ten rings two lie on one, too."""


def axes_of(look: Look, surfaces: list[Revolved], surface_of: Indices) -> list[tuple[Array, Array]]:
    """Return the distinct axes (point, direction) of the cylinders found, those of most surface first."""
    face_of = surface_of[look.face]
    mine = face_of >= 0
    area = np.bincount(face_of[mine], look.mesh.doubled_areas[mine], len(surfaces))
    axes: list[tuple[Array, Array]] = []
    whole = np.bincount(surface_of[surface_of >= 0], minlength=len(surfaces)) >= FEW
    for number in np.flatnonzero(whole)[np.argsort(-area[whole], kind="stable")]:
        one = surfaces[number]
        for point, axis in axes:
            apart = one.point - point
            apart = apart - (apart @ axis) * axis
            if abs(axis @ one.axis) > 1.0 - 1e-6 and np.linalg.norm(apart) < ON_SURFACE * one.r0:
                break
        else:
            axes.append((one.point, one.axis))
        if len(axes) == AXES_MOST:
            break
    return axes


def find_revolved(look: Look, surfaces: list[Revolved], surface_of: Indices) -> None:
    """Find cones and tori about the axes of the cylinders among the faces left that are smooth."""
    i, j = look.pairs
    idle = 0
    for point, axis in axes_of(look, surfaces, surface_of):
        if idle == IDLE_AXES:
            return
        before = len(surfaces)
        free = (surface_of[i] < 0) & (surface_of[j] < 0)
        i, j = i[free], j[free]
        around = Around.of(look, i, j, point, axis)
        for slopes in ((-1.0, MAX_AXIAL_SHARE), (ON_SURFACE, 1.0 - 1e-8)):
            faces, patches = around.patches(*slopes)
            for fitted, place in fitted_profiles(look, faces, patches, point, axis):
                start = patches.starts[place]
                mine = faces[start : start + patches.sizes[place]]
                if (surface_of[mine] < 0).all() and lies_on(look, fitted, mine).all():
                    surface_of[mine] = len(surfaces)
                    surfaces.append(fitted)
        idle = 0 if len(surfaces) > before else idle + 1


@dataclass(frozen=True, eq=False)
class Around:
    """Smooth faces seen from an axis.

    Attributes
    ----------
    faces : (k,) int
        Those directed to the axis.
    upright : (k,) float
        The component of each one's direction along it.
    pairs : (2, n) int
        Those that meet smoothly, by their places in ``faces``.
    """

    faces: Indices
    upright: Array
    pairs: Indices

    @classmethod
    def of(cls, look: Look, i: Indices, j: Indices, point: Array, axis: Array) -> Around:
        """Return the faces of pairs (i, j) seen from an axis."""
        seen = np.zeros(look.count, dtype=bool)
        seen[i] = seen[j] = True
        faces = np.flatnonzero(seen & look.small)
        normal = look.normal[faces]
        _, r, out = cylindrical(look.first_middles[faces], point, axis)
        aside = np.abs(np.einsum("ij,ij->i", normal, np.cross(axis, out)))
        directed = (aside < MAX_ASIDE_RAD) & (r > 0.0)
        faces, upright = faces[directed], np.abs(normal[directed] @ axis)
        place = np.full(look.count, -1)
        place[faces] = np.arange(len(faces))
        pairs = np.stack([place[i], place[j]])
        return cls(faces, upright, pairs[:, (pairs >= 0).all(axis=0)])

    def patches(self, least: float, most: float) -> tuple[Indices, Sets]:
        """Return connected sets of faces that lean by ``least`` to ``most``, one after the other."""
        fit = (self.upright > least) & (self.upright < most)
        both = fit[self.pairs].all(axis=0)
        label, count = numbered_components(self.pairs[:, both].T, len(self.faces))
        size = np.bincount(label[fit], minlength=count)
        members = np.flatnonzero(fit & (size[label] > 3))
        members = members[np.argsort(label[members], kind="stable")]
        return self.faces[members], Sets.of(label[members])


def split_in_bands(look: Look, surface: Revolved, faces: Indices) -> list[tuple[Revolved, Indices]]:
    """Return cones in place of a torus, each with the faces (k,) that lean as much."""
    lean = look.normal[faces] @ surface.axis
    order = np.argsort(lean, kind="stable")
    faces, band = faces[order], np.cumsum(np.diff(lean[order], prepend=-np.inf) > MAX_AXIAL_SHARE) - 1
    sets = Sets.of(band)
    fits = fitted_profiles(look, faces, sets, surface.point, surface.axis)
    return [
        (fitted, faces[sets.starts[place] : sets.starts[place] + sets.sizes[place]])
        for fitted, place in fits
        if not fitted.tube_mm
    ]


def fitted_profiles(
    look: Look, faces: Indices, patches: Sets, point: Array, axis: Array
) -> Iterator[tuple[Revolved, int]]:
    """Fit a line (cone) or an arc (torus) to the profile (r, h) of each patch's corners; yield what fits."""
    if len(faces) == 0:
        return
    row, corner = look.corners(faces)
    h, r, _ = cylindrical(corner, point, axis)
    sets = Sets.of(patches.number[row])
    profile = np.stack([r, h], axis=1)
    size = (sets.most(profile) - sets.least(profile)).max(axis=1)
    straight = _outer_lines(profile, sets, tight_mm(look), ON_SURFACE * size)
    round_ = circles(profile, sets)
    is_line = (straight.worst_mm <= ON_SURFACE * size) & (np.abs(straight.direction[:, 1]) > 1e-9)
    slack = ON_TUBE * np.minimum(round_.radius, LONGEST * size)
    is_arc = ~is_line & (round_.worst_mm <= slack) & np.isfinite(round_.radius)
    for place in np.flatnonzero(is_line | is_arc).tolist():
        if is_line[place]:
            yield cone(point, axis, straight.middle[place], straight.direction[place]), place
        else:
            yield torus(point, axis, round_.centre[place], float(round_.radius[place])), place


def _outer_lines(profile: Array, sets: Sets, tight: float, slack: Array) -> Lines:
    """Fit a line to each set of points (r, h), through the outer ones alone where these lie on one exactly.

    If a keyway or a hole cuts a chord, corners lie on the chord, nearer to the axis than the surface. The
    corners of a tapered nose with a keyway drew the line 0.7 µm in at 48 segments, under all 48 facets of the
    nose.
    """
    tried = best = lines(profile, sets)
    rows = sets.rows((best.worst_mm > tight) & (best.worst_mm <= slack))
    for _ in range(OUTER_ROUNDS):
        if len(rows) == 0:
            break
        out, some = _outward(profile[rows], tried, sets.number[rows]), Sets.of(sets.number[rows])
        out -= some.medians(out)[some.number]
        spread = some.medians(np.abs(out))[some.number]
        rows = rows[out >= -OUTER_SPREAD * spread - tight]
        some = Sets.of(sets.number[rows])
        which, again = sets.number[rows[some.starts]], lines(profile[rows], some)
        most = some.sizes >= OUTER_LEAST * sets.sizes[which]
        exact = most & (again.worst_mm <= tight)
        tried, best = tried.with_(which, again), best.with_(which[exact], again.of(exact))
        rows = rows[some.rows(most & ~exact)]
    return replace(best, worst_mm=sets.most(np.abs(_outward(profile, best, sets.number))))


def _outward(profile: Array, fitted: Lines, number: Indices) -> Array:
    """Return the distances of points (n, 2) from the lines of their sets, away from the axis."""
    across, along = (fitted.direction * np.where(fitted.direction[:, 1:] < 0.0, -1.0, 1.0))[number].T
    r, h = (profile - fitted.middle[number]).T
    out: Array = along * r - across * h
    return out


def cone(point: Array, axis: Array, middle: Array, direction: Array) -> Revolved:
    """Return the cone or cylinder whose profile (r, h) is the line through ``middle`` along ``direction``."""
    slope = float(direction[0] / direction[1])
    return Revolved(point, axis, float(middle[0] - slope * middle[1]), slope)


def torus(point: Array, axis: Array, centre: Array, tube_mm: float) -> Revolved:
    """Return the torus whose profile (r, h) is the circle about ``centre``."""
    return Revolved(point, axis, float(centre[0]), 0.0, float(centre[1]), tube_mm)
