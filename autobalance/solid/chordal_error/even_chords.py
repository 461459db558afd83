"""Lenses over the facets of a large mesh, from the angles on both sides of each: nothing is fitted.

Between two chords a and b wide that turn by δ the curvature is 2 δ / (a + b). Over a facet of length L it
hides L w³ κ / 12, half from each side. The last chord of an arc takes the value of its one side: drawn arcs
are divided evenly. If both sides agree, nothing else is free, so a facet is as sure as they agree.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property

import numpy as np

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.chordal_error.bars import COARSER
from autobalance.solid.chordal_error.look import Look, Turns, dotted, summed
from autobalance.solid.mesh.mesh import CHUNK
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

GENTLE_RAD = 0.35
"""Angle up to which facets that keep turning are chords: 18 in a circle."""
EVEN_SHARE = 0.2
"""Difference of two chords' widths at most, as a share of their mean, of chords of one curve."""
END_SHARE, END_LEAST = 0.1, 0.02
"""Share of the value on one side of a facet below which the other side has nothing, and share of the whole
value above which that counts. The sides of a trapezium lean to its wider end without an arc there."""
ALIKE, ALIKE_WIDE = 0.06, 0.04
"""Differences of curvature and of width to the next chord up to which a last one is of the same arc; its
error bar has them. Rows of a fillet differ by their circumference, 5 % with six of them."""
ALONG = 0.7
"""Cosine from which on a side lies in a direction."""
EXACT_SHARE = 1e-4
"""Error bar of a facet between even chords: 3e-5 is seen of cylinders."""
LAST_SHARE = 0.004
"""Error bar of the last chord of an arc: 4e-4 is seen of webs."""
UNLIKE_SHARE = 1.0
"""Error bar of a last chord that is not as wide as the next, or next to one that differs from the others."""
LENS_HEIGHT = 0.4
"""Height of a lens's centroid over its chord, as a share of the sag. Between both edges, half at each, a lens
lies on the chord."""
BY_ANGLE = 0.025
"""Error bar of a chord by the square of its angle, 4e-4 of fillets of 13 rows, where 2e-4 is seen."""
CUT_CHANGE = 0.15
"""Error bar of a chord cut lengthwise, as a share of what the cut changes: it covers 168 of 168 flats."""
MOVED_LEAST = 1e-3
"""Distance of a lens from the middle of its facet, as a share of the facet's length or of the distance from
the axis, from which on the facet's wider end is looked for."""
BY_TAPER = 1.0
"""Error bar of a chord by its largest angle times its taper; 0.4 is seen of fillets of 5 to 13 rows."""
ROUNDED_STEPS = 2.0
"""Steps of single precision that the turn between two chords may be off by over one's width."""


@dataclass(frozen=True, eq=False)
class Lenses:
    """Volumes between facets and what they stand for, piece by piece.

    Attributes
    ----------
    volume : (n,) float
        Negative in a hollow [mm³].
    place : (3, n) float
    share : (n,) float
        Error bars, as shares.
    along : (3, n) float
        Radius of gyration about the place, along the piece [mm]: an oil hole's are as long as a web.
    """

    volume: Array
    place: Array
    share: Array
    along: Array

    def at_slice(self, part: slice) -> Lenses:
        """Return views of some of them."""
        return Lenses(self.volume[part], self.place[:, part], self.share[part], self.along[:, part])

    def moments(self, density_g_mm3: float) -> Moments:
        """Return the moments of all pieces."""
        mass = density_g_mm3 * self.volume
        second = (self.place * mass) @ self.place.T + (self.along * mass) @ self.along.T
        return Moments(float(mass.sum()), self.place @ mass, second)


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
        Those with a chord on one side alone, ``towards`` (3, count) that one.
    """

    lenses: Lenses
    rows: Indices
    coarse: Flags
    known: Flags
    ends: Flags
    towards: Array


@dataclass(frozen=True, eq=False)
class _Chords:
    """Meetings of chords: their turns, lengths (k,) [mm], and how wide (2, k) both are [mm]."""

    turns: Turns
    length: Array
    wide: Array

    @cached_property
    def both(self) -> Array:
        """Widths (k,) of both together."""
        return np.asarray(self.wide[0] + self.wide[1])

    def at(self, rows: Indices) -> _Chords:
        """Return some of them by their rows (m,)."""
        return _Chords(self.turns.at(rows), self.length.take(rows), self.wide.take(rows, axis=1))

    def at_slice(self, part: slice) -> _Chords:
        """Return views of some of them."""
        return _Chords(self.turns.at_slice(part), self.length[part], self.wide[:, part])


@dataclass(frozen=True, eq=False)
class _Sides:
    """Values of faces from some meetings: volumes (2, k), directions of the sides, and their sums.

    ``whole`` (count,) are the sums; ``towards`` (3, count) is the direction of the larger part. ``beside``
    (2, k) is the cosine of each side to it, ``front`` (count,) the sums along it, ``more`` these less those
    against it.
    """

    rows: Indices
    chords: _Chords
    volume: Array
    whole: Array
    front: Array
    more: Array
    towards: Array
    beside: Array
    ends: Flags

    @property
    def faces(self) -> Indices:
        """The faces (2, k) at each meeting."""
        return self.chords.turns.faces

    def at_slice(self, part: slice) -> _Sides:
        """Return some meetings, as views, with what is known of all faces."""
        return replace(
            self,
            rows=self.rows[part],
            chords=self.chords.at_slice(part),
            volume=self.volume[:, part],
            beside=self.beside[:, part],
        )

    @classmethod
    def of(cls, count: int, rows: Indices, chords: _Chords, volume: Array) -> _Sides:
        """Add up what the meetings at some rows (k,) tell of their two faces, ``count`` in all."""
        faces, away = chords.turns.faces, chords.turns.away
        whole, first = np.zeros(count), np.zeros((3, count))
        for face, side, held in zip(faces, away, volume, strict=True):
            whole += np.bincount(face, held, count)
            first += summed(face, held * side, count)
        more = np.sqrt(dotted(first, first))
        towards = first / np.where(more > 0.0, more, 1.0)
        beside = np.stack(
            [dotted(side, towards.take(face, axis=1)) for face, side in zip(faces, away, strict=True)]
        )
        front, back = np.zeros(count), np.zeros(count)
        for face, cosine, held in zip(faces, beside, volume, strict=True):
            front += np.bincount(face, held * (cosine > ALONG), count)
            back += np.bincount(face, held * (cosine < -ALONG), count)
        ends = (front > END_LEAST * whole) & (back < END_SHARE * front)
        return cls(rows, chords, volume, whole, front, np.abs(front - back), towards, beside, ends)


def even_chords(look: Look, turns: Turns) -> EvenChords:
    """Return the volume hidden by facets of two triangles that are chords between chords about as wide."""
    tapered = _tapers(look)
    sides = _known_from_sides(look, turns, tapered)
    coarse = _coarse(sides, tapered)
    alone = (sides.ends.take(sides.faces) & (sides.beside > ALONG)).all(axis=0)
    marked = np.zeros(len(turns.angle_rad), dtype=bool)
    marked[sides.rows[coarse]] = True
    if alone.any() or coarse.any():
        kept = np.flatnonzero(~alone & ~coarse)
        chords = sides.chords.at(kept)
        sides = _Sides.of(look.count, sides.rows[kept], chords, sides.volume.take(kept, axis=1))
    return EvenChords(
        _even_lenses(look, sides, tapered), sides.rows, marked, sides.whole > 0.0, sides.ends, sides.towards
    )


def _known_from_sides(look: Look, turns: Turns, tapered: Array) -> _Sides:
    """Return the volume that meetings of facets about as wide give for these: L κ w³ / 24 on either side."""
    found = [
        _even_rows(look, turns, tapered, slice(begin, begin + CHUNK))
        for begin in range(0, max(len(turns.angle_rad), 1), CHUNK)
    ]
    rows, wide, volume = (np.concatenate(each, axis=-1) for each in zip(*found, strict=True))
    chords = _Chords(turns.at(rows), look.meetings.length_mm.take(rows), wide)
    return _Sides.of(look.count, rows, chords, volume)


def _even_rows(look: Look, turns: Turns, tapered: Array, part: slice) -> tuple[Indices, Array, Array]:
    """Return the meetings of facets about as wide in a part of all: rows (k,), widths and volumes (2, k)."""
    some, length = turns.at_slice(part), look.meetings.length_mm[part]
    size = np.abs(some.angle_rad)
    broad = look.broad_mm2.take(some.faces)
    even = (look.sizes.take(some.faces) == 2).all(axis=0) & (size <= GENTLE_RAD)
    even &= np.abs(broad[0] - broad[1]) <= 0.5 * EVEN_SHARE * (broad[0] + broad[1])
    rows = np.flatnonzero(even)
    length, size = length.take(rows), size.take(rows)
    wide = broad.take(rows, axis=1) / np.where(length > 0.0, length, 1.0)
    both = wide[0] + wide[1]
    volume = length * size * wide**3 / (12.0 * np.where(both > 0.0, both, 1.0))
    volume *= 1.0 + tapered.take(some.faces.take(rows, axis=1)) ** 2 / 3.0
    volume *= 1.0 + size**2 / 30.0
    return part.start + rows, wide, volume


def _even_lenses(look: Look, sides: _Sides, tapered: Array) -> Lenses:
    """Return the lenses beside the meetings that tell of even chords; beyond a last chord they are whole.

    They are computed so many at a time that what lies between stays in the processor's cache.
    """
    count = len(sides.rows)
    lenses = Lenses(np.zeros(count), np.zeros((3, count)), np.zeros(count), np.zeros((3, count)))
    shares, steepest = _shares(look, sides, tapered), _steepest(look.count, sides)
    normals = np.ascontiguousarray(look.normal.T)
    for begin in range(0, count, CHUNK):
        part = slice(begin, begin + CHUNK)
        some = sides.at_slice(part)
        taper = tapered.take(some.faces)
        size = np.abs(some.chords.turns.angle_rad)
        share = shares.take(some.faces) + BY_ANGLE * size**2
        share += BY_TAPER * taper * steepest.take(some.faces)
        _fill(lenses.at_slice(part), look, some, taper, share, normals)
    return lenses


def _fill(lenses: Lenses, look: Look, sides: _Sides, taper: Array, share: Array, normals: Array) -> None:
    """Write the lenses beside some meetings (k,); ``taper`` and ``share`` (2, k), ``normals`` (3, count)."""
    turns, length, wide = sides.chords.turns, sides.chords.length, sides.chords.wide
    place = lenses.place
    place[:] = look.meetings.middle.T.take(sides.rows, axis=1)
    shift, moved = _towards_wider_end(look, sides, taper)
    reach = np.maximum(np.hypot(place[0], place[1]), length)
    share += np.where(moved, 0.25 * taper, 1.0) * taper * length / (3.0 * reach)
    more = sides.volume * sides.ends.take(sides.faces) * np.maximum(sides.beside, 0.0)
    more += 4.0 * more * _shorter(look, sides, more)
    factor = _of_cut_ends(look, sides, taper)
    change = CUT_CHANGE * np.abs(factor - 1.0) * (sides.volume + more)
    more = more * factor
    whole = sides.volume * factor + more
    volume = whole[0] + whole[1]
    apart = np.maximum(volume, 1e-300)
    high = 0.25 * LENS_HEIGHT * sides.chords.both * turns.angle_rad / 8.0
    for face, beyond, away in zip(sides.faces, more * wide / apart, turns.away, strict=True):
        last = np.flatnonzero(beyond)
        place[:, last] -= beyond.take(last) * away.take(last, axis=1)  # on the far side of a last chord
        place += high * normals.take(face, axis=1)
    place += 0.5 * shift * turns.along
    lenses.volume[:] = np.copysign(volume, turns.angle_rad)
    lenses.share[:] = (whole[0] * share[0] + whole[1] * share[1] + change[0] + change[1]) / apart
    lenses.along[:] = turns.along * (length / math.sqrt(12.0))


def _of_cut_ends(look: Look, sides: _Sides, taper: Array) -> Array:
    """Return the factors (2, k) on the lenses next to last chords that are cut lengthwise.

    A flat or a keyway leaves a piece of a chord, r times as wide as the next. It lies in the plane of the
    whole chord, so that the curvature is that of two whole ones, and its lens does not end at the cut.
    """
    narrower = np.clip(sides.chords.wide / np.maximum(sides.chords.wide[::-1], 1e-300), 0.0, 1.0)
    narrower = np.minimum(narrower + 2.0 * taper.sum(axis=0), 1.0)
    ratio = np.where(sides.ends.take(sides.faces) & (sides.beside > ALONG), narrower, 1.0)
    piece = (1.5 - ratio) * (1.0 + ratio) / np.maximum(ratio, EVEN_SHARE)
    return np.asarray(np.where(ratio < 1.0, piece, 0.5 * (1.0 + ratio[::-1])))


def _towards_wider_end(look: Look, sides: _Sides, taper: Array) -> tuple[Array, Flags]:
    """Return the sum (k,) of both lenses' distances [mm] from the middle of their edge, along it.

    The lens on a trapezium lies L t / (3 + t²) from the middle, twice as far as the area's centroid, which
    also gives the wider end. Second: marks (2, k) of the facets whose distance was computed.
    """
    turns, length = sides.chords.turns, sides.chords.length
    middle = look.meetings.middle.T.take(sides.rows, axis=1)
    moved = taper * length > 3.0 * MOVED_LEAST * np.maximum(np.hypot(*middle[:2]), length)
    shift = np.zeros(len(length))
    for face, own, mark in zip(sides.faces, taper, moved, strict=True):
        rows = np.flatnonzero(mark)
        start = look.starts.take(face.take(rows))
        first, second = look.order.take(start), look.order.take(start + 1)
        area = look.mesh.doubled_areas
        weight = area.take(first) / np.maximum(area.take(first) + area.take(second), 1e-300)
        a, b = (
            look.mesh.vertices[look.mesh.triangles.take(each, axis=0)].mean(axis=1).T
            for each in (first, second)
        )
        off = weight * a + (1.0 - weight) * b - middle.take(rows, axis=1)
        beside = dotted(off, turns.along.take(rows, axis=1))
        wider = own.take(rows)
        most = wider * length.take(rows) / 6.0
        shift[rows] += (beside + np.clip(beside, -most, most)) / (1.0 + wider**2 / 3.0)
    return shift, moved


def _steepest(count: int, sides: _Sides) -> Array:
    """Return the largest angle (count,) at each face."""
    steepest = np.zeros(count)
    for face in sides.faces:
        np.maximum.at(steepest, face, np.abs(sides.chords.turns.angle_rad))
    return steepest


def _shorter(look: Look, sides: _Sides, more: Array) -> Array:
    """Return the shortening of last chords (2, k) on their far sides, as a share of the sum of both.

    L w³ κ / 24 from area over its near side is as the mean length cubed over the square of the near one.
    """
    found = np.zeros(more.shape)
    edge = look.smooth.take(look.distinct_pairs[1].take(sides.rows))
    beside = (look.edges.left, look.edges.right)
    for held, face, triangles, out in zip(more, sides.faces, beside, found, strict=True):
        rows = np.flatnonzero(held)
        first, (p, q) = triangles.take(edge.take(rows)), look.edges.ends.take(edge.take(rows), axis=0).T
        start = look.starts.take(face.take(rows))
        second = look.order.take(start) + look.order.take(start + 1) - first
        a, b = (look.mesh.triangles.take(each, axis=0) for each in (first, second))
        r = a.sum(axis=1) - p - q
        s = b.sum(axis=1) - r - np.where((b == p[:, None]).any(axis=1), p, q)
        near, far = (_apart_mm(look, *ends) for ends in ((p, q), (r, s)))
        out[rows] = (near - far) / np.maximum(near + far, 1e-300)
    return found


def _apart_mm(look: Look, one: Indices, other: Indices) -> Array:
    """Return the distances (n,) of vertices by their numbers (n,) [mm]."""
    between = look.mesh.vertices.take(one, axis=0) - look.mesh.vertices.take(other, axis=0)
    return np.asarray(np.sqrt(np.einsum("nk,nk->n", between, between)))


def _tapers(look: Look) -> Array:
    """Return the excess width of each facet (count,) of two triangles at one end, over the sum of both.

    The areas of the two triangles of a trapezium are as its parallel sides.
    """
    squares = np.bincount(look.face, look.mesh.doubled_areas**2, look.count)
    whole = 4.0 * look.area_mm2**2
    unlike = 2.0 * squares / np.where(whole > 0.0, whole, 1.0) - 1.0
    return np.asarray(np.where(look.sizes == 2, np.sqrt(np.clip(unlike, 0.0, 1.0)), 0.0))


def _regular(sides: _Sides, tapered: Array) -> Flags:
    """Mark the faces (count,) whose two sides agree, except for the squares of a trapezium's lengths.

    Five rows of a fillet of 4 mm on a journal of 12 mm, a tenth longer each, were taken for chamfers.
    """
    told = (sides.whole > 0.0) & ~sides.ends
    return np.asarray(told & (sides.more < (ALIKE + 2.0 * tapered) * sides.whole))


def _coarse(sides: _Sides, tapered: Array) -> Flags:
    """Mark, of some meetings (k,), those that turn by more and are deeper than any between regular chords."""
    size = np.abs(sides.chords.turns.angle_rad)
    sag = np.minimum(*sides.chords.wide) * size / 8.0
    sure = _regular(sides, tapered).take(sides.faces).all(axis=0)
    if not sure.any():
        return np.zeros(len(size), dtype=bool)
    return np.asarray((size > COARSER * size[sure].max()) & (sag > COARSER * sag[sure].max()))


def _shares(look: Look, sides: _Sides, tapered: Array) -> Array:
    """Return the error bars of faces (count,) as shares.

    What both sides know differently counts, except for what roundings make and what a trapezium's lengths do.
    """
    count, chords = look.count, sides.chords
    whole = np.where(sides.whole > 0.0, sides.whole, 1.0)
    unlike = sides.more / whole
    uneven = np.abs(chords.wide[0] - chords.wide[1]) / chords.both
    step = ROUNDED_STEPS * float(np.spacing(np.float32(np.abs(look.mesh.bounds).max())))
    rounded = step / np.maximum(0.5 * chords.both * np.abs(chords.turns.angle_rad), 1e-300)
    left = np.maximum(unlike - 2.0 * tapered, 0.0)
    regular = _regular(sides, tapered)
    rounding, alike, beside = np.zeros(count), np.zeros(count), np.zeros(count)
    narrow = uneven < ALIKE_WIDE
    towards = sides.beside > ALONG
    for face, other, held, near in zip(sides.faces, sides.faces[::-1], sides.volume, towards, strict=True):
        rounding += np.bincount(face, held * rounded, count)
        inner = held * (narrow & near & regular.take(other))
        alike += np.bincount(face, inner, count)
        apart = left.take(other) + np.maximum(uneven - tapered.take(face), 0.0)
        beside += np.bincount(face, inner * apart, count)
    within = np.maximum(left - rounding / whole, 0.0) + unlike**2
    last = np.where(alike > 0.5 * sides.front, LAST_SHARE + beside / np.maximum(alike, 1e-300), UNLIKE_SHARE)
    return np.asarray(EXACT_SHARE + tapered**2 + np.where(sides.ends, last, within))


def joined(*lenses: Lenses) -> Lenses:
    """Return several lots of lenses as one."""
    parts = ([one.volume, one.place, one.share, one.along] for one in lenses)
    volume, place, share, along = (np.concatenate(each, axis=-1) for each in zip(*parts, strict=True))
    return Lenses(volume, place, share, along)
