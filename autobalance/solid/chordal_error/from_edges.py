"""Chord error of a large mesh, from the angles at its edges.

Facets that keep turning the same way are chords of a curve. Between chords about as wide it is known from
both sides of each facet (`even_chords`). Elsewhere the volume beyond is L w² δ / 12 at each edge: its length,
the smaller width of the two facets, the angle between them, negative where the surface is hollow. No surface
is fitted: that gives all to the digits of the corners, but takes five times as long.
"""

from __future__ import annotations

import numpy as np

from autobalance.solid.chordal_error.bars import LOOSE_SHARE, Bar
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.chordal_error.even_chords import (
    GENTLE_RAD,
    EvenChords,
    even_chords,
    joined,
)
from autobalance.solid.chordal_error.look import Look
from autobalance.solid.chordal_error.turning import AS_WIDE, Turns, all_around, goes_on_beyond, turns_of
from autobalance.solid.chordal_error.uneven_chords import uneven_chords, wide_of
from autobalance.types import Flags

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
