"""Steep chords of a large mesh, as in a fillet of two to four rows, from the angles on both their sides.

A chord of an arc that turns by τ over it hides w² (τ − sin τ) / (8 sin² τ/2) for each millimetre of its
length. Between two chords τ is the angle between them, shared by their widths. Between a chord and a plane
that the arc goes over into it is twice the angle. If both sides of a chord give the same τ, nothing else is
free: a fillet between two surfaces has no other radius.
"""

from __future__ import annotations

import numpy as np

from autobalance.solid.chordal_error.even_chords import ALONG, GENTLE_RAD
from autobalance.solid.chordal_error.look import AS_WIDE, Look, Turns, dotted
from autobalance.types import Array, Flags
from autobalance.value_classes import dataclass

AGREE_SHARE = 0.1
"""Difference of a chord's turns by both sides, as a share of their sum, up to which they are of one arc. In
a real edge at the end of an arc they differ by a third and more."""
BY_ANGLE = 0.02
"""Error bar of a chord whose sides agree, by the square of its turn: 0.0095 is seen of fillets of two to four
rows about journals of 8 to 35 mm."""
BY_DIFFERENCE = 0.5
"""Error bar of such a chord by the difference of its turns: either may be the true one."""
BLUNT_SHARE = 1.1
"""Error bar of a chord at a real edge, as a share of half its lens, which is the estimate: two such chords
are an arc, or two chamfers that hide nothing. A tenth more, as an arc's lens is exact to 0.006."""
SHORTEST_SHARE = 0.5
"""Length of the shorter side of a chord, as a share of the longer, from which on both tell of all of it; of
a fillet's rows it is 0.7 about the thinnest of journals."""


@dataclass(frozen=True, eq=False)
class _Ends:
    """Turns of faces from both their sides.

    Attributes
    ----------
    beside : (2, k) float
        Cosine of each meeting's side to its face's direction across.
    turn_rad : (2, count) float
        From the side in that direction and from the other, signed; zero without one.
    both : (count,) bool
        Marks the faces with turns of one sign on both sides.
    plane : (2, count) bool
        Marks the ends at a plane, or at a facet that is much wider.
    """

    beside: Array
    turn_rad: Array
    both: Flags
    plane: Flags


def put_steep_arcs(look: Look, turns: Turns, wide: Array, held: Array, share: Array, length: Array) -> None:
    """Write the volumes ``held`` [mm³] and error bars ``share`` (2, k) of steep chords known from both sides.

    The meetings have ``turns``, widths ``wide`` (2, k) [mm] and a ``length`` (k,) [mm].
    """
    ends = _ends(look, turns, wide, held, length)
    size = np.abs(ends.turn_rad)
    apart = np.abs(size[0] - size[1]) / np.maximum(size[0] + size[1], 1e-300)
    agree = ends.both & (apart < AGREE_SHARE)
    at_plane = np.where(ends.plane, size, 0.0).max(axis=0)
    blunt = ends.both & ~agree & (at_plane == size.max(axis=0))
    turn = np.where(blunt, size.min(axis=0), 0.5 * (size[0] + size[1]))
    bars = np.where(blunt, BLUNT_SHARE, BY_ANGLE * turn**2 + BY_DIFFERENCE * apart)
    factor = np.where(blunt, 0.5, 1.0) * 0.5 * _lens_of_unit_chord(np.where(ends.both, turn, 1.0))
    known = agree | blunt
    for face, beside, own, bar, across in zip(turns.faces, ends.beside, held, share, wide, strict=True):
        rows = np.flatnonzero(known.take(face) & (np.abs(beside) > ALONG) & (own > 0.0))
        own[rows] = length[rows] * across[rows] ** 2 * factor.take(face[rows])
        bar[rows] = bars.take(face[rows])


def _lens_of_unit_chord(turn_rad: Array) -> Array:
    """Return the area between an arc and its chord over the square of the chord."""
    lens: Array = (turn_rad - np.sin(turn_rad)) / (8.0 * np.sin(0.5 * turn_rad) ** 2)
    return lens


def _ends(look: Look, turns: Turns, wide: Array, held: Array, length: Array) -> _Ends:
    """Return the turns of steep facets of two triangles from both their sides."""
    count, size = look.count, np.abs(turns.angle_rad)
    alike = np.maximum(*wide) < AS_WIDE * np.minimum(*wide)
    told = (held > 0.0) & (look.sizes == 2).take(turns.faces)
    steep = told & alike & (size > GENTLE_RAD)
    steepest, across = np.zeros(count), np.zeros((3, count))
    for face, some in zip(turns.faces, steep, strict=True):
        np.maximum.at(steepest, face[some], size[some])
    for face, some, away in zip(turns.faces, steep, turns.away, strict=True):
        rows = np.flatnonzero(some & (size >= steepest.take(face)))
        across[:, face[rows]] = away[:, rows]
    beside = np.zeros(wide.shape)
    lengths, turned = np.zeros((2, count)), np.zeros((2, count))
    plane = np.zeros((2, count), dtype=bool)
    share = wide / np.maximum(wide[0] + wide[1], 1e-300)
    turn = turns.angle_rad * 2.0 * np.where(alike, share, 1.0) * length
    for face, away, own, some, cosine in zip(turns.faces, turns.away, turn, told, beside, strict=True):
        cosine[:] = dotted(away, across.take(face, axis=1))
        for end, way in enumerate((cosine, -cosine)):
            rows = np.flatnonzero(some & (way > ALONG))
            lengths[end] += np.bincount(face[rows], length[rows], count)
            turned[end] += np.bincount(face[rows], own[rows], count)
            plane[end, face[rows[~alike[rows]]]] = True
    both = lengths.min(axis=0) > SHORTEST_SHARE * lengths.max(axis=0)
    both &= turned[0] * turned[1] > 0.0
    return _Ends(beside, turned / np.maximum(lengths, 1e-300), both, plane)
