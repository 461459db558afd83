"""Error bars of surfaces that were fitted to facets, and of smooth facets that none was fitted to.

The volume between facets and a surface through their corners is exact. It may still be off for three reasons.
At a seam the lenses over two surfaces leave a wedge, or both count it: the true seam leaves its chord by a
sag e, and the wedge has an area of e². Corners may lie off the surface. And few corners lie on many surfaces:
a strip of three chords has a circle through its corners on any surface.
"""

from __future__ import annotations

import math

import numpy as np

from autobalance.solid.chordal_error.look import ON_SURFACE, Look, tight_mm
from autobalance.solid.chordal_error.revolved import Lens, RevolvedSurface, Sets, cylindrical
from autobalance.solid.chordal_error.strips import FEW, MIN_SURE_FACES, axes_of
from autobalance.solid.chordal_error.turns import AS_WIDE, goes_on_beyond, turns_of, wide_of
from autobalance.solid.mesh.adjacency import unit
from autobalance.solid.mesh.mesh import ranked
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

NONE, FLAT = -1, -2
"""Stands for a surface's number: faces without a fitted surface, and planes of the part."""
UNSURE_SHARE = 0.04
"""Error bar of a surface that few corners would show to be another, as a share of its contribution."""
SURE_SHARE = 5e-4
"""Error bar of any other: 1e-4 is seen of generated cranks, where holes break through slanted walls."""
LOOSE_SHARE = 1.5
"""Error bar of a smooth surface that was not fitted, as a share of the estimate from its angles."""
SEAM_SAFETY = 2.0
"""Wedges at seams are counted so many times, besides: the direction of a surface turns along the sag."""
BESIDE_SAFETY = 3.0
"""Times that the distance of a face's nearest corner from its surface counts."""
ABOUT_AXIS, LINES_ABOUT_AXIS = 4.0, 5
"""Distances from a known axis may differ by so many times the rounding of corners along a short arc of at
least that many lines. The webs' arcs of four chords, at 48 segments: their 4 % was half of the bar of cranks
whose throws cancel. For three chords, equal on both sides of a plane through the axis, one distance is free.
No other distance is left to show that it is not an arc."""
LEAST_SINE = 0.02
"""Smallest sine of the angle between two surfaces at a seam: below it they are tangent, with one sag,
and its rounding over the sine would have no bound."""
SAME_PROFILE = 1e-3
"""Corners of a profile closer than this share of its size are one point of it."""
LOOKED_AT = 300
"""Facets of a surface whose corners are looked at for the points of its profile."""
PAIRS_MOST = 2000
"""Pairs of facets of a surface that are looked at for its largest angle."""
BESIDE_MOST = 2000
"""Facets of a surface whose corners are looked at for their distance from it."""
PROFILE_MORE = 1
"""Points of a profile beyond those that fix its line or arc, from which on a match is not an accident."""
FEW_OF_PROFILE = 4
"""Points of a profile up to which an arc through them may be an accident: so is that of a chamfered rim."""
TANGENT_SHARE = 0.35
"""Angle between a surface and the face next to it up to which it continues that face, as a share of the
largest angle between its own facets. The angle is zero where an arc ends as it was drawn, and half if there
is no arc."""
PLANE_SHARE = 2e-3
"""Angle of a face to a sure cylinder next to it up to which it is a plane that blends into it, as a share of
its angle to the next face. It is half for a chord of an arc, a sixth for one of a clothoid. Flanks of two
planes at 4° or 7° would otherwise pass as arcs in a mesh of 48 segments."""
BOTH_SIDES = 2
"""Neighbours into which a fillet goes over: a match of its three points is then no accident."""
EITHER_SHARE = 1.05
"""Error bar of a surface that may as well be planes, as a share of its contribution: all of it."""
NEARLY_TANGENT_RAD = 0.3
"""Angle between two surfaces at a seam up to which their wedge is flat, maybe longer than their faces."""
COARSER = 1.5
"""A facet is not a chord if it turns by more than so many times the largest angle between facets of a mesh's
surfaces, and would be deeper than so many times their largest sag. Exporters bound one or the other."""


@dataclass(frozen=True, eq=False)
class ErrorBar:
    """An error bar: its mass [g], its first moment across z [g·mm], and that times z and z² (2,)."""

    mass_g: float
    unbalance_g_mm: float
    along: Array

    @classmethod
    def of(cls, mass: Array, middle: Array) -> ErrorBar:
        """Add up masses (n,) at places (n, 3), none taken from another."""
        size, z = mass * np.hypot(middle[:, 0], middle[:, 1]), middle[:, 2]
        return cls(float(mass.sum()), float(size.sum()), np.array([size @ z, size @ z**2]))

    def __add__(self, other: ErrorBar) -> ErrorBar:
        return ErrorBar(
            self.mass_g + other.mass_g, self.unbalance_g_mm + other.unbalance_g_mm, self.along + other.along
        )


def fitted_bar(
    look: Look,
    surfaces: list[RevolvedSurface],
    surface_of: Indices,
    lenses: list[Lens],
    either: Flags,
    angles: Array,
    density_g_mm3: float,
) -> ErrorBar:
    """Return the error bar of the surfaces fitted; ``angles`` (k,) are the largest between their facets.

    Of those that may be ``either`` surfaces or planes (k,) it is all they hide, of others a share; corners
    beside them, and seams, are added.
    """
    seams = Seams.of(look, surface_of)
    unsure = _unsure(look, surfaces, surface_of, seams, angles)
    total = ErrorBar(0.0, 0.0, np.zeros(2))
    used = np.unique(surface_of[surface_of >= 0]).tolist()
    for number in used:
        one = lenses[number]
        share = EITHER_SHARE if either[number] else UNSURE_SHARE if unsure[number] else SURE_SHARE
        total = total + ErrorBar(
            share * one.gross_mass_g, share * one.gross_unbalance_g_mm, share * one.gross_at
        )
    total = total + _of_samples([lenses[number] for number in used])
    beside, at = _beside(look, surfaces, surface_of)
    wedges, seam = _wedges(look, surfaces, surface_of, seams)
    return total + ErrorBar.of(density_g_mm3 * beside, at) + ErrorBar.of(density_g_mm3 * wedges, seam)


def _of_samples(lenses: list[Lens]) -> ErrorBar:
    """Return the error bar of lenses known from samples of their facets, which err independently."""
    mass, unbalance = (math.hypot(*(one.spread[k] for one in lenses)) for k in (0, 1))
    sampled = [one for one in lenses if one.spread[1] > 0.0]
    gross = sum((one.gross_unbalance_g_mm for one in sampled), 0.0)
    at = sum((one.gross_at for one in sampled), np.zeros(2)) / (gross or 1.0)
    return ErrorBar(mass, unbalance, unbalance * at)


def loose_bar(
    look: Look,
    surfaces: list[RevolvedSurface],
    surface_of: Indices,
    sag_mm: float,
    angles: Array,
    density_g_mm3: float,
) -> ErrorBar:
    """Return the error bar of smooth facets that no surface was fitted to: L w² δ / 12 at each edge.

    ``sag_mm`` and ``angles`` (k,) are the largest of the surfaces fitted. Only edges count at which facets
    about as wide keep turning the same way. A blunt edge between two planes is real, also where each ends in
    the narrow chords of an arc. A facet between two wider ones may be the only chord of its arc. If it turns
    by more than the mesh's chords do, and would be deeper, it is a chamfer. Nor is a plane a chord if it
    blends into a sure cylinder.
    """
    free = surface_of == NONE
    i, j = look.pairs
    open_ = np.zeros(look.count, dtype=bool)
    both = np.flatnonzero(free.take(i) & free.take(j))
    if len(both) == 0:
        return ErrorBar(0.0, 0.0, np.zeros(2))
    open_[i[both]] = open_[j[both]] = True
    beside = open_.take(i) | open_.take(j)
    near = open_.copy()
    near[i[beside]] = near[j[beside]] = True
    sure, steepest = _sure_cylinders(surfaces, surface_of), angles.max(initial=0.0)
    if not near.all():
        faces = np.flatnonzero(near)
        look, free, open_, surface_of = look.part(faces), free[faces], open_[faces], surface_of[faces]
    lean = lean_to_sure(look, surfaces, surface_of, sure)
    meet = look.meetings
    rows = np.flatnonzero(open_[meet.low] | open_[meet.high])
    between = (free[meet.low] & free[meet.high])[rows]
    turns = turns_of(look, rows)
    wide = wide_of(look, turns, meet.length_mm[rows])
    chords = between & goes_on_beyond(look, turns, wide).any(axis=0)
    alike = wide.max(axis=0) < AS_WIDE * wide.min(axis=0)
    angle = meet.angle_rad[rows]
    steep = (steepest > 0.0) & (angle > COARSER * steepest) & (meet.sag_mm[rows] > COARSER * sag_mm)
    counts = chords & (alike | ~steep)
    counts &= np.minimum(lean[meet.low[rows]], lean[meet.high[rows]]) >= PLANE_SHARE * angle
    rows = rows[counts]
    return ErrorBar.of(LOOSE_SHARE * density_g_mm3 * meet.hidden_mm3[rows], meet.middle[rows])


def accidents(
    look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, lenses: list[Lens], angles: Array
) -> tuple[Flags, Flags]:
    """Mark the surfaces (k,) of a few planes whose corners lie on one arc by accident, and those that may be.

    So do the four of any chamfered rim, and three of any two cones in a row. Nothing continues them without
    an edge. They are sure if they are coarser than the mesh's other surfaces, by their angles and by their
    sag.
    """
    count = _counts(surfaces, surface_of)
    few = (_points(look, surfaces, surface_of) <= FEW_OF_PROFILE) | (count < FEW)
    few &= (count > 0) & np.array([bool(one.tube_mm) or not one.slope for one in surfaces], dtype=bool)
    if few.any():
        few &= _goes_over(look, surfaces, surface_of, few, Seams.of(look, surface_of), angles) == 0
    sure = (count >= MIN_SURE_FACES) & ~few
    if not few.any() or not sure.any():
        return np.zeros(len(surfaces), dtype=bool), few
    sags = np.array([one.sag_mm for one in lenses])
    planes = (angles > COARSER * angles[sure].max()) & (sags > COARSER * sags[sure].max())
    lean = lean_to_sure(look, surfaces, surface_of, _sure_cylinders(surfaces, surface_of))
    some = np.flatnonzero(np.isfinite(lean) & (surface_of >= 0))
    least = np.full(len(surfaces), np.inf)
    np.minimum.at(least, surface_of[some], lean[some])
    planes |= least < PLANE_SHARE * angles
    return few & planes, few & ~planes


def lean_to_sure(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, sure: Flags) -> Array:
    """Return the angle (count,) of each face to a ``sure`` (k,) cylinder next to it; infinite without one.

    A plane that goes over into an arc does so to rounding. A chord leans to what its curve goes over into by
    half of what it turns.
    """
    sure = np.append(sure, [False, False])  # of no surface, and of planes: the last
    lean = np.full(look.count, np.inf)
    smooth = look.smooth
    for face, other in (look.pairs, look.pairs[::-1]):
        seam = np.flatnonzero(sure[surface_of[other]] & (surface_of[face] != surface_of[other]))
        middle = look.mesh.vertices[look.edges.ends[smooth[seam]]].mean(axis=1)
        _, out, _ = _seen(look, surfaces, surface_of[other[seam]], other[seam], middle)
        sine = np.linalg.norm(np.cross(out, look.normal[face[seam]]), axis=1)
        np.minimum.at(lean, face[seam], sine)
    return lean


def largest_angles(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> Array:
    """Return the largest angle between two facets of each surface (k,); of very many some are looked at."""
    i, j = look.pairs
    one = surface_of.take(i)
    rows = np.flatnonzero((one >= 0) & (one == surface_of.take(j)))
    number, order = ranked(one.take(rows))
    kept, _ = Sets.of(number).thinned(PAIRS_MOST)
    rows = rows.take(order.take(kept))
    a, b = (look.normal.take(each.take(rows), axis=0) for each in (i, j))
    sine = np.linalg.norm(np.cross(a, b), axis=1)
    angles = np.zeros(len(surfaces))
    np.maximum.at(angles, number.take(kept), np.arctan2(sine, np.einsum("ij,ij->i", a, b)))
    return angles


@dataclass(frozen=True, eq=False)
class Seams:
    """The edges (n,) between faces of different surfaces, or of none, and the faces on their two sides."""

    edge: Indices
    left: Indices
    right: Indices

    @classmethod
    def of(cls, look: Look, surface_of: Indices) -> Seams:
        """Find them among all edges of a mesh."""
        number = surface_of.take(look.face)
        edge = np.flatnonzero(number.take(look.edges.left) != number.take(look.edges.right))
        return cls(
            edge, look.face.take(look.edges.left.take(edge)), look.face.take(look.edges.right.take(edge))
        )


def _goes_over(
    look: Look,
    surfaces: list[RevolvedSurface],
    surface_of: Indices,
    asked: Flags,
    seams: Seams,
    angles: Array,
) -> Indices:
    """Return into how many surfaces or planes beside it each surface (k,) asked goes over without an edge."""
    mine = np.append(asked, [False, False])[surface_of]  # of no surface: the last
    some = np.flatnonzero(mine[seams.left] | mine[seams.right])
    seam, left, right = seams.edge[some], seams.left[some], seams.right[some]
    middle = look.mesh.vertices[look.edges.ends[seam]].mean(axis=1)
    one, other = surface_of[left], surface_of[right]
    out = [_seen(look, surfaces, *side, middle)[1] for side in ((one, left), (other, right))]
    edge = np.arccos(np.clip(np.einsum("ij,ij->i", *out), -1.0, 1.0))
    into = np.where(surface_of >= 0, surface_of, len(surfaces) + np.arange(look.count))
    pairs = []
    for number, next_ in ((one, right), (other, left)):
        smooth = (number >= 0) & (edge < TANGENT_SHARE * angles[number])
        pairs.append(np.stack([number[smooth], into[next_[smooth]]]))
    number = np.unique(np.concatenate(pairs, axis=1), axis=1)[0]
    return np.bincount(number, minlength=len(surfaces))


def _counts(surfaces: list[RevolvedSurface], surface_of: Indices) -> Indices:
    """Return the number of faces of each surface (k,)."""
    return np.bincount(surface_of[surface_of >= 0], minlength=len(surfaces))


def _points(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> Indices:
    """Return the number of points in the profile of each cone and torus (k,); for a cylinder, its faces.

    Of many facets some are looked at, enough for a few points.
    """
    points = _counts(surfaces, surface_of)
    for number in np.flatnonzero(points).tolist():
        surface = surfaces[number]
        if not surface.tube_mm and not surface.slope:
            continue
        mine = np.flatnonzero(surface_of == number)
        _, corner = look.corners(mine[:: 1 + len(mine) // LOOKED_AT])
        h, r, _ = cylindrical(corner, surface.point, surface.axis)
        where = np.arctan2(h - surface.h0, r - surface.r0) * surface.tube_mm if surface.tube_mm else h
        where = np.sort(where)
        steps = np.diff(where) > SAME_PROFILE * (where[-1] - where[0])
        points[number] = 1 + np.count_nonzero(steps)
    return points


def _unsure(
    look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, seams: Seams, angles: Array
) -> Flags:
    """Mark the surfaces (k,) that hold too few facets, or whose profile has too few points, to be sure of.

    A surface that blends into its neighbours on two sides is sure: a match of a fillet's three points is not
    an accident.
    """
    least = [3 if one.tube_mm else 2 if one.slope else 0 for one in surfaces]
    scarce = _points(look, surfaces, surface_of) < np.array(least) + PROFILE_MORE
    count = _counts(surfaces, surface_of)
    unsure = (count > 0) & ((count < FEW) | scarce)
    if unsure.any():
        unsure &= _goes_over(look, surfaces, surface_of, unsure, seams, angles) < BOTH_SIDES
        unsure &= ~_about_sure_axes(look, surfaces, surface_of, unsure, angles)
    return np.asarray(unsure)


def _about_sure_axes(
    look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, asked: Flags, angles: Array
) -> Flags:
    """Mark the short arcs (k,) asked whose corners all lie at one distance from the axis of a sure cylinder.

    Only the distance is free then, if a strip alone has a circle's three; it turns by no more than the mesh's
    sure surfaces do.
    """
    sure = _sure_cylinders(surfaces, surface_of)
    found = np.zeros(len(surfaces), dtype=bool)
    straight = np.array([not one.tube_mm and not one.slope for one in surfaces], dtype=bool)
    asked = asked & straight & (angles <= COARSER * angles[sure].max(initial=0.0))
    if not asked.any():
        return found
    tight = ABOUT_AXIS * tight_mm(look)
    mine = (surface_of >= 0) & sure[surface_of]
    axes = axes_of(look, surfaces, np.where(mine, surface_of, NONE))
    for number in np.flatnonzero(asked).tolist():
        _, corner = look.corners(np.flatnonzero(surface_of == number))
        found[number] = any(_is_arc_about(corner, *one, tight) for one in axes)
    return found


def _is_arc_about(corner: Array, point: Array, axis: Array, tight: float) -> bool:
    """Tell whether corners (n, 3) lie at one distance from an axis, in directions enough to show it."""
    _, r, out = cylindrical(corner, point, axis)
    if np.ptp(r) > tight:
        return False
    middle = unit(out.mean(axis=0))
    turn = np.sort(np.arctan2(np.cross(middle, out) @ axis, out @ middle))
    steps = np.diff(turn)
    return bool(1 + np.count_nonzero(steps > SAME_PROFILE * (turn[-1] - turn[0])) >= LINES_ABOUT_AXIS)


def _sure_cylinders(surfaces: list[RevolvedSurface], surface_of: Indices) -> Flags:
    """Mark the cylinders (k,) of so many faces that no accident made them."""
    straight = [not one.tube_mm and not one.slope for one in surfaces]
    return np.array(straight, dtype=bool) & (_counts(surfaces, surface_of) >= MIN_SURE_FACES)


def _beside(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> tuple[Array, Array]:
    """Return the volume [mm³] between each face's corners and its surface, and its place.

    Of a surface of very many facets some count for all. The nearest corner counts: others may lie on a chord
    of the facet, where another surface's facets meet it. The lens over a facet is exact for any outline.
    """
    faces = np.flatnonzero(surface_of >= 0)
    number, order = ranked(surface_of.take(faces))
    kept, times = Sets.of(number).thinned(BESIDE_MOST)
    faces = faces.take(order.take(kept))
    row, corner = look.corners(faces)
    number = surface_of[faces][row]
    nearest = np.full(len(faces), np.inf)
    if len(row):
        sets = Sets.of(number)
        for start, size in zip(sets.starts.tolist(), sets.sizes.tolist(), strict=True):
            mine = slice(start, start + size)
            off = np.abs(surfaces[int(number[start])].off(corner[mine]))
            np.minimum.at(nearest, row[mine], off)
    nearest[~np.isfinite(nearest)] = 0.0
    size = np.maximum(np.bincount(row, minlength=len(faces)), 1)
    place = np.stack([np.bincount(row, column, len(faces)) / size for column in corner.T], axis=1)
    return BESIDE_SAFETY * times * nearest * look.area_mm2[faces], place


def _wedges(
    look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, seams: Seams
) -> tuple[Array, Array]:
    """Return the volume [mm³] of the wedge at each seam, and its place.

    Across the seam the wedge has four corners: the chord, where the direction away from either axis meets its
    surface, and where the two surfaces meet. As wide as in the middle of the chord it counts to both ends.
    Between two almost tangent surfaces it ends with the smaller of the two faces.
    """
    left, right = seams.left, seams.right
    one, other = surface_of[left], surface_of[right]
    ends = look.mesh.vertices[look.edges.ends[seams.edge]]
    along = ends[:, 1] - ends[:, 0]
    middle = ends.mean(axis=1)
    a, out_a, foot_a = _seen(look, surfaces, one, left, middle)
    b, out_b, foot_b = _seen(look, surfaces, other, right, middle)
    cosine = np.einsum("ij,ij->i", out_a, out_b)
    square = np.maximum(1.0 - cosine**2, LEAST_SINE**2)[:, None]
    meeting = (a - cosine * b)[:, None] * out_a + (b - cosine * a)[:, None] * out_b
    crossed = np.cross(meeting / square, foot_b - foot_a)
    volume = 0.5 * np.abs(np.einsum("ij,ij->i", crossed, along))
    tangent = cosine > np.cos(NEARLY_TANGENT_RAD)
    highest = np.maximum(np.abs(a), np.abs(b))
    least = np.minimum(look.area_mm2[left], look.area_mm2[right])
    volume[tangent] = np.minimum(volume, highest * least)[tangent]
    return SEAM_SAFETY * volume, middle


def _seen(
    look: Look, surfaces: list[RevolvedSurface], number: Indices, face: Indices, place: Array
) -> tuple[Array, Array, Array]:
    """Return the height (n,) of surfaces over places (n, 3), their directions, and from there to the surface.

    Where a face has no surface it is its own.
    """
    normal = look.normal[face].copy()
    height, foot = np.zeros(len(face)), np.zeros((len(face), 3))
    order = np.argsort(number, kind="stable")
    order = order[np.searchsorted(number[order], 0) :]
    if len(order) == 0:
        return height, normal, foot
    sets = Sets.of(number[order])
    for start, size in zip(sets.starts.tolist(), sets.sizes.tolist(), strict=True):
        rows = order[start : start + size]
        surface = surfaces[int(number[rows[0]])]
        here = place[rows]
        out = surface.normal(here)
        sign = np.sign(np.einsum("ij,ij->i", out, normal[rows]))
        height[rows] = -sign * surface.off(here)
        normal[rows] = sign[:, None] * out
        radial = cylindrical(here, surface.point, surface.axis)[2]
        way = normal[rows] if surface.tube_mm else sign[:, None] * radial
        steep = np.maximum(np.einsum("ij,ij->i", way, normal[rows]), ON_SURFACE)
        foot[rows] = way * (height[rows] / steep)[:, None]
    return height, normal, foot
