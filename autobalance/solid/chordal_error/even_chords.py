"""Lenses over the facets of a large mesh, from the angles on both sides of each: nothing is fitted.

Between two chords a and b wide that turn by δ the curvature is 2 δ / (a + b), and over a facet of length L
it hides L w³ κ / 12, half by what is known on either side of it. The last chord of an arc has that of its one
side: drawn arcs are divided evenly. Where both sides agree nothing else is free, so that a facet is as sure
as they agree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.chordal_error.bars import COARSER
from autobalance.solid.chordal_error.fits import Sets
from autobalance.solid.chordal_error.look import Look
from autobalance.solid.chordal_error.turning import AS_WIDE, Turns, all_around, crossed, widths
from autobalance.types import Array, Flags, Indices

GENTLE_RAD = 0.35
"""Angle up to which facets that go on turning are chords: 18 in a circle."""
EVEN_SHARE = 0.2
"""Difference of two chords' widths at most, as a share of their mean, of chords of one curve."""
END_SHARE, END_LEAST = 0.1, 0.02
"""Share of what is known on one side of a facet below which it has nothing on the other, and of all that is
known of it from which on that counts: the sides of a trapezium lean to its wider end, none lies there."""
ALIKE, ALIKE_WIDE = 0.06, 0.04
"""Differences of curvature and of width to the next chord up to which a last one is of the same arc; its
error bar has them. Rows of a fillet differ by their circumference, 5 % with six of them."""
ALONG = 0.7
"""Cosine from which on a side lies in a direction."""
EXACT_SHARE = 2e-4
"""Error bar of a facet between even chords: 3e-5 is seen of cylinders."""
LAST_SHARE = 0.004
"""Error bar of the last chord of an arc: 4e-4 is seen of webs."""
UNLIKE_SHARE = 1.0
"""Error bar of a last chord that is none as wide as the next, or beside one that is unlike the others."""
LENS_DEPTH = 0.6
"""Depth of a lens's centroid under its corners, as a share of the sag."""
BY_ANGLE = 0.025
"""Error bar of a chord by the square of its angle, 4e-4 of fillets of 13 rows, where 2e-4 is seen."""
ROUNDED_STEPS = 2.0
"""Steps of single precision that the turn between two chords may be off by over one's width."""
ONE_WAY_SHARE = 0.05
"""Share of what a cut chord's sides tell that may lie along its rulings."""
SEVERAL, SEVERAL_SHARE = 1.5, 0.1
"""A facet that is so many times as wide as the widest of its triangles and no plane is several chords, which
turn by less than roundings may make of slender triangles; its error bar."""
CUT_CORNERS = 300
"""Corners of a facet at most that a hole may have cut; planes of the part, with more, are not looked at."""


@dataclass(frozen=True, eq=False)
class Lenses:
    """Volumes between facets and what they stand for, piece by piece.

    Attributes
    ----------
    volume : (n,) float
        Negative in a hollow [mm³].
    place : (n, 3) float
    share : (n,) float
        Error bars, as shares.
    along : (n, 3) float
        Radius of gyration about the place, along the piece [mm]: an oil hole's are as long as a web.
    """

    volume: Array
    place: Array
    share: Array
    along: Array

    def moments(self, density_g_mm3: float) -> Moments:
        """Return the moments of all pieces."""
        mass = density_g_mm3 * self.volume
        second = (self.place * mass[:, None]).T @ self.place + (self.along * mass[:, None]).T @ self.along
        return Moments(float(mass.sum()), mass @ self.place, second)


@dataclass(frozen=True, eq=False)
class EvenChords:
    """Facets that are chords between chords about as wide.

    Attributes
    ----------
    lenses : Lenses
    rows : (k,) int
        The meetings that tell of them.
    coarse : (n,) bool
        Marks the meetings that are coarser than the mesh's chords, by their angle and by their sag.
    known : (count,) bool
        Marks the faces.
    ends : (count,) bool
        Those with a chord on one side alone, ``towards`` (count, 3) that one.
    """

    lenses: Lenses
    rows: Indices
    coarse: Flags
    known: Flags
    ends: Flags
    towards: Array


@dataclass(frozen=True, eq=False)
class _Sides:
    """What is known of faces from some meetings: volumes (2, k), directions of the sides, and their sums.

    ``whole`` (count,) are the sums, ``towards`` (count, 3) the direction in which more is known, ``beside``
    (2, k) the cosine of each side to it, ``more`` (count,) the sums along it less those against it.
    """

    rows: Indices
    faces: Indices
    volume: Array
    whole: Array
    more: Array
    towards: Array
    beside: Array
    ends: Flags

    @classmethod
    def of(cls, look: Look, turns: Turns, rows: Indices, volume: Array) -> _Sides:
        """Add up what the meetings at some rows (k,) tell of their two faces."""
        faces, away, count = turns.faces[:, rows], turns.away[:, rows], look.count
        whole, first = np.zeros(count), np.zeros((count, 3))
        for face, side, held in zip(faces, away, volume, strict=True):
            whole += np.bincount(face, held, count)
            for column in range(3):
                first[:, column] += np.bincount(face, held * side[:, column], count)
        more = np.sqrt(np.einsum("ij,ij->i", first, first))
        towards = first / np.where(more > 0.0, more, 1.0)[:, None]
        beside = np.einsum("snk,snk->sn", away, towards.take(faces, axis=0))
        front, back = np.zeros(count), np.zeros(count)
        for face, cosine, held in zip(faces, beside, volume, strict=True):
            front += np.bincount(face, held * (cosine > ALONG), count)
            back += np.bincount(face, held * (cosine < -ALONG), count)
        ends = (front > END_LEAST * whole) & (back < END_SHARE * front)
        return cls(rows, faces, volume, whole, np.abs(front - back), towards, beside, ends)


def even_chords(look: Look, turns: Turns) -> EvenChords:
    """Return what facets of two triangles hide that are chords between chords about as wide."""
    length, size = look.meetings.length_mm, np.abs(turns.angle_rad)
    wide = look.broad_mm2.take(turns.faces) / np.where(length > 0.0, length, 1.0)
    apart, both = np.abs(wide[0] - wide[1]), wide.sum(axis=0)
    even = (look.sizes.take(turns.faces) == 2).all(axis=0) & (size <= GENTLE_RAD)
    rows = np.flatnonzero(even & (apart <= 0.5 * EVEN_SHARE * both))
    tapered = _tapers(look)
    curvature = 2.0 * size / np.where(both > 0.0, both, 1.0)
    volume = length * curvature * wide**3 / 24.0
    volume = volume[:, rows] * (1.0 + tapered.take(turns.faces[:, rows]) ** 2 / 3.0)
    volume *= 1.0 + size[rows] ** 2 / 30.0
    sides = _Sides.of(look, turns, rows, volume)
    alone = (sides.ends[sides.faces] & (sides.beside > ALONG)).all(axis=0)
    coarse = _coarse(look, turns, sides, wide)
    if alone.any() or coarse.any():
        kept = ~alone & ~coarse
        sides = _Sides.of(look, turns, rows[kept], volume[:, kept])
    marked = np.zeros(len(length), dtype=bool)
    marked[rows[coarse]] = True
    rows = sides.rows
    share = _shares(look, turns, sides, apart[rows] / both[rows]).take(sides.faces)
    share = share + BY_ANGLE * size[rows] ** 2
    middle = look.meetings.middle[rows]
    reach = np.maximum(np.hypot(middle[:, 0], middle[:, 1]), length[rows])
    share = share + tapered.take(sides.faces) * length[rows] / (3.0 * reach)
    more = sides.volume * sides.ends.take(sides.faces) * np.maximum(sides.beside, 0.0)
    whole = sides.volume + more
    last = np.flatnonzero(more.any(axis=0))
    beyond = (more * wide[:, rows])[:, last, None] * turns.away[
        :, rows[last]
    ]  # on the far side of a last chord
    middle[last] -= beyond.sum(axis=0) / np.maximum(whole.sum(axis=0), 1e-300)[last, None]
    normal = 0.5 * (look.normal.take(sides.faces[0], axis=0) + look.normal.take(sides.faces[1], axis=0))
    deep = LENS_DEPTH * wide[:, rows].mean(axis=0) * turns.angle_rad[rows] / 8.0
    lenses = Lenses(
        np.sign(turns.angle_rad[rows]) * whole.sum(axis=0),
        middle - deep[:, None] * normal,
        (whole * share).sum(axis=0) / np.maximum(whole.sum(axis=0), 1e-300),
        _along(look, turns, rows),
    )
    return EvenChords(lenses, rows, marked, sides.whole > 0.0, sides.ends, sides.towards)


def _along(look: Look, turns: Turns, rows: Indices) -> Array:
    """Return L / √12 along the edges (k, 3) of some meetings."""
    edge = crossed(turns.away[0, rows], look.normal.take(turns.faces[0, rows], axis=0))
    along: Array = edge * (look.meetings.length_mm[rows] / math.sqrt(12.0))[:, None]
    return along


def _tapers(look: Look) -> Array:
    """Return how much wider each facet (count,) of two triangles is at one end, over the sum of both widths.

    The areas of the two triangles of a trapezium are as its parallel sides.
    """
    squares = np.bincount(look.face, look.mesh.doubled_areas**2, look.count)
    whole = 4.0 * look.area_mm2**2
    unlike = 2.0 * squares / np.where(whole > 0.0, whole, 1.0) - 1.0
    return np.asarray(np.where(look.sizes == 2, np.sqrt(np.clip(unlike, 0.0, 1.0)), 0.0))


def _coarse(look: Look, turns: Turns, sides: _Sides, wide: Array) -> Flags:
    """Mark, of some meetings (k,), those that turn by more and are deeper than any between regular chords."""
    rows = sides.rows
    size = np.abs(turns.angle_rad[rows])
    sag = wide[:, rows].min(axis=0) * size / 8.0
    regular = (sides.whole > 0.0) & ~sides.ends & (sides.more < ALIKE * sides.whole)
    sure = regular[sides.faces].all(axis=0)
    if not sure.any():
        return np.zeros(len(rows), dtype=bool)
    return np.asarray((size > COARSER * size[sure].max()) & (sag > COARSER * sag[sure].max()))


def _shares(look: Look, turns: Turns, sides: _Sides, uneven: Array) -> Array:
    """Return the error bars of faces (count,) as shares; ``uneven`` (k,) are the differences of widths.

    What both sides know differently counts, but for what roundings make and what a trapezium's lengths do.
    """
    count, rows = look.count, sides.rows
    whole = np.where(sides.whole > 0.0, sides.whole, 1.0)
    unlike = sides.more / whole
    both = look.broad_mm2.take(sides.faces).sum(axis=0) / np.maximum(look.meetings.length_mm[rows], 1e-300)
    step = ROUNDED_STEPS * float(np.spacing(np.float32(np.abs(look.mesh.bounds).max())))
    rounded = step / np.maximum(0.5 * both * np.abs(turns.angle_rad[rows]), 1e-300)
    tapered = _tapers(look)
    left = np.maximum(unlike - tapered, 0.0)
    regular = (sides.whole > 0.0) & ~sides.ends & (unlike < ALIKE)
    rounding, alike, beside = np.zeros(count), np.zeros(count), np.zeros(count)
    for face, other, held in zip(sides.faces, sides.faces[::-1], sides.volume, strict=True):
        rounding += np.bincount(face, held * rounded, count)
        inner = held * ((uneven < ALIKE_WIDE) & regular[other])
        alike += np.bincount(face, inner, count)
        beside += np.bincount(face, inner * (left[other] + uneven), count)
    within = np.maximum(left - rounding / whole, 0.0) + unlike**2
    last = np.where(alike > 0.5 * whole, LAST_SHARE + beside / np.maximum(alike, 1e-300), UNLIKE_SHARE)
    return np.asarray(EXACT_SHARE + tapered**2 + np.where(sides.ends, last, within))


def uneven_chords(look: Look, turns: Turns, rows: Indices, even: EvenChords, share: Array) -> Lenses:
    """Return what is hidden beside the other meetings, at ``rows`` (k,), each with its ``share`` (k,).

    Facets that a hole cuts are integrated triangle by triangle; of others L w² δ / 24 counts on either side,
    w the lesser width, but not beyond the last chord of an arc, which is whole.
    """
    few = Turns(turns.faces[:, rows], turns.away[:, rows], turns.angle_rad[rows])
    wide = wide_of(look, few, look.meetings.length_mm[rows])
    least = wide.min(axis=0)
    alike = wide.max(axis=0) < AS_WIDE * least
    half = look.meetings.length_mm[rows] * least**2 * np.abs(few.angle_rad) / 24.0
    cut = _cut_facets(look, few, np.where(alike, half, 0.0)) & ~even.known
    lenses = _cut_lenses(look, few, wide, cut, share, look.meetings.length_mm[rows])
    beside = np.einsum("snk,snk->sn", few.away, even.towards.take(few.faces, axis=0))
    whole = even.ends.take(few.faces) & (beside < -ALONG)
    taken = np.where(alike, 1.0, 2.0 * (wide <= least))
    taken[whole | (cut | all_around(turns.faces, turns.away, look.count)).take(few.faces)] = 0.0
    volume = np.sign(few.angle_rad) * half * taken.sum(axis=0)
    return joined(lenses, Lenses(volume, look.meetings.middle[rows], share, _along(look, turns, rows)))


def joined(*lenses: Lenses) -> Lenses:
    """Return several lots of lenses as one."""
    parts = ([one.volume, one.place, one.share, one.along] for one in lenses)
    volume, place, share, along = (np.concatenate(each) for each in zip(*parts, strict=True))
    return Lenses(volume, place, share, along)


def wide_of(look: Look, turns: Turns, length: Array) -> Array:
    """Return how wide the faces (2, k) are across some edges.

    Of planes of the part it is area over length: their many corners would be looked at for each edge.
    """
    wide = look.broad_mm2.take(turns.faces) / np.where(length > 0.0, length, 1.0)
    few = look.corner_counts.take(turns.faces) <= CUT_CORNERS
    for side, some in enumerate(few):
        one = Turns(
            turns.faces[side : side + 1, some], turns.away[side : side + 1, some], turns.angle_rad[some]
        )
        wide[side, some] = widths(look, one)[0]
    return wide


def _cut_facets(look: Look, turns: Turns, held: Array) -> Flags:
    """Mark the faces (count,) that are chords cut by a hole or split into triangles.

    What is ``held`` (k,) at their sides lies in one direction: facets of a fillet bend in two.
    """
    marked = np.zeros(look.count, dtype=bool)
    for face in turns.faces:
        marked[face[held > 0.0]] = True
    marked &= (look.sizes >= 2) & (look.corner_counts <= CUT_CORNERS)
    faces = np.flatnonzero(marked)
    place = np.full(look.count, -1)
    place[faces] = np.arange(len(faces))
    second = np.zeros((len(faces), 3, 3))
    for face, away in zip(turns.faces, turns.away, strict=True):
        mine = np.flatnonzero(place[face] >= 0)
        for one in range(3):
            for other in range(3):
                products = held[mine] * away[mine, one] * away[mine, other]
                second[:, one, other] += np.bincount(place[face[mine]], products, len(faces))
    spread = np.linalg.eigvalsh(second)
    marked[faces] = spread[:, 1] <= ONE_WAY_SHARE * spread[:, 2]
    return marked


def _cut_lenses(look: Look, turns: Turns, wide: Array, cut: Flags, share: Array, length: Array) -> Lenses:
    """Return the lenses over cut facets: ∫ κ (w²/4 − x²) / 2 over each of their triangles."""
    count = look.count
    weight, bent, bar = np.zeros(count), np.zeros(count), np.zeros(count)
    across, longest = np.zeros((count, 3)), np.zeros(count)
    curvature = 2.0 * turns.angle_rad / np.where(wide.sum(axis=0) > 0.0, wide.sum(axis=0), 1.0)
    alike = wide.max(axis=0) < AS_WIDE * wide.min(axis=0)
    for face, away in zip(turns.faces, turns.away, strict=True):
        mine = np.flatnonzero(alike & cut[face])
        weight += np.bincount(face[mine], length[mine], count)
        bent += np.bincount(face[mine], length[mine] * curvature[mine], count)
        np.maximum.at(bar, face[mine], share[mine])
        order = mine[np.argsort(length[mine], kind="stable")]
        order = order[length[order] >= longest[face[order]]]
        across[face[order]], longest[face[order]] = away[order], length[order]
    faces = np.flatnonzero(cut)
    if len(faces) == 0:
        return Lenses(np.zeros(0), np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3)))
    sizes = look.sizes[faces]
    sets = Sets(np.cumsum(sizes) - sizes, int(sizes.sum()))
    triangles = look.order[look.starts[faces][sets.number] + np.arange(sets.count) - sets.starts[sets.number]]
    corners = look.mesh.vertices[look.mesh.triangles[triangles]]
    face = faces[sets.number]
    x = np.einsum("nkd,nd->nk", corners, across[face])
    low, high = sets.least(x.min(axis=1)), sets.most(x.max(axis=1))
    x = x - 0.5 * (low + high)[sets.number][:, None]
    mean = ((x**2).sum(axis=1) + x.sum(axis=1) ** 2) / 12.0
    height = 0.5 * (0.25 * (high - low)[sets.number] ** 2 - mean)
    chord = sets.most(np.ptp(x, axis=1))
    up = np.einsum("nkd,nd->nk", corners, look.normal[face])
    deep = sets.most(up.max(axis=1)) - sets.least(up.min(axis=1))
    turned = np.abs(bent / np.where(weight > 0.0, weight, 1.0))[faces]
    uneven = deep > 0.5 * turned * (high - low) ** 2 / 8.0
    several = (uneven & ((high - low) > SEVERAL * chord))[sets.number]
    height[several] = chord[sets.number[several]] ** 2 / 12.0
    bar[face[several]] = np.maximum(bar[face[several]], SEVERAL_SHARE)
    area = 0.5 * look.mesh.doubled_areas[triangles]
    return Lenses(
        bent[face] / np.where(weight[face] > 0.0, weight[face], 1.0) * height * area,
        corners.mean(axis=1),
        bar[face],
        _longest_sides(corners) / math.sqrt(18.0),
    )


def _longest_sides(corners: Array) -> Array:
    """Return the longest side (n, 3) of triangles (n, 3, 3); their mass has L / √18 along it."""
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.einsum("nkd,nkd->nk", sides, sides).argmax(axis=1)
    return np.asarray(sides[np.arange(len(sides)), longest])
