"""Surfaces of a large mesh: fitted to a sample of its facets, and carried from there to all that lie on them.

The sample is a few rings of facets around seeds spread over all that may be chords. A short piece of a
cylinder does not show its radius to rounding: pieces of one cylinder are found and fitted together. Where
much of a mesh is left without a surface, seeds are put there again.
"""

from __future__ import annotations

import numpy as np

from autobalance.solid.chordal_error.look import Look, faces_along, tight_mm
from autobalance.solid.chordal_error.revolved import Cylinders, RevolvedSurface, Sets, cylinders
from autobalance.solid.chordal_error.seeds import (
    PARTED_SAGS,
    Points,
    adopt_cut_facets,
    find_joined,
    find_leftover_cylinders,
)
from autobalance.solid.chordal_error.strips import (
    OUTER_SPREAD,
    axes_of,
    find_cylinders,
    find_revolved,
)
from autobalance.solid.mesh.adjacency import rounding_mm
from autobalance.solid.mesh.mesh import numbered_components, ranked
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

FACETS_OF_SEED, SEEDS_MOST, SEEDED_LEAST = 800, 4, 16
"""Facets of a connected piece for each of its seeds, seeds at most, and facets of a piece with any."""
RINGS = 9
"""Rings of facets around each seed: of a strip 19 chords, which are sure."""
CHORD_TRIANGLES = 64
"""Triangles of a face at most that may be a chord: planes of the part would join the surfaces around them."""
ROUNDS = 4
"""Samples at most: the first holds the large surfaces, later ones what is left."""
WHOLE_FACETS = 4000
"""Facets left up to which all are looked at, and no sample of them."""
WORTH_SHARE = 0.01
"""Share of the facets left below which no other sample is taken."""
GAIN_SHARE = 0.1
"""Share of the facets left that a sample must find surfaces for: a free form has no surface of revolution."""
OWN_MOST = 500
"""Faces of a surface that are looked at for their depth and for how far off their corners are."""
LARGE_LEAST = 64
"""Faces of a surface from which on it takes faces of smaller ones."""
OF_SAMPLE = 1.5
"""Corners may be off a surface by so many times the median of its facets in the sample."""
FACETS_FITTED = 600
"""Facets of a cylinder that it is fitted to again, spread over all. By 60 a crankpin of a V12 with 384
segments was 1e-4 mm off in radius, and the bar 40 times as wide."""
FINE_SHARE = 0.125
"""Share of the rounding of corners beyond which they may lie on a chord that a hole or a keyway cuts."""
TRIMS, OUTER_LEAST = 6, 0.5
"""Times that inner corners are left out, and share of the corners that stay at least."""
REGROUPED = 3
"""Times that pieces are put together: those of a cylinder beside a larger one come after it."""
SAME_SHARE, SAME_COSINE = 0.02, 1.0 - 1e-4
"""Differences of radius and place, as shares of the radius, and cosine between the axes, of pieces that may
be of one cylinder: an arc of 8° shows its radius to 1e-3."""


def find_in_samples(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> None:
    """Find the surfaces of a large mesh and assign the faces (count,) to them."""
    pieces = _Pieces.of(look)
    for _ in range(ROUNDS):
        left = np.flatnonzero(pieces.chord & (surface_of < 0))
        if len(left) <= max(WORTH_SHARE * len(pieces.faces), WHOLE_FACETS):
            break
        first = len(surfaces)
        carried = _find(look, pieces.around(pieces.seeds(left), surface_of < 0), surfaces, surface_of)
        pieces.carry_all(carried, surface_of)
        _fit_again(look, surfaces, surface_of, first)
        _unite(look, surfaces, surface_of)
        if len(left) - np.count_nonzero(pieces.chord & (surface_of < 0)) < GAIN_SHARE * len(left):
            break
    adopt_cut_facets(look, surfaces, surface_of)
    left = np.flatnonzero(pieces.chord & (surface_of < 0))
    if 0 < len(left) <= WHOLE_FACETS:
        first = len(surfaces)
        _find(look, left, surfaces, surface_of)
        _fit_again(look, surfaces, surface_of, first)
        _unite(look, surfaces, surface_of)
        _take_over(look, surfaces, surface_of)
        adopt_cut_facets(look, surfaces, surface_of)
    mine = surface_of >= 0
    used, number = np.unique(surface_of[mine], return_inverse=True)
    surfaces[:] = [surfaces[one] for one in used.tolist()]
    surface_of[mine] = number


def _find(
    look: Look, sample: Indices, surfaces: list[RevolvedSurface], surface_of: Indices
) -> list[_Carried]:
    """Find the surfaces of a sample (k,) of faces; return them, those of most faces first."""
    part = look.part(sample)
    found: list[RevolvedSurface] = []
    found_of = np.full(part.count, -1)
    axes = axes_of(look, surfaces, surface_of)
    find_cylinders(part, found, found_of)
    _fit_together(part, found, found_of)
    find_revolved(part, found, found_of, axes_of(part, found, found_of) + axes)
    find_leftover_cylinders(part, found, found_of)
    find_joined(part, found, found_of, axes_of(part, found, found_of) + axes)
    count = np.bincount(found_of[found_of >= 0], minlength=len(found))
    mine = found_of >= 0
    first = len(surfaces)
    surface_of[sample[mine]] = first + found_of[mine]
    surfaces += found
    order = first + np.argsort(-count, kind="stable")[: np.count_nonzero(count)]
    return [
        _Carried.of(look, surfaces[number], number, np.flatnonzero(surface_of == number))
        for number in order.tolist()
    ]


@dataclass(frozen=True, eq=False)
class _Carried:
    """A surface with its number, its faces (k,) of a sample, their depth and how far off corners may be."""

    surface: RevolvedSurface
    number: int
    own: Indices
    deepest_mm: float
    tight_mm: float

    @classmethod
    def of(cls, look: Look, surface: RevolvedSurface, number: int, own: Indices) -> _Carried:
        """Look at the faces ``own`` (k,) of a surface."""
        some = own[:: 1 + len(own) // OWN_MOST]
        row, corner = look.corners(some)
        off = np.zeros(len(some))
        np.maximum.at(off, row, np.abs(surface.off(corner)))
        tight = max(tight_mm(look), OF_SAMPLE * float(np.median(off)))
        deepest = PARTED_SAGS * min(float(surface.off(look.first_middles(some)).min()), 0.0) - tight
        return cls(surface, number, own, deepest, tight)

    def holds(self, look: Look, faces: Indices, *, cut: bool) -> Indices:
        """Return those of some faces (k,) that lie on the surface; of one that is ``cut`` two corners do."""
        off = self.surface.off(look.first_middles(faces))
        faces = faces[(off >= self.deepest_mm) & (off <= self.tight_mm)]
        if len(faces) == 0:
            return faces
        row, corner = look.corners(faces)
        off = self.surface.off(corner)
        on = np.bincount(row, np.abs(off) <= self.tight_mm, len(faces)) >= 2
        on[row[(off > self.tight_mm) | (off < (self.deepest_mm if cut else -self.tight_mm))]] = False
        faces = faces[on]
        return faces[faces_along(look, self.surface, faces)]


@dataclass(eq=False)
class _Pieces:
    """Connected pieces of faces that may be chords.

    Attributes
    ----------
    look : Look
    chord : (count,) bool
        Marks the faces that may be chords: small, and smooth neighbours of no more than a chord has.
    pairs : (2, n) int
        Pairs of these faces that meet smoothly.
    faces : (k,) int
        The faces, piece by piece; ``piece`` (count,) is the piece of each, ``starts`` where each begins.
    """

    look: Look
    chord: Flags
    pairs: Indices
    faces: Indices
    piece: Indices
    starts: Indices

    @classmethod
    def of(cls, look: Look) -> _Pieces:
        i, j = look.pairs
        smooth = np.zeros(look.count, dtype=bool)
        smooth[i] = smooth[j] = True
        chord = look.small & smooth & (look.sizes <= CHORD_TRIANGLES)
        rows = np.flatnonzero(chord.take(i) & chord.take(j))
        pairs = np.stack([i.take(rows), j.take(rows)])
        label, count = numbered_components(pairs.T, look.count)
        faces = np.flatnonzero(chord)
        own, order = ranked(label.take(faces))
        sizes = np.bincount(own, minlength=count)
        return cls(look, chord, pairs, faces.take(order), label, np.concatenate([[0], np.cumsum(sizes)]))

    def seeds(self, left: Indices) -> Indices:
        """Return faces of those left, spread over each piece."""
        piece, order = ranked(self.piece[left])
        left, sets = left[order], Sets.of(piece)
        count = np.minimum(-(-sets.sizes // FACETS_OF_SEED), SEEDS_MOST) * (sets.sizes >= SEEDED_LEAST)
        many = np.repeat(count, count)
        within = np.arange(len(many)) - np.repeat(np.cumsum(count) - count, count)
        place = np.repeat(sets.starts, count) + (2 * within + 1) * np.repeat(sets.sizes, count) // (2 * many)
        return np.asarray(left[place], dtype=np.int64)

    def around(self, seeds: Indices, free: Flags) -> Indices:
        """Return the free faces within some rings around seeds."""
        near = np.zeros(self.look.count, dtype=bool)
        near[seeds] = True
        one, other = self.pairs
        rows = np.flatnonzero(free.take(one) & free.take(other))
        one, other = one.take(rows), other.take(rows)
        for _ in range(RINGS):
            reached = np.flatnonzero(near.take(one) != near.take(other))
            near[one[reached]] = near[other[reached]] = True
        return np.flatnonzero(near & free)

    def carry_all(self, carried: list[_Carried], surface_of: Indices) -> None:
        """Assign to surfaces the faces of their pieces that lie on them; then those that are cut."""
        count = np.append(np.bincount(surface_of[surface_of >= 0]), 0)
        for cut in (False, True):
            for one in carried:
                self.carry(one, surface_of, count, cut=cut)

    def carry(self, one: _Carried, surface_of: Indices, count: Indices, *, cut: bool = False) -> None:
        """Assign to a surface the faces of its pieces that lie on it, also those of surfaces with fewer.

        ``count`` (k + 1,) are the faces of each surface, and of none. Of free faces that are ``cut``, two
        corners do and the others lie on a chord.
        """
        own = one.own[surface_of[one.own] == one.number]
        if len(own) == 0:
            return
        free = count < (0 if cut else len(own))
        free[-1], free[one.number] = True, False
        for piece in np.unique(self.piece[own]).tolist():
            faces = self.faces[self.starts[piece] : self.starts[piece + 1]]
            some = one.holds(self.look, faces[free[surface_of.take(faces)]], cut=cut)
            np.subtract.at(count, surface_of[some], 1)
            count[one.number] += len(some)
            surface_of[some] = one.number


def _fit_together(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> None:
    """Fit the pieces of one cylinder together, in place."""
    tight, open_ = tight_mm(look), np.ones(len(surfaces), dtype=bool)
    for _ in range(REGROUPED):
        group, leaders = _groups(surfaces, surface_of, open_)
        faces = np.flatnonzero(np.append(group, -1)[surface_of] >= 0)
        if len(faces) == 0:
            return
        number, order = ranked(group[surface_of[faces]])
        faces = faces[order]
        corner, which = Points(look).distinct(faces, Sets.of(number))
        fits = _outer_cylinders(look, corner, which, np.array([surfaces[one].axis for one in leaders]))
        open_[leaders] = False
        for one in np.flatnonzero(fits.worst_mm <= tight).tolist():
            whole = RevolvedSurface(fits.point[one], fits.axis[one], float(fits.radius[one]))
            mine = faces[number == one]
            on = _lie_beside(look, whole, mine, tight)
            if on[surface_of[mine] == leaders[one]].mean() > OUTER_LEAST:
                surfaces[leaders[one]] = whole
                surface_of[mine[on]] = leaders[one]


def _lie_beside(look: Look, surface: RevolvedSurface, faces: Indices, tight: float) -> Flags:
    """Mark the faces (k,) with two corners on a surface at least, and none outside."""
    row, corner = look.corners(faces)
    off = surface.off(corner)
    on: Flags = np.bincount(row, np.abs(off) <= tight, len(faces)) >= 2
    on[row[off > tight]] = False
    return on


def _groups(
    surfaces: list[RevolvedSurface], surface_of: Indices, asked: Flags | None = None
) -> tuple[Indices, list[int]]:
    """Return the group (k,) of each cylinder of faces, −1 for others, and the largest of each group."""
    count = np.bincount(surface_of[surface_of >= 0], minlength=len(surfaces))
    count *= np.array([not one.tube_mm and not one.slope for one in surfaces], dtype=bool)
    count *= True if asked is None else asked
    point, axis = (
        np.array([getattr(one, name) for one in surfaces]).reshape(-1, 3) for name in ("point", "axis")
    )
    radius = np.array([one.r0 for one in surfaces])
    group = np.full(len(surfaces), -1)
    leaders: list[int] = []
    for number in np.argsort(-count, kind="stable").tolist():
        if group[number] >= 0 or not count[number]:
            continue
        apart = point - point[number]
        apart -= (apart @ axis[number])[:, None] * axis[number]
        near = SAME_SHARE * radius[number]
        same = (group < 0) & (count > 0) & (np.abs(radius - radius[number]) < near)
        same &= (np.linalg.norm(apart, axis=1) < near) & (np.abs(axis @ axis[number]) > SAME_COSINE)
        group[same] = len(leaders)
        leaders.append(number)
    return group, leaders


def _unite(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> None:
    """Assign the faces of pieces of a cylinder to the largest of them, where they lie on it as well.

    A few facets that holes cut off lie on a separate cylinder, with their corners on its chords.
    """
    group, leaders = _groups(surfaces, surface_of)
    member = np.full(len(surfaces) + 1, -1)  # the last is none
    member[:-1] = group
    member[leaders] = -1
    faces = np.flatnonzero(member[surface_of] >= 0)
    number, order = ranked(member[surface_of[faces]])
    sets = Sets.of(number)
    for start, size in zip(sets.starts.tolist(), sets.sizes.tolist(), strict=True):
        leader, mine = leaders[int(number[start])], faces[order[start : start + size]]
        one = _Carried.of(look, surfaces[leader], leader, np.flatnonzero(surface_of == leader))
        surface_of[one.holds(look, mine, cut=True)] = leader


def _fit_again(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices, first: int) -> None:
    """Fit cylinders from the ``first`` on to corners of all their facets, in place."""
    faces = np.flatnonzero(surface_of >= first)
    if len(faces) == 0:
        return
    number, order = ranked(surface_of.take(faces))
    straight = np.array([not one.tube_mm and not one.slope for one in surfaces])
    kept, _ = Sets.of(number).thinned(FACETS_FITTED)
    kept = kept[straight[number.take(kept)]]
    row, corner = look.corners(faces.take(order.take(kept)))
    numbers, which = np.unique(number.take(kept).take(row), return_inverse=True)
    if len(numbers) == 0:
        return
    axis = np.array([surfaces[one].axis for one in numbers.tolist()])
    tight = tight_mm(look)
    fits = _outer_cylinders(look, corner, which, axis)
    for one in np.flatnonzero(fits.worst_mm <= tight).tolist():
        surfaces[int(numbers[one])] = RevolvedSurface(
            fits.point[one], fits.axis[one], float(fits.radius[one])
        )


def _take_over(look: Look, surfaces: list[RevolvedSurface], surface_of: Indices) -> None:
    """Assign the faces of small surfaces to large ones on which all their corners lie as well.

    Seventeen pieces of an oil hole's chords were a cone about another axis, with half of the error bar.
    """
    count = np.bincount(surface_of[surface_of >= 0], minlength=len(surfaces))
    small = np.flatnonzero(np.append(count < LARGE_LEAST, False)[surface_of])
    for number in np.flatnonzero(count >= LARGE_LEAST).tolist():
        if len(small) == 0:
            return
        one = _Carried.of(look, surfaces[number], number, np.flatnonzero(surface_of == number))
        surface_of[one.holds(look, small, cut=False)] = number
        small = small[surface_of[small] != number]


def _outer_cylinders(look: Look, corner: Array, which: Indices, axis: Array) -> Cylinders:
    """Fit cylinders to sets of corners (n, 3), by their numbers (n,), through the outer ones alone.

    If a hole or a keyway cuts a chord, corners lie on the chord, nearer to the axis than the surface.
    """
    fine_mm, most_mm = FINE_SHARE * rounding_mm(look.mesh), look.mesh.diagonal_mm
    fits = cylinders(corner, Sets.of(which), axis, fine_mm, most_mm)
    for _ in range(TRIMS):
        loose = (fits.worst_mm > fine_mm) & np.isfinite(fits.worst_mm)
        if not loose.any():
            break
        local = corner - fits.point[which]
        along = np.einsum("ij,ij->i", local, fits.axis[which])
        off = np.linalg.norm(local - along[:, None] * fits.axis[which], axis=1) - fits.radius[which]
        sets = Sets.of(which)
        off -= sets.medians(off)[which]
        spread = sets.medians(np.abs(off))[which]
        kept = ~loose[which] | (off >= -OUTER_SPREAD * spread - fine_mm)
        kept |= (np.bincount(which, kept) < OUTER_LEAST * sets.sizes)[which]
        corner, which = corner[kept], which[kept]
        fits = cylinders(corner, Sets.of(which), axis, fine_mm, most_mm)
    return fits
