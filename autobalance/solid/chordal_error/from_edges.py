"""Chord error of a large mesh, from the angles at its edges.

Where facets go on turning the same way they are chords of a curve, and the volume beyond them is
L w² δ / 12 at each edge: its length, the lesser width of the two facets, the angle between them, negative
where the surface is hollow. No surface is fitted. An arc of n facets lacks the volume over its two ends,
some 1 / n of it; a fit finds all to the digits of the corners, but takes ten times as long.
"""

from __future__ import annotations

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.chordal_error.bars import LOOSE_SHARE
from autobalance.solid.chordal_error.estimate import ChordalError
from autobalance.solid.chordal_error.look import Look
from autobalance.solid.chordal_error.turning import AS_WIDE, goes_on, turns_of
from autobalance.types import Flags

GENTLE_RAD = 0.35
"""Angle up to which facets that go on turning are chords: 18 in a circle."""
KNOWN_SHARE, ASKEW_SHARE, STEEP_SHARE = 0.04, 0.12, 0.25
"""Error bars, as shares of the estimates from edges: gentle ones between facets of four corners;
those beside a triangle, whose sides lie askew to the curvature; steeper ones. Of cranks with over 25 000
curved facets, 0.005 is found where they were generated, 0.075 where the CAD kernel drew fillets of triangles.
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
    ongoing = goes_on(look, turns)
    steep = ongoing & (size > GENTLE_RAD)
    known = _of_steep_arcs(look, steep) & steep | (ongoing & (size <= GENTLE_RAD))
    mass = density_g_mm3 * meet.hidden_mm3
    signed = np.where(known, np.sign(turns.angle_rad) * mass, 0.0)
    askew = (look.sizes.take(turns.faces) == 1).any(axis=0)
    sure = np.where(steep, STEEP_SHARE, np.where(askew, ASKEW_SHARE, KNOWN_SHARE))
    share = np.where(known, sure, 0.0)
    share[_alone(look, ongoing)] = LOOSE_SHARE
    first = signed @ meet.middle
    out, z = np.hypot(*meet.middle[:, :2].T), meet.middle[:, 2]
    bar = share * mass * out
    whole = float(bar.sum())
    weight = bar / (whole or 1.0)
    return ChordalError(
        Moments(float(signed.sum()), first, (meet.middle * signed[:, None]).T @ meet.middle),
        float(share @ mass),
        whole,
        float(np.abs(signed).sum()),
        float(np.abs(signed) @ out),
        _sag_mm(look, known),
        0,
        (float(weight @ z), float(weight @ z**2)),
    )


def _of_steep_arcs(look: Look, steep: Flags) -> Flags:
    """Mark the edges (n,) beside a facet of a steep arc: one that meets another about as wide."""
    meet, across = look.meetings, look.broad_mm2
    one, other = across.take(meet.low), across.take(meet.high)
    alike = steep & (one < AS_WIDE * other) & (other < AS_WIDE * one)
    of_arc = np.zeros(look.count, dtype=bool)
    of_arc[meet.low[alike]] = of_arc[meet.high[alike]] = True
    return np.asarray(of_arc[meet.low] | of_arc[meet.high])


def _alone(look: Look, ongoing: Flags) -> Flags:
    """Mark the edges (n,) between smooth facets none of whose edges goes on turning."""
    low, high = look.meetings.low, look.meetings.high
    known = np.zeros(look.count, dtype=bool)
    known[low[ongoing]] = known[high[ongoing]] = True
    neighbours = np.bincount(low, minlength=look.count) + np.bincount(high, minlength=look.count)
    open_ = ~known & (neighbours > 1)
    return np.asarray(open_[low] & open_[high])


def _sag_mm(look: Look, known: Flags) -> float:
    """Return the greatest height w δ / 8 over a chord, from the lesser area L w and the hidden volume."""
    meet, across = look.meetings, look.broad_mm2
    area = np.minimum(across.take(meet.low), across.take(meet.high))
    sag = 1.5 * meet.hidden_mm3 / np.where(area > 0.0, area, 1.0)
    return float(sag[known].max(initial=0.0))
