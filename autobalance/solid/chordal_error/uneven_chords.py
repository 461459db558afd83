"""Chord error of a large mesh, from the angles at its edges, and of chords of unlike widths."""

from __future__ import annotations

import math

import numpy as np

from autobalance.solid.chordal_error.bars import LOOSE_SHARE, Bar
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.chordal_error.even_chords import (
    ALONG,
    CUT_CHANGE,
    END_SHARE,
    GENTLE_RAD,
    EvenChords,
    Lenses,
    even_chords,
    joined,
)
from autobalance.solid.chordal_error.look import (
    AS_WIDE,
    Look,
    Turns,
    all_around,
    crossed,
    dotted,
    goes_on_beyond,
    spread_of,
    summed,
    turns_of,
    widths_across,
)
from autobalance.solid.chordal_error.revolved import Sets
from autobalance.solid.chordal_error.steep_arcs import BLUNT_SHARE, put_steep_arcs
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

# Lenses over other facets of a large mesh: cut by holes, split, or between chords of unlike widths.


ONE_WAY_SHARE = 0.05
"""Share of what a cut chord's sides tell that may lie along its rulings."""
CUT_SHARE, UNLIKE_TIMES, CUT_TAPER = 1e-3, 2.0, 0.05
"""Error bar of a cut chord between two others, and the factors on the difference of their curvatures and on
the taper. Of split cones a fifth too much was counted by the width of their facets' wider ends."""
CUT_RATIO = 0.9
"""Width of a last strip, as a share of the next chord's, up to which it is a piece of a chord."""
SEVERAL, SEVERAL_SHARE = 1.5, 0.1
"""A facet that is so many times as wide as the widest of its triangles and no plane is several chords, which
turn by less than roundings may make of slender triangles; its error bar."""
CUT_CORNERS = 300
"""Corners of a facet at most that a hole may have cut; planes of the part, with more, are not looked at."""


def uneven_chords(
    look: Look, turns: Turns, rows: Indices, even: EvenChords, share: Array, around: Flags
) -> Lenses:
    """Return the volume hidden next to the other meetings, at ``rows`` (k,), each with its ``share`` (k,).

    Facets cut by a hole are integrated triangle by triangle. Others count L w² δ / 24 on either side, with w
    the smaller width. Not counted are the volume beyond the last chord of an arc, which is whole, and the
    planes (count,) that others lie all ``around``.
    """
    few, length = turns.at(rows), look.meetings.length_mm.take(rows)
    wide = wide_of(look, few, length)
    least = np.minimum(*wide)
    alike = np.maximum(*wide) < AS_WIDE * least
    half = length * least**2 * np.abs(few.angle_rad) / 24.0
    cut = _cut_facets(look, few, np.where(alike, half, 0.0)) & ~even.known
    lenses = _cut_lenses(look, few, wide, cut, share, length)
    taken = np.where(alike, 1.0, 2.0 * (wide <= least))
    for face, away, counts in zip(few.faces, few.away, taken, strict=True):
        beside = dotted(away, even.towards.take(face, axis=1))
        counts[even.ends.take(face) & (beside < -ALONG) | (cut | around).take(face)] = 0.0
    held, shares = half * taken, _shares_where_known_once(look.count, few, taken, share)
    put_steep_arcs(look, few, wide, held, shares, length)
    change = half * _of_cut_ends(look, few, wide, taken, ~(even.known | cut))
    size = held[0] + held[1] + change
    bar = (shares * held).sum(axis=0) + (share + CUT_CHANGE) * change
    share = bar / np.maximum(size, 1e-300)
    volume = np.sign(few.angle_rad) * size
    place = look.meetings.middle[rows].T
    return joined(lenses, Lenses(volume, place, share, few.along * (length / math.sqrt(12.0))))


def _of_cut_ends(look: Look, turns: Turns, wide: Array, taken: Array, asked: Flags) -> Array:
    """Return the metal beyond L w² δ / 24 that the pieces (k,) of cut last chords hide.

    A flat or a keyway along a shaft leaves a strip, r times as wide as the next chord. The curvature is δ
    over the width of that. Looked at are facets (count,) ``asked`` that meet one other.
    """
    met = np.bincount(turns.faces.reshape(-1), minlength=look.count)
    strips = (asked & (met == 1) & (look.sizes == 2)).take(turns.faces)
    ratio = wide / np.maximum(wide[::-1], 1e-300)
    cut = strips & (ratio < CUT_RATIO) & (np.abs(turns.angle_rad) <= GENTLE_RAD)
    return np.asarray((cut * (6.0 - 4.0 * ratio - taken)).sum(axis=0))


def _shares_where_known_once(count: int, turns: Turns, taken: Array, share: Array) -> Array:
    """Return the error bars (2, k) of both faces; steep chords known from one side may hide as much again.

    An arc of two chords of 22° that ends in edges had half of what it hides, ± 25 %. Here half is estimated.
    """
    told = np.zeros(count, dtype=np.int64)
    for face, counts in zip(turns.faces, taken, strict=True):
        told += np.bincount(face[counts > 0.0], minlength=count)
    steep = np.abs(turns.angle_rad) > GENTLE_RAD
    return np.where(steep & (told.take(turns.faces) == 1), BLUNT_SHARE, share)


def wide_of(look: Look, turns: Turns, length: Array) -> Array:
    """Return the widths of the faces (2, k) across some edges.

    Of planes of the part it is area over length: their many corners would be looked at for each edge.
    """
    wide: Array = look.broad_mm2.take(turns.faces) / np.where(length > 0.0, length, 1.0)
    few = (look.corner_counts <= CUT_CORNERS).take(turns.faces)
    for own, faces, away, some in zip(wide, turns.faces, turns.away, few, strict=True):
        rows = np.flatnonzero(some)
        own[rows] = widths_across(look, faces.take(rows), away.take(rows, axis=1))
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
        second += spread_of(place[face[mine]], held[mine], away[:, mine], len(faces))
    spread = np.linalg.eigvalsh(second)
    marked[faces] = spread[:, 1] <= ONE_WAY_SHARE * spread[:, 2]
    return marked


@dataclass(frozen=True, eq=False)
class _CutChords:
    """Properties of cut facets, by the face (count,): directions across, curvature, error bar.

    ``front`` and ``back`` (3, count) are the directions away from the facet on its two sides: opposite,
    except for the taper of a cone's facet. A chord cut lengthwise was ``times_wider`` (count,).
    """

    across: Array
    front: Array
    back: Array
    curvature: Array
    times_wider: Array
    bar: Array

    @classmethod
    def of(cls, look: Look, turns: Turns, wide: Array, cut: Flags, share: Array, length: Array) -> _CutChords:
        """Add up what the meetings (k,) tell, each with its ``share`` and ``length`` [mm]."""
        count = look.count
        weight, bent, bar, apart = (np.zeros(count) for _ in range(4))
        across, longest = np.zeros((3, count)), np.zeros(count)
        both = wide[0] + wide[1]
        curvature = 2.0 * turns.angle_rad / np.where(both > 0.0, both, 1.0)
        alike = np.maximum(*wide) < AS_WIDE * np.minimum(*wide)
        sides = [np.flatnonzero(alike & cut[face]) for face in turns.faces]
        wider = np.zeros(count)
        nexts = wide / np.maximum(wide[::-1], 1e-300)
        for face, away, mine, next_ in zip(turns.faces, turns.away, sides, nexts[::-1], strict=True):
            np.maximum.at(wider, face[mine], next_[mine])
            weight += np.bincount(face[mine], length[mine], count)
            bent += np.bincount(face[mine], length[mine] * curvature[mine], count)
            np.maximum.at(bar, face[mine], share[mine])
            order = mine[np.argsort(length[mine], kind="stable")]
            order = order[length[order] >= longest[face[order]]]
            across[:, face[order]], longest[face[order]] = away[:, order], length[order]
        mean = bent / np.where(weight > 0.0, weight, 1.0)
        before, behind = np.zeros((3, count)), np.zeros((3, count))
        lengths = np.zeros((2, count))
        for face, away, mine in zip(turns.faces, turns.away, sides, strict=True):
            own, told, side = face[mine], length[mine], away[:, mine]
            beside = dotted(side, across[:, own])
            ahead, back = told * (beside > ALONG), told * (beside < -ALONG)
            lengths += np.bincount(own, ahead, count), np.bincount(own, back, count)
            before += summed(own, ahead * side, count)
            behind += summed(own, back * side, count)
            apart += np.bincount(own, told * np.abs(curvature[mine] - mean[own]), count)
        sure = lengths.min(axis=0) > END_SHARE * lengths.max(axis=0)
        front = np.where(sure, before / np.maximum(lengths[0], 1e-300), across)
        behind = np.where(sure, behind / np.maximum(lengths[1], 1e-300), -across)
        askew = crossed(front, behind)
        taper = 0.5 * np.sqrt(dotted(askew, askew)) * longest**2 / np.maximum(look.broad_mm2, 1e-300)
        told = CUT_SHARE + UNLIKE_TIMES * apart / np.maximum(np.abs(bent), 1e-300) + CUT_TAPER * taper
        piece = ~sure & (wider * CUT_RATIO > 1.0)
        ratio = np.where(piece, 1.0 / np.maximum(wider, 1.0), 1.0)
        mean *= 0.5 * (1.0 + ratio)
        bar = np.where(
            sure, np.minimum(bar, told), bar + CUT_CHANGE * ((1.5 - ratio) * (1.0 + ratio) / ratio - 1.0)
        )
        return cls(across, front, behind, mean, 1.0 / ratio, bar)


def _cut_lenses(look: Look, turns: Turns, wide: Array, cut: Flags, share: Array, length: Array) -> Lenses:
    """Return the lenses over cut facets: ∫ κ a b / 2 over each of their triangles.

    a and b are the distances to the chord's two rulings, κ is as much more as the chord is narrower there.
    """
    faces = np.flatnonzero(cut)
    if len(faces) == 0:
        return Lenses(np.zeros(0), np.zeros((3, 0)), np.zeros(0), np.zeros((3, 0)))
    chords = _CutChords.of(look, turns, wide, cut, share, length)
    sizes = look.sizes[faces]
    sets = Sets(np.cumsum(sizes) - sizes, int(sizes.sum()))
    triangles = look.order[look.starts[faces][sets.number] + np.arange(sets.count) - sets.starts[sets.number]]
    face = faces[sets.number]
    vertices = np.ascontiguousarray(look.mesh.vertices.T)
    corners = np.stack([vertices.take(each.take(triangles), axis=1) for each in look.mesh.triangles.T])
    x, a, b = (
        np.einsum("jkn,kn->jn", corners, each.take(face, axis=1))
        for each in (chords.across, chords.front, chords.back)
    )
    reach = sets.most(np.maximum.reduce(x)) - sets.least(np.minimum.reduce(x))
    for out in (a, b):
        np.subtract(sets.most(np.maximum.reduce(out)).take(sets.number), out, out=out)
    beyond = (chords.times_wider.take(face) - 1.0) * reach.take(sets.number)
    b += beyond
    product = ((a * b).sum(axis=0) + a.sum(axis=0) * b.sum(axis=0)) / 12.0
    here = (a.sum(axis=0) + b.sum(axis=0)) / 3.0
    height = 0.5 * product * (reach.take(sets.number) + beyond) / np.maximum(here, 1e-300)
    chord = sets.most(np.maximum.reduce(x) - np.minimum.reduce(x))
    up = np.einsum("jkn,kn->jn", corners, look.normal.T.take(face, axis=1))
    deep = sets.most(np.maximum.reduce(up)) - sets.least(np.minimum.reduce(up))
    curved, bar = chords.curvature[faces], chords.bar
    uneven = deep > 0.5 * np.abs(curved) * reach**2 / 8.0
    several = np.flatnonzero((uneven & (reach > SEVERAL * chord))[sets.number])
    height[several] = chord[sets.number[several]] ** 2 / 12.0
    bar[face[several]] = np.maximum(bar[face[several]], SEVERAL_SHARE)
    area = 0.5 * look.mesh.doubled_areas.take(triangles)
    return Lenses(
        curved.take(sets.number) * height * area,
        (corners[0] + corners[1] + corners[2]) / 3.0,
        bar.take(face),
        _longest_sides(corners) / math.sqrt(18.0),
    )


def _longest_sides(corners: Array) -> Array:
    """Return the longest side (3, n) of triangles (3, 3, n), by corners; their mass has L / √18 along it."""
    a, b, c = corners
    longest, longest_square = b - a, dotted(b - a, b - a)
    for side in (c - b, a - c):
        square = dotted(side, side)
        longest = np.where(square > longest_square, side, longest)
        longest_square = np.maximum(square, longest_square)
    return np.asarray(longest)


# Chord error of a large mesh, from the angles at its edges.
#
# Facets that keep turning the same way are chords of a curve. Between chords about as wide it is known from
# both sides of each facet (`even_chords`). Elsewhere the volume beyond is L w² δ / 12 at each edge: its
# length, the smaller width of the two facets, the angle between them, negative where the surface is hollow.
# No surface is fitted: that gives all to the digits of the corners, but takes five times as long.


KNOWN_SHARE, ASKEW_SHARE, STEEP_SHARE = 0.04, 0.12, 0.25
"""Error bars, as shares of the estimates from edges: gentle ones between facets of four corners, those next
to a triangle, whose sides lie askew to the curvature, and steeper ones. Cranks with over 25 000 curved facets
have 0.005 if they were generated, 0.075 if the CAD kernel drew fillets of triangles.
"""


def chordal_error_from_edges(look: Look, density_g_mm3: float) -> ChordalError:
    """Estimate the chord error of a mesh from the edges of its `Look`.

    Returns
    -------
    ChordalError
        ``surfaces`` is 0 and ``fitted`` None: nothing was fitted.
    """
    meet, turns = look.meetings, turns_of(look)
    size = np.abs(turns.angle_rad)
    even = even_chords(look, turns)
    around = all_around(turns.faces, turns.away, look.count)
    ongoing = _ongoing(look, turns, even, around)
    steep = ongoing & (size > GENTLE_RAD)
    known = _of_steep_arcs(look, steep) & steep | (ongoing & (size <= GENTLE_RAD))
    left = known.copy()
    left[even.rows] = False
    rows = np.flatnonzero(left)
    askew = (look.sizes.take(turns.faces.take(rows, axis=1)) == 1).any(axis=0)
    share = np.where(steep[rows], STEEP_SHARE, np.where(askew, ASKEW_SHARE, KNOWN_SHARE))
    lenses = joined(even.lenses, uneven_chords(look, turns, rows, even, share, around))
    alone = np.flatnonzero(_alone(look, ongoing) & ~even.coarse)
    mass, at = density_g_mm3 * lenses.volume, lenses.place.T
    bars = Bar.of(np.abs(mass) * lenses.share, at)
    bars = bars + Bar.of(LOOSE_SHARE * density_g_mm3 * meet.hidden_mm3[alone], meet.middle[alone])
    mean, mean_square = bars.along / (bars.unbalance_g_mm or 1.0)
    return ChordalError(
        lenses.moments(density_g_mm3),
        bars.mass_g,
        bars.unbalance_g_mm,
        float(np.abs(mass).sum()),
        float(np.abs(mass) @ np.hypot(at[:, 0], at[:, 1])),
        _sag_mm(look, known),
        0,
        (float(mean), float(mean_square)),
    )


def _ongoing(look: Look, turns: Turns, even: EvenChords, around: Flags) -> Flags:
    """Mark the edges (n,) at which either facet keeps turning, at a side where the next is about as wide.

    Only those between uneven chords are looked at. Blunt edges between planes do not keep turning, also where
    these end in the narrow chords of an arc: two at 12° gave 4 g that are not missing.
    """
    left = ~even.coarse
    left[even.rows] = False
    asked = np.zeros(look.count, dtype=bool)
    asked[turns.faces[:, left]] = True
    near = asked.take(turns.faces)
    rows = np.flatnonzero(near[0] | near[1])
    few = turns.at(rows)
    ongoing = np.zeros(len(left), dtype=bool)
    beyond = goes_on_beyond(look, few, wide_of(look, few, look.meetings.length_mm.take(rows)))
    ongoing[rows] = (beyond & ~around.take(few.faces)).any(axis=0)
    ongoing &= left
    ongoing[even.rows] = True
    return ongoing


def _of_steep_arcs(look: Look, steep: Flags) -> Flags:
    """Mark the edges (n,) beside a facet of a steep arc: one that meets another about as wide."""
    meet, across = look.meetings, look.broad_mm2
    one, other = across.take(meet.low), across.take(meet.high)
    alike = steep & (one < AS_WIDE * other) & (other < AS_WIDE * one)
    of_arc = np.zeros(look.count, dtype=bool)
    of_arc[meet.low[alike]] = of_arc[meet.high[alike]] = True
    return np.asarray(of_arc[meet.low] | of_arc[meet.high])


def _alone(look: Look, ongoing: Flags) -> Flags:
    """Mark the edges (n,) between smooth facets without an edge that keeps turning."""
    low, high = look.meetings.low, look.meetings.high
    known = np.zeros(look.count, dtype=bool)
    known[low[ongoing]] = known[high[ongoing]] = True
    neighbours = np.bincount(low, minlength=look.count) + np.bincount(high, minlength=look.count)
    open_ = ~known & (neighbours > 1)
    return np.asarray(open_[low] & open_[high])


def _sag_mm(look: Look, known: Flags) -> float:
    """Return the largest height w δ / 8 over a chord, from the lesser area L w and the hidden volume."""
    meet, across = look.meetings, look.broad_mm2
    area = np.minimum(across.take(meet.low), across.take(meet.high))
    sag = 1.5 * meet.hidden_mm3 / np.where(area > 0.0, area, 1.0)
    return float(sag[known].max(initial=0.0))
