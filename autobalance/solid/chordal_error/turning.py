"""Which facets go on turning the same way on their other side, as the chords of a curve do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.solid.chordal_error.look import Look
from autobalance.solid.mesh.components import numbered_components
from autobalance.types import Array, Flags, Indices

BESIDE_SHARE = 0.3
"""Angle on the other side of a facet, as a share of the least that an arc has there, from which on the facets
go on turning; beyond a blunt edge between two surfaces of the part there is less, or nothing."""
FLAT_SHARE = 0.1
"""Facets that meet at less than this share of their greatest angles are about one, drawn askew."""
AS_WIDE = 4.5
"""Chords of one curve side by side are less than so many times as wide as each other; planes beside the first
chord of an arc, or beside a chamfer, are wider."""


@dataclass(frozen=True, eq=False)
class Turns:
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


def turns_of(look: Look, rows: Indices | None = None) -> Turns:
    """Return the angle at each meeting of two faces, or at some of them by their ``rows``, in their order."""
    first = look.distinct_pairs[1]
    edge = look.smooth.take(first if rows is None else first.take(rows))
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
    return Turns(faces, away, np.where(hollow, -angle, angle))


def widths(look: Look, turns: Turns) -> Array:
    """Return how wide (2, n) the two faces at each edge are across it [mm]."""
    found = []
    for faces, away in zip(turns.faces, turns.away, strict=True):
        row, point = look.corners(faces)
        reach = np.einsum("ij,ij->i", point, away.take(row, axis=0))
        least, most = np.full(len(faces), np.inf), np.full(len(faces), -np.inf)
        np.minimum.at(least, row, reach)
        np.maximum.at(most, row, reach)
        found.append(np.maximum(most - least, 0.0))
    return np.stack(found)


def goes_on(look: Look, turns: Turns) -> Flags:
    """Mark the edges (n,) at which either facet goes on turning the same way on its other side."""
    return np.asarray(goes_on_beyond(look, turns).any(axis=0))


def goes_on_beyond(look: Look, turns: Turns, wide: Array | None = None) -> Flags:
    """Mark, of the two facets (2, n) at each edge, those that go on turning the same way on their other side.

    Two chords a and b wide meet at κ (a + b) / 2, and b turns by κ b / 2 at its other side at least. Of the
    angles on the sides of a facet, Σ δ c² and Σ δ c with the cosine c to an edge are those on both sides of
    it, added and taken from each other. Given how ``wide`` (2, n) the faces are across their edges, one goes
    on only at sides where the next is about as wide, or wider.
    """
    count = look.count
    angles = [turns.angle_rad, turns.angle_rad]
    if wide is not None:
        angles = [np.where(AS_WIDE * next_ > own, turns.angle_rad, 0.0) for own, next_ in (wide, wide[::-1])]
    facets = _whole(turns, count)
    upper = np.triu_indices(3)
    twice = np.where(upper[0] == upper[1], 1.0, 2.0)
    square, first = np.zeros((count, 6)), np.zeros((count, 3))
    for facet, away, angle in zip(facets, turns.away, angles, strict=True):
        for column, (one, other) in enumerate(zip(*upper, strict=True)):
            square[:, column] += np.bincount(facet, angle * away[:, one] * away[:, other], count)
        for column in range(3):
            first[:, column] += np.bincount(facet, angle * away[:, column], count)
    across = look.broad_mm2.take(turns.faces) if wide is None else wide
    share = across / np.maximum(across.sum(axis=0), 1e-300)
    angle = turns.angle_rad
    ongoing = []
    for facet, away, part in zip(facets, turns.away, share, strict=True):
        products = twice * away[:, upper[0]] * away[:, upper[1]]
        both = np.einsum("ij,ij->i", square.take(facet, axis=0), products)
        beyond = 0.5 * (both - np.einsum("ij,ij->i", first.take(facet, axis=0), away))
        ongoing.append(beyond * np.sign(angle) > BESIDE_SHARE * part * np.abs(angle))
    return np.stack(ongoing)


def _whole(turns: Turns, count: int) -> Indices:
    """Return the facets (2, n) on the sides of each edge, pieces of one by one number."""
    size = np.abs(turns.angle_rad)
    greatest = np.zeros(count)
    for faces in turns.faces:
        np.maximum.at(greatest, faces, size)
    flat = size < FLAT_SHARE * greatest.take(turns.faces).min(axis=0)
    number: Indices = numbered_components(turns.faces[:, flat].T, count)[0].take(turns.faces)
    return number
