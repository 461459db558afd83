"""Cylinders from strips of chords, and cones and tori from the profiles of their corners."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from autobalance.solid.chordal_error.look import ON_SURFACE, Look, lies_on, tight_mm
from autobalance.solid.chordal_error.revolved import (
    Lines,
    RevolvedSurface,
    Sets,
    across,
    circles,
    cylindrical,
    least_directions,
    lines,
)
from autobalance.solid.mesh.adjacency import unit
from autobalance.solid.mesh.mesh import numbered_components
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

# Cylinders from strips of chords of one circle.


MIN_SURE_FACES = 16
"""Faces of a strip from which on its circle is not an accident, even if a few ends lie off it."""
EQUAL_CIRCLE_SHARE = 0.03
"""Largest difference of radius and centre between two chords' circles, as a share of the radius."""
CHORD_RATIO = 0.8, 1.25
"""Sag of a chord over that of its width, for most chords of a strip."""
MAX_SAG_RATIO = 4.5
"""Sag of a chord compared with the median of its strip, at most: twice as wide, four times as deep."""
FEW, UNEVEN_OF_FEW = 8, 1.3
"""Any trapezoid has a circle through its corners: strips of fewer chords must be even."""
MIN_RULING_COSINE = 1.0 - 1e-6
"""Cosine between the rulings of one cylinder, at least."""


@dataclass(frozen=True, eq=False)
class Chords:
    """Pairs of faces that meet at a straight, smooth edge, as chords of one circle.

    Attributes
    ----------
    i, j : (n,) int
        The faces.
    axis : (n, 3) float
        Along the edge.
    middle, u, v : (n, 3) float
        A point of the edge, and from there to the far sides of the faces, across the axis.
    centre : (n, 3) float
        Of the circle through the three.
    radius : (n,) float
    """

    i: Indices
    j: Indices
    axis: Array
    middle: Array
    u: Array
    v: Array
    centre: Array
    radius: Array


def find_cylinders(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> None:
    """Find strips of chords of one circle, fit their cylinders and assign the faces to them."""
    chords = _chords(look)
    members, sets = _strip_members(look, chords)
    if len(members) == 0:
        return
    pairs = np.concatenate([chords.i[members], chords.j[members]])
    own = np.unique(np.tile(sets.number, 2) * look.count + pairs)
    faces = own % look.count
    faces_of = Sets.of(own // look.count)
    for number, fitted in _fitted(look, chords, members, sets, faces, faces_of):
        start = faces_of.starts[number]
        mine = faces[start : start + faces_of.sizes[number]]
        mine = mine[surface_of[mine] < 0]
        if len(mine) > 2:
            mine = mine[lies_on(look, fitted, mine) & _is_chord(look, fitted, mine)]
        if len(mine) > 2:
            surface_of[mine] = len(surfaces)
            surfaces.append(fitted)
    _spread(look, surfaces, surface_of)


def _chords(look: Look) -> Chords:
    """Return the pairs of faces that may be neighbouring chords of a circle."""
    i, j = look.pairs
    _, once, _ = look.distinct_pairs
    i, j, ends = i[once], j[once], look.mesh.vertices[look.edges.ends[look.smooth[once]]]
    axis = unit(np.cross(look.normal[i], look.normal[j]))
    along = ends[:, 1] - ends[:, 0]
    straight = np.abs(np.einsum("ij,ij->i", axis, along)) > 0.999 * np.linalg.norm(along, axis=1)
    keep = straight & look.small[i] & look.small[j]
    i, j, axis, middle = i[keep], j[keep], axis[keep], ends[keep].mean(axis=1)
    u, v = _far_side(look, i, axis, middle), _far_side(look, j, axis, middle)
    cross = np.cross(u, v)
    size = np.square(cross).sum(axis=1)
    good = size > 1e-24 * look.mesh.diagonal_mm**4
    i, j, axis, middle, u, v, cross, size = (
        values[good] for values in (i, j, axis, middle, u, v, cross, size)
    )
    lift = np.square(u).sum(1)[:, None] * v - np.square(v).sum(1)[:, None] * u
    offset = np.cross(lift, cross) / (2.0 * size[:, None])
    return Chords(i, j, axis, middle, u, v, middle + offset, np.linalg.norm(offset, axis=1))


def _strip_members(look: Look, chords: Chords) -> tuple[Indices, Sets]:
    """Return the chords of strips that may be cylinders, strip by strip."""
    strip = _strips(chords)
    members = np.argsort(strip, kind="stable")
    members, sets = _chosen(members, strip, np.bincount(strip)[strip[members]] > 1)
    if len(members) == 0:
        return members, sets
    first = chords.axis[members[sets.starts]]
    aligned = np.abs(np.einsum("ij,ij->i", chords.axis[members], first[sets.number]))
    members, sets = _chosen(members, strip, (sets.least(aligned) > MIN_RULING_COSINE)[sets.number])
    if len(members) == 0:
        return members, sets
    return _chosen(members, strip, ~_turning(look, chords, members, sets)[sets.number])


def _chosen(members: Indices, strip: Indices, kept: Flags) -> tuple[Indices, Sets]:
    chosen = members[kept]
    return chosen, Sets.of(strip[chosen])


def _turning(look: Look, chords: Chords, members: Indices, sets: Sets) -> Flags:
    """Mark the strips (k,) beside others of one radius whose axis turns: pieces of a torus or a ball."""
    strip_of = np.full(look.count, -1)
    for faces in (chords.i[members], chords.j[members]):
        np.maximum.at(strip_of, faces, sets.number)
    direction, size = chords.axis[members[sets.starts]], sets.medians(chords.radius[members])
    a, b = (strip_of[faces] for faces in look.pairs)
    beside = (a >= 0) & (b >= 0) & (a != b)
    a, b = a[beside], b[beside]
    turning = np.abs(np.einsum("ij,ij->i", direction[a], direction[b])) < 1.0 - 1e-7
    turning &= np.abs(size[a] - size[b]) < EQUAL_CIRCLE_SHARE * np.minimum(size[a], size[b])
    false = np.zeros(len(size), dtype=bool)
    a, b = a[turning], b[turning]
    count = sets.sizes
    false[a[2 * count[b] >= count[a]]] = True  # a whole cylinder beside a piece stays
    false[b[2 * count[a] >= count[b]]] = True
    return false


def _fitted(
    look: Look, chords: Chords, members: Indices, sets: Sets, faces: Indices, faces_of: Sets
) -> Iterator[tuple[int, RevolvedSurface]]:
    """Fit a cylinder to the ruling lines of each strip; yield those that pass through them all."""
    normal = look.normal[faces]
    axis = least_directions(normal, faces_of)
    lean = faces_of.most(np.abs(np.einsum("ij,ij->i", normal, axis[faces_of.number])))
    one, other = across(axis)
    middle = chords.middle[members]
    rulings = np.stack([middle, middle + chords.u[members], middle + chords.v[members]], axis=1)
    number = sets.number
    flat = np.stack(
        [np.einsum("nkd,nd->nk", rulings, one[number]), np.einsum("nkd,nd->nk", rulings, other[number])],
        axis=2,
    )
    fitted = circles(flat.reshape(-1, 2), Sets(3 * sets.starts, 3 * sets.count))
    slack = ON_SURFACE * fitted.radius
    few = faces_of.sizes < MIN_SURE_FACES
    slack[few] = np.minimum(slack[few], 4.0 * tight_mm(look))
    fits = (lean <= ON_SURFACE) & (fitted.worst_mm <= slack) & (faces_of.sizes > 2)
    fits &= np.isfinite(fitted.radius)
    for strip in np.flatnonzero(fits).tolist():
        point = fitted.centre[strip] @ np.stack([one[strip], other[strip]])
        yield strip, RevolvedSurface(point, axis[strip], float(fitted.radius[strip]))


def _far_side(look: Look, faces: Indices, axis: Array, middle: Array) -> Array:
    """Return, across the axis, the vector (k, 3) from a ruling line to the far side of a face beside it."""
    across = np.cross(axis, look.normal.take(faces, axis=0))
    row, point = look.corners(faces)
    point -= middle.take(row, axis=0)
    reach = np.einsum("ij,ij->i", point, across.take(row, axis=0))
    far = np.zeros(len(faces))
    near = np.zeros(len(faces))
    np.maximum.at(far, row, reach)
    np.minimum.at(near, row, reach)
    return np.where(far > -near, far, near)[:, None] * across


def _strips(chords: Chords) -> Indices:
    """Group chord pairs that share a face and have one circle; return the group of each."""
    axis, centre, radius, count = chords.axis, chords.centre, chords.radius, len(chords.i)
    face = np.concatenate([chords.i, chords.j])
    pair = np.tile(np.arange(count), 2)
    order = np.lexsort((radius[pair], face))
    links = []
    for step in (1, 2, 3):
        one, other = order[:-step], order[step:]
        a, b = pair[one], pair[other]
        apart = centre[b] - centre[a]
        apart -= np.einsum("ij,ij->i", apart, axis[a])[:, None] * axis[a]
        least = np.minimum(radius[a], radius[b])
        alike = (face[one] == face[other]) & (np.abs(radius[a] - radius[b]) < EQUAL_CIRCLE_SHARE * least)
        alike &= np.linalg.norm(apart, axis=1) < EQUAL_CIRCLE_SHARE * least
        alike &= np.abs(np.einsum("ij,ij->i", axis[a], axis[b])) > 0.999
        links.append(np.stack([a[alike], b[alike]], axis=1))
    return numbered_components(np.concatenate(links), count)[0]


def _is_chord(look: Look, cylinder: RevolvedSurface, faces: Indices) -> Flags:
    """Mark the faces (k,) of a strip with the depth of a chord of their width; none if most have another."""
    across = np.cross(cylinder.axis, look.normal[faces])
    row, point = look.corners(faces)
    reach = np.einsum("ij,ij->i", point - cylinder.point, across[row])
    least, most = np.full(len(faces), np.inf), np.full(len(faces), -np.inf)
    np.minimum.at(least, row, reach)
    np.maximum.at(most, row, reach)
    half = 0.5 * (most - least)
    expected = cylinder.r0 - np.sqrt(np.maximum(0.0, cylinder.r0**2 - half**2))
    depth = _Table([cylinder]).depth(look, faces, np.zeros(len(faces), dtype=np.int64))
    ratio = float(np.median(depth / np.maximum(expected, 1e-12)))
    if not CHORD_RATIO[0] < ratio < CHORD_RATIO[1]:
        return np.zeros(len(faces), dtype=bool)
    if len(faces) < FEW and not _turns_twice(look, cylinder, faces):
        return np.zeros(len(faces), dtype=bool)
    uneven = MAX_SAG_RATIO if len(faces) >= FEW else UNEVEN_OF_FEW
    return np.asarray(depth < uneven * np.median(depth))


def _turns_twice(look: Look, cylinder: RevolvedSurface, faces: Indices) -> bool:
    """Return whether a strip of few faces has three directions at least; pieces of one plane count once."""
    basis = np.linalg.svd(cylinder.axis[None])[2][1:]
    x, y = (look.normal[faces] @ basis.T).T
    angle = np.sort(np.unwrap(np.arctan2(y, x)))
    steps = np.diff(angle)
    return bool((steps > 0.1 * steps.max(initial=0.0)).sum() >= 2)


def _spread(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> None:
    """Assign to cylinders the faces beside theirs whose corners lie between facets and circle."""
    if not surfaces:
        return
    i, j = look.pairs
    table = _Table(surfaces)
    sag = np.zeros(len(surfaces))
    mine = np.flatnonzero(surface_of >= 0)
    np.maximum.at(sag, surface_of[mine], table.depth(look, mine, surface_of[mine]))
    beside = np.concatenate([np.stack([i, j]), np.stack([j, i])], axis=1)
    beside = beside[:, look.small[beside[0]]]
    for _ in range(4):
        beside = beside[:, surface_of[beside[0]] < 0]
        face, source = beside[:, surface_of[beside[1]] >= 0]
        pairs = np.unique(face * len(surfaces) + surface_of[source])
        face, surface = pairs // len(surfaces), pairs % len(surfaces)
        if len(face) == 0:
            return
        row, point = look.corners(face)
        here = surface[row]
        off, slack = table.off(point, here), ON_SURFACE * table.radius[here]
        fits = np.ones(len(face), dtype=bool)
        fits[row[(off > slack) | (off < -sag[here] - slack)]] = False
        fits &= np.abs(np.einsum("ij,ij->i", look.normal[face], table.axis[surface])) <= ON_SURFACE
        fits &= table.depth(look, face, surface) <= 1.05 * sag[surface] + 1e-9
        surface_of[face[fits]] = surface[fits]


class _Table:
    """Points, axes and radii of cylinders, to be looked up by their numbers."""

    def __init__(self, cylinders: list[RevolvedSurface]) -> None:
        self.point = np.array([one.point for one in cylinders]).reshape(-1, 3)
        self.axis = np.array([one.axis for one in cylinders]).reshape(-1, 3)
        self.radius = np.array([one.r0 for one in cylinders])

    def off(self, points: Array, number: Indices) -> Array:
        """Return the distance of points (n, 3) from cylinders by number (n,), outside positive [mm]."""
        local, axis = points - self.point[number], self.axis[number]
        local = local - np.einsum("ij,ij->i", local, axis)[:, None] * axis
        away: Array = np.sqrt(np.einsum("ij,ij->i", local, local)) - self.radius[number]
        return away

    def depth(self, look: Look, faces: Indices, number: Indices) -> Array:
        """Return the largest depth of each face's plane below its cylinder [mm] (k,)."""
        point = look.mesh.vertices[look.mesh.triangles[look.order[look.starts[faces]], 0]]
        height = np.einsum("ij,ij->i", point - self.point[number], look.normal[faces])
        deep: Array = self.radius[number] - np.abs(height)
        return deep


# Cones, tori and further cylinders about known axes, from the profiles of their corners.


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


def axes_of(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> list[tuple[Array, Array]]:
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


def find_revolved(
    look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, axes: list[tuple[Array, Array]]
) -> None:
    """Find cones and tori about known axes among the faces left that are smooth."""
    i, j = look.pairs
    idle = 0
    for point, axis in axes:
        if idle == IDLE_AXES:
            return
        before = len(surfaces)
        free = (surface_of[i] < 0) & (surface_of[j] < 0)
        i, j = i[free], j[free]
        around = AroundAxis.of(look, i, j, point, axis)
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
class AroundAxis:
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
    def of(cls, look: Look, i: Indices, j: Indices, point: Array, axis: Array) -> AroundAxis:
        """Return the faces of pairs (i, j) seen from an axis."""
        seen = np.zeros(look.count, dtype=bool)
        seen[i] = seen[j] = True
        faces = np.flatnonzero(seen & look.small)
        normal = look.normal[faces]
        _, r, out = cylindrical(look.first_middles(faces), point, axis)
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


def split_in_bands(
    look: Look, surface: RevolvedSurface, faces: Indices
) -> list[tuple[RevolvedSurface, Indices]]:
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
) -> Iterator[tuple[RevolvedSurface, int]]:
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


def cone(point: Array, axis: Array, middle: Array, direction: Array) -> RevolvedSurface:
    """Return the cone or cylinder whose profile (r, h) is the line through ``middle`` along ``direction``."""
    slope = float(direction[0] / direction[1])
    return RevolvedSurface(point, axis, float(middle[0] - slope * middle[1]), slope)


def torus(point: Array, axis: Array, centre: Array, tube_mm: float) -> RevolvedSurface:
    """Return the torus whose profile (r, h) is the circle about ``centre``."""
    return RevolvedSurface(point, axis, float(centre[0]), 0.0, float(centre[1]), tube_mm)
