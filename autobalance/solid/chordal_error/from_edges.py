"""Chord error of a large mesh, from the angles at its edges.

Where facets go on turning the same way they are chords of a curve, and the volume beyond them is
L w² δ / 12 at each edge: its length, the lesser width of the two facets, the angle between them, negative
where the surface is hollow. No surface is fitted. An arc of n facets lacks the volume over its two ends,
some 1 / n of it; a fit finds all to the digits of the corners, but takes ten times as long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.chordal_error.estimate import FITTED_SHARE, LOOSE_SHARE, ChordalError
from autobalance.solid.chordal_error.look import Look
from autobalance.solid.mesh.components import numbered_components
from autobalance.types import Array, Flags, Indices

BESIDE_SHARE = 0.3
"""Angle on the other side of a facet, as a share of the least that an arc has there, from which on the facets
go on turning; beyond a blunt edge between two surfaces of the part there is less, or nothing."""
FLAT_SHARE = 0.1
"""Facets that meet at less than this share of their greatest angles are about one, drawn askew."""
GENTLE_RAD = 0.35
"""Angle up to which facets that go on turning are chords: 18 in a circle."""
AS_WIDE = 4.5
"""Facets that meet at more are chords too if neither is so many times as wide as the other, and so are those
beside them; a chamfer between a plane and a cylinder is not."""
KNOWN_SHARE, ASKEW_SHARE, STEEP_SHARE = FITTED_SHARE, 0.12, 0.25
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
    meet, turns = look.meetings, _turns(look)
    size = np.abs(turns.angle_rad)
    goes_on = _goes_on(look, turns)
    steep = goes_on & (size > GENTLE_RAD)
    known = _of_steep_arcs(look, steep) & steep | (goes_on & (size <= GENTLE_RAD))
    mass = density_g_mm3 * meet.hidden_mm3
    signed = np.where(known, np.sign(turns.angle_rad) * mass, 0.0)
    askew = (look.sizes.take(turns.faces) == 1).any(axis=0)
    sure = np.where(steep, STEEP_SHARE, np.where(askew, ASKEW_SHARE, KNOWN_SHARE))
    share = np.where(known, sure, 0.0)
    share[_alone(look, goes_on)] = LOOSE_SHARE
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


@dataclass(frozen=True, eq=False)
class _Turns:
    """Angles between two faces at each edge where they meet smoothly.

    Attributes
    ----------
    faces : (2, n) int
    away : (2, n, 3) float
        From the middle of each face to its edge, across that, in the face's plane.
    angle_rad : (n,) float
        Negative in a hollow.
    """

    faces: Indices
    away: Array
    angle_rad: Array


def _turns(look: Look) -> _Turns:
    edge = look.smooth.take(look.distinct_pairs[1])
    triangles = np.stack([look.edges.left.take(edge), look.edges.right.take(edge)])
    faces = look.face.take(triangles)
    normal = look.normal.take(faces, axis=0)
    along = np.cross(normal[0], normal[1])
    sine = np.sqrt(np.einsum("ij,ij->i", along, along))
    along /= np.where(sine > 0.0, sine, 1.0)[:, None]
    middle = look.mesh.vertices.take(look.edges.ends.take(edge, axis=0), axis=0).mean(axis=1)
    centre = look.mesh.vertices.take(look.mesh.triangles, axis=0).mean(axis=1)
    outward = middle - centre.take(triangles, axis=0)
    away = np.cross(along, normal)
    away *= np.sign(np.einsum("kij,kij->ki", away, outward))[:, :, None]
    angle = np.arctan2(sine, np.einsum("ij,ij->i", normal[0], normal[1]))
    hollow = np.einsum("ij,ij->i", outward[1] - outward[0], normal[0] - normal[1]) < 0.0
    return _Turns(faces, away, np.where(hollow, -angle, angle))


def _goes_on(look: Look, turns: _Turns) -> Flags:
    """Mark the edges (n,) at which a facet goes on turning the same way on its other side.

    Two chords a and b wide meet at κ (a + b) / 2, and b turns by κ b / 2 at its other side at least. Of the
    angles on the sides of a facet, Σ δ c² and Σ δ c with the cosine c to an edge are those on both sides of
    it, added and taken from each other.
    """
    angle, count = turns.angle_rad, look.count
    facets = _whole(turns, count)
    upper = np.triu_indices(3)
    twice = np.where(upper[0] == upper[1], 1.0, 2.0)
    square, first = np.zeros((count, 6)), np.zeros((count, 3))
    for facet, away in zip(facets, turns.away, strict=True):
        for column, (one, other) in enumerate(zip(*upper, strict=True)):
            square[:, column] += np.bincount(facet, angle * away[:, one] * away[:, other], count)
        for column in range(3):
            first[:, column] += np.bincount(facet, angle * away[:, column], count)
    wide = look.broad_mm2.take(turns.faces)
    share = wide / np.maximum(wide.sum(axis=0), 1e-300)
    ongoing = np.zeros(len(angle), dtype=bool)
    for facet, away, part in zip(facets, turns.away, share, strict=True):
        products = twice * away[:, upper[0]] * away[:, upper[1]]
        both = np.einsum("ij,ij->i", square.take(facet, axis=0), products)
        beyond = 0.5 * (both - np.einsum("ij,ij->i", first.take(facet, axis=0), away))
        ongoing |= beyond * np.sign(angle) > BESIDE_SHARE * part * np.abs(angle)
    return ongoing


def _whole(turns: _Turns, count: int) -> Indices:
    """Return the facets (2, n) on the sides of each edge, pieces of one by one number."""
    size = np.abs(turns.angle_rad)
    greatest = np.zeros(count)
    for faces in turns.faces:
        np.maximum.at(greatest, faces, size)
    flat = size < FLAT_SHARE * greatest.take(turns.faces).min(axis=0)
    number: Indices = numbered_components(turns.faces[:, flat].T, count)[0].take(turns.faces)
    return number


def _of_steep_arcs(look: Look, steep: Flags) -> Flags:
    """Mark the edges (n,) beside a facet of a steep arc: one that meets another about as wide."""
    meet, across = look.meetings, look.broad_mm2
    one, other = across.take(meet.low), across.take(meet.high)
    alike = steep & (one < AS_WIDE * other) & (other < AS_WIDE * one)
    of_arc = np.zeros(look.count, dtype=bool)
    of_arc[meet.low[alike]] = of_arc[meet.high[alike]] = True
    return np.asarray(of_arc[meet.low] | of_arc[meet.high])


def _alone(look: Look, goes_on: Flags) -> Flags:
    """Mark the edges (n,) between smooth facets none of whose edges goes on turning."""
    low, high = look.meetings.low, look.meetings.high
    known = np.zeros(look.count, dtype=bool)
    known[low[goes_on]] = known[high[goes_on]] = True
    neighbours = np.bincount(low, minlength=look.count) + np.bincount(high, minlength=look.count)
    open_ = ~known & (neighbours > 1)
    return np.asarray(open_[low] & open_[high])


def _sag_mm(look: Look, known: Flags) -> float:
    """Return the greatest height w δ / 8 over a chord, from the lesser area L w and the hidden volume."""
    meet, across = look.meetings, look.broad_mm2
    area = np.minimum(across.take(meet.low), across.take(meet.high))
    sag = 1.5 * meet.hidden_mm3 / np.where(area > 0.0, area, 1.0)
    return float(sag[known].max(initial=0.0))
