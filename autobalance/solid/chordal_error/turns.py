"""Facets that keep turning the same way on their other side, as the chords of a curve do."""

from __future__ import annotations

import numpy as np

from autobalance.solid.chordal_error.look import Look
from autobalance.solid.mesh.mesh import CHUNK, numbered_components
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

BESIDE_SHARE = 0.3
"""Angle on the other side of a facet, as a share of the smallest angle that an arc has there, above which the
facets keep turning. Beyond a blunt edge between two surfaces of the part there is less, or nothing."""
FLAT_SHARE = 0.1
"""Facets that meet at less than this share of their largest angles are about one, drawn askew."""
AS_WIDE = 4.5
"""Chords of one curve side by side are less than so many times as wide as each other; planes beside the first
chord of an arc, or beside a chamfer, are wider."""
CUT_CORNERS = 300
"""Corners of a facet at most that a hole may have cut; planes of the part, with more, are not looked at."""
CHORD_MEETS, AROUND_SHARE = 16, 0.2
"""Largest number of faces that a chord meets smoothly: two, and a few if fillets end it or triangles divide
it. With more, they lie along two sides, and the squares of their directions across these are at most this
share."""


@dataclass(frozen=True, eq=False)
class Turns:
    """Angles between two faces at each edge where they meet smoothly.

    Attributes
    ----------
    faces : (2, n) int
    away : (2, 3, n) float
        From the middle of each face to its edge, across that, in the face's plane. By columns, as all
        vectors here: numpy is many times as fast along them as across rows of three.
    along : (3, n) float
        Direction of the edge, either way.
    angle_rad : (n,) float
        Negative in a hollow.
    """

    faces: Indices
    away: Array
    along: Array
    angle_rad: Array

    def at(self, rows: Indices) -> Turns:
        """Return those at some rows (k,)."""
        faces, angle = self.faces.take(rows, axis=1), self.angle_rad.take(rows)
        return Turns(faces, self.away.take(rows, axis=2), self.along.take(rows, axis=1), angle)

    def at_slice(self, part: slice) -> Turns:
        """Return views of some rows."""
        return Turns(self.faces[:, part], self.away[..., part], self.along[:, part], self.angle_rad[part])


def turns_of(look: Look, rows: Indices | None = None) -> Turns:
    """Return the angle at each meeting of two faces, or at some of them by their ``rows``, in their order.

    They are computed so many at a time that what lies between stays in the processor's cache.
    """
    first = look.distinct_pairs[1]
    edge = look.smooth.take(first if rows is None else first.take(rows))
    count = len(edge)
    found = Turns(
        np.zeros((2, count), dtype=np.int64), np.zeros((2, 3, count)), np.zeros((3, count)), np.zeros(count)
    )
    normals, vertices = (np.ascontiguousarray(each.T) for each in (look.normal, look.mesh.vertices))
    for begin in range(0, count, CHUNK):
        part = slice(begin, begin + CHUNK)
        _fill(found.at_slice(part), look, edge[part], normals, vertices)
    return found


def _fill(turns: Turns, look: Look, edge: Indices, normals: Array, vertices: Array) -> None:
    """Write the turns at some edges (n,); ``normals`` and ``vertices`` by columns."""
    triangles = np.stack([look.edges.left.take(edge), look.edges.right.take(edge)])
    turns.faces[:] = look.face.take(triangles)
    normal = [normals.take(each, axis=1) for each in turns.faces]
    along = crossed(*normal)
    sine = np.sqrt(dotted(along, along))
    along /= np.where(sine > 0.0, sine, 1.0)
    turns.along[:] = along
    start, end = look.edges.ends.take(edge, axis=0).T
    middle = 0.5 * (vertices.take(start, axis=1) + vertices.take(end, axis=1))
    opposite = look.mesh.triangles.take(triangles, axis=0).sum(axis=2) - (start + end)
    outward = [middle - vertices.take(each, axis=1) for each in opposite]
    for away, each, out in zip(turns.away, normal, outward, strict=True):
        either = crossed(along, each)
        away[:] = either * np.sign(dotted(either, out))
    angle = np.arctan2(sine, dotted(*normal))
    hollow = dotted(outward[1] - outward[0], normal[0] - normal[1]) < 0.0
    turns.angle_rad[:] = np.where(hollow, -angle, angle)


def crossed(one: Array, other: Array) -> Array:
    """Return the cross products (3, n) of vectors (3, n)."""
    (ax, ay, az), (bx, by, bz) = one, other
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def dotted(one: Array, other: Array) -> Array:
    """Return the scalar products (n,) of vectors (3, n)."""
    return np.asarray(np.einsum("kn,kn->n", one, other))


def summed(number: Indices, vectors: Array, count: int) -> Array:
    """Return the sums (3, count) of vectors (3, n) by their numbers (n,)."""
    return np.stack([np.bincount(number, column, count) for column in vectors])


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


def widths_across(look: Look, faces: Indices, away: Array) -> Array:
    """Return the widths of faces (n,) in directions (3, n) [mm]."""
    row, point = look.corners(faces)
    reach = dotted(point.T, away.take(row, axis=1))
    least, most = np.full(len(faces), np.inf), np.full(len(faces), -np.inf)
    np.minimum.at(least, row, reach)
    np.maximum.at(most, row, reach)
    return np.asarray(np.maximum(most - least, 0.0))


def goes_on_beyond(look: Look, turns: Turns, wide: Array | None = None) -> Flags:
    """Mark, of the two facets (2, n) at each edge, those that keep turning the same way on their other side.

    Two chords a and b wide meet at κ (a + b) / 2, and b turns by κ b / 2 at its other side at least. With the
    angles on the sides of a facet, Σ δ c² and Σ δ c with the cosine c to an edge are those on both sides of
    it, added and subtracted. Next to a plane of the part b counts as if it were ``AS_WIDE``: the sides of a
    cone's facet lean a little to its wider end, too. Given the widths ``wide`` (2, n) of the faces across
    their edges, a facet keeps turning only at sides where the next is about as wide, or wider.
    """
    count = 2 * look.count
    angles = [turns.angle_rad, turns.angle_rad]
    if wide is not None:
        angles = [np.where(AS_WIDE * next_ > own, turns.angle_rad, 0.0) for own, next_ in (wide, wide[::-1])]
    facets = _whole(turns, look.count)
    upper = list(zip(*np.triu_indices(3), strict=True))
    square, first = np.zeros((6, count)), np.zeros((3, count))
    for facet, away, angle in zip(facets, turns.away, angles, strict=True):
        bent = angle * away
        first += summed(facet, bent, count)
        for column, (one, other) in enumerate(upper):
            square[column] += np.bincount(facet, bent[one] * away[other], count)
    across = look.broad_mm2.take(turns.faces) if wide is None else wide
    share = np.maximum(across / np.maximum(across.sum(axis=0), 1e-300), 1.0 / (1.0 + AS_WIDE))
    angle = turns.angle_rad
    ongoing = []
    for facet, away, part in zip(facets, turns.away, share, strict=True):
        beyond = -dotted(first.take(facet, axis=1), away)
        for held, (one, other) in zip(square, upper, strict=True):
            beyond += (1.0 if one == other else 2.0) * held.take(facet) * away[one] * away[other]
        ongoing.append(0.5 * beyond * np.sign(angle) > BESIDE_SHARE * part * np.abs(angle))
    return np.stack(ongoing)


def _whole(turns: Turns, count: int) -> Indices:
    """Return the facets (2, n) on the sides of each edge, pieces of one by one number, up to 2 ``count``.

    All facets of a cone turn by little beside what they do to the plane within: no piece goes all around one.
    """
    size = np.abs(turns.angle_rad)
    greatest = np.zeros(count)
    for faces in turns.faces:
        np.maximum.at(greatest, faces, size)
    flat = size < FLAT_SHARE * greatest.take(turns.faces).min(axis=0)
    number: Indices = numbered_components(turns.faces[:, flat].T, count)[0].take(turns.faces)
    steps = np.flatnonzero(~flat)
    around = all_around(number.take(steps, axis=1), turns.away.take(steps, axis=2), count).take(number)
    return np.asarray(np.where(around, count + turns.faces, number))


def all_around(number: Indices, away: Array, count: int) -> Flags:
    """Mark the faces (count,) that meet many others all around, by their ``number`` (2, n) at each edge.

    Those are planes of the part and no chords: a cone around one would be the next chord of a dome.
    """
    meets = np.bincount(number.reshape(-1), minlength=count)
    many = np.flatnonzero(meets > CHORD_MEETS)
    marked = np.zeros(count, dtype=bool)
    if len(many) == 0:
        return marked
    place = np.full(count, -1)
    place[many] = np.arange(len(many))
    second = np.zeros((len(many), 3, 3))
    for mine, side in zip(place.take(number), away, strict=True):
        rows = np.flatnonzero(mine >= 0)
        second += spread_of(mine.take(rows), np.ones(len(rows)), side.take(rows, axis=1), len(many))
    spread = np.linalg.eigvalsh(second)
    marked[many] = spread[:, 1] > AROUND_SHARE * spread[:, 2]
    return marked


def spread_of(number: Indices, weight: Array, side: Array, count: int) -> Array:
    """Return Σ w s sᵀ (count, 3, 3) of directions (3, n) with weights (n,), by their numbers (n,)."""
    second = np.zeros((count, 3, 3))
    for one in range(3):
        for other in range(3):
            second[:, one, other] = np.bincount(number, weight * side[one] * side[other], count)
    return second
