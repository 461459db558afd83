"""Search of a mesh for smooth surfaces: plane faces, and facets that keep turning."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from autobalance.solid.chordal_error.revolved import Revolved, Sets
from autobalance.solid.mesh.adjacency import Edges, edges_of, plane_faces, unit
from autobalance.solid.mesh.mesh import CHUNK, Mesh, numbered_components, ranked
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

# Search of a mesh for smooth surfaces: its plane faces, their smooth meetings, the volumes at stake.


SMOOTH_RAD = 0.8
"""Facets that meet at more have a real edge between them."""
ROUNDINGS, NEARLY = 6.0, 1e-6
"""Steps of single precision, and share of the diagonal, that corners may lie off a surface by."""
ON_SURFACE = 2e-3
"""Distance by which corners may leave a fitted surface, as a share of its radius."""
MAX_SAG_RADIUS_RATIO = 1.0 - np.cos(SMOOTH_RAD / 2.0)
"""Sag of a chord at most, as a share of the radius: half of ``SMOOTH_RAD`` on each side of its middle."""
TIP = 1e-2
"""Radius near the tip of a cone that corners are measured against, as a share of its largest."""
CORNERS_MOST = 600
"""Most corners of a face that may be a chord; larger ones are plane faces of the part."""


@dataclass(frozen=True, eq=False)
class Meetings:
    """Pairs of faces that meet smoothly.

    Attributes
    ----------
    low, high : (n,) int
        The faces of each pair, once however many edges they share.
    middle : (n, 3) float
        Of the edges.
    length_mm : (n,) float
        Of all their edges together.
    hidden_mm3 : (n,) float
        L w² δ / 12, by their length, the lesser width of the two faces and the angle between them.
    angle_rad : (n,) float
        Between the faces.
    sag_mm : (n,) float
        w δ / 8: the depth of a chord so wide that turns by as much.
    """

    low: Indices
    high: Indices
    middle: Array
    length_mm: Array
    hidden_mm3: Array
    angle_rad: Array
    sag_mm: Array


@dataclass(frozen=True, eq=False)
class Look:
    """A mesh with its plane faces and the pairs of faces that meet smoothly."""

    mesh: Mesh
    doubled: Array
    edges: Edges
    face: Indices
    count: int
    normal: Array
    order: Indices
    starts: Indices
    sizes: Indices
    smooth: Indices

    @cached_property
    def pairs(self) -> tuple[Indices, Indices]:
        """The faces on the two sides of each smooth edge."""
        return self.face[self.edges.left[self.smooth]], self.face[self.edges.right[self.smooth]]

    @cached_property
    def parted(self) -> tuple[Indices, Indices]:
        """The faces on the two sides of each edge at a triangle without direction, which belongs to one."""
        left, right = self.face[self.edges.left], self.face[self.edges.right]
        level = np.flatnonzero((self.edges.angle_rad == 0.0) & (left != right))
        return left[level], right[level]

    @cached_property
    def distinct_pairs(self) -> tuple[Indices, Indices, Indices]:
        """The pairs of faces, once each, low · count + high (n,); the first smooth edge and the pair of each.

        A long edge may fall into many: the first of each pair (n,), and for every smooth edge its pair.
        """
        i, j = self.pairs
        ordered, rows = ranked(np.minimum(i, j) * self.count + np.maximum(i, j))
        is_first = np.diff(ordered, prepend=-1) > 0
        number = np.zeros(len(rows), dtype=np.int64)
        number[rows] = np.cumsum(is_first) - 1
        return ordered[is_first], rows[is_first], number

    @property
    def curved_count(self) -> int:
        """Number of faces that meet another smoothly."""
        return int(np.count_nonzero(np.bincount(np.concatenate(self.pairs), minlength=self.count)))

    @cached_property
    def small(self) -> Flags:
        """Mark (count,) of the faces with few enough corners to be chords."""
        return (self.corner_counts > 2) & (self.corner_counts <= CORNERS_MOST)

    @cached_property
    def meetings(self) -> Meetings:
        """Pairs of faces that meet smoothly, and estimates of the volume that their chords hide."""
        pair, _, number = self.distinct_pairs
        vertices = np.ascontiguousarray(self.mesh.vertices.T)
        start, end = (vertices.take(ends.take(self.smooth), axis=1) for ends in self.edges.ends.T)
        length = np.sqrt(np.einsum("kn,kn->n", end - start, end - start))
        whole: Array = np.bincount(number, length, len(pair)).astype(np.float64)
        weight = np.where(whole > 0.0, whole, 1.0)
        angle = np.bincount(number, length * self.edges.angle_rad[self.smooth], len(pair)) / weight
        middles = 0.5 * length * (start + end)
        middle = np.stack([np.bincount(number, column, len(pair)) for column in middles]) / weight
        low, high = pair // self.count, pair % self.count
        across = self.broad_mm2
        width = np.minimum(across[low], across[high]) / weight
        hidden = whole * width**2 * angle / 12.0
        return Meetings(low, high, middle.T, whole, hidden, angle, width * angle / 8.0)

    @cached_property
    def area_mm2(self) -> Array:
        """Area of each face (count,)."""
        area = 0.5 * np.bincount(self.face, self.mesh.doubled_areas, self.count)
        return np.asarray(area, dtype=np.float64)

    @cached_property
    def broad_mm2(self) -> Array:
        """Length times width of each face (count,), of strips and of lone triangles."""
        broad: Array = np.where(self.sizes == 1, 2.0, 1.0) * self.area_mm2
        return broad

    @cached_property
    def at_stake(self) -> Array:
        """Estimate of the volume hidden by each face (count,) with its neighbours, by their angles [mm³]."""
        meetings = self.meetings
        whole = np.bincount(meetings.low, meetings.hidden_mm3, self.count)
        whole = whole + np.bincount(meetings.high, meetings.hidden_mm3, self.count)
        return np.asarray(whole, dtype=np.float64)

    @cached_property
    def first_middles(self) -> Array:
        """The middle (count, 3) of a triangle of each face."""
        middles: Array = self.mesh.vertices[self.mesh.triangles[self.order[self.starts]]].mean(axis=1)
        return middles

    @cached_property
    def is_corner(self) -> Flags:
        """Mark (n,) of the mesh's vertices that are corners: those where three faces meet.

        Two planes meet in a line: other vertices, of a facet that was split, lie on its chords and not on the
        surface.
        """
        beside = self.face[self.edges.left] != self.face[self.edges.right]
        meeting = np.bincount(self.edges.ends[beside].reshape(-1), minlength=len(self.mesh.vertices))
        return np.asarray(meeting > 2)

    @cached_property
    def _corner(self) -> tuple[Indices, Indices]:
        """The corners of all faces, one face after the other, and the start of each face (count + 1,)."""
        vertex = self.mesh.triangles.take(self.order, axis=0).reshape(-1)
        real = self.is_corner.take(vertex)
        before = np.concatenate([[0], np.cumsum(real)])
        return vertex[real], before[3 * np.append(self.starts, len(self.order))]

    @cached_property
    def corner_counts(self) -> Indices:
        """Corners of each face (count,), as often as its triangles have them."""
        return np.diff(self._corner[1]).astype(np.int64)

    @cached_property
    def reach_mm(self) -> Array:
        """Diagonal of the box around the corners of each face (count,)."""
        vertex, starts = self._corner
        some = np.flatnonzero(self.corner_counts)
        reach = np.zeros(self.count)
        if len(some):
            sets, place = Sets(starts[some], len(vertex)), self.mesh.vertices.take(vertex, axis=0)
            reach[some] = np.linalg.norm(sets.most(place) - sets.least(place), axis=1)
        return reach

    def corners(self, faces: Indices) -> tuple[Indices, Array]:
        """Return the corners of some faces, one after the other: row in ``faces`` (k,), point (k, 3)."""
        vertex, starts = self._corner
        size = self.corner_counts.take(faces)
        row = np.repeat(np.arange(len(faces)), size)
        shift = starts.take(faces) - (np.cumsum(size) - size)
        return row, self.mesh.vertices.take(vertex.take(shift.take(row) + np.arange(len(row))), axis=0)


def look_at(mesh: Mesh) -> Look:
    """Find the plane faces of a mesh and the pairs of them that meet smoothly."""
    doubled = mesh.area_vectors
    edges = edges_of(mesh)
    face, count = plane_faces(mesh, edges)
    total = np.zeros((count, 3))
    for column, weights in enumerate(doubled.T):
        total[:, column] = np.bincount(face, weights, count)
    order = ranked(face)[1]
    sizes = np.bincount(face, minlength=count)
    smooth = (edges.angle_rad <= SMOOTH_RAD) & (edges.angle_rad > 0.0)
    smooth &= face[edges.left] != face[edges.right]
    starts = np.cumsum(sizes) - sizes
    return Look(mesh, doubled, edges, face, count, unit(total), order, starts, sizes, np.flatnonzero(smooth))


def tight_mm(look: Look) -> float:
    """Return the distance of corners from a surface by rounding: a few steps of single precision."""
    reach = float(np.abs(look.mesh.bounds).max())
    return ROUNDINGS * float(np.spacing(np.float32(reach))) + NEARLY * look.mesh.diagonal_mm


def lies_on(look: Look, surface: Revolved, faces: Indices) -> Flags:
    """Mark the faces that are chords of a surface: corners on it, middle not too deep, normal across it."""
    row, point = look.corners(faces)
    off = surface.off(point)
    size = surface.tube_mm or surface.r0 + surface.slope * (point - surface.point) @ surface.axis
    greatest = float(np.max(size, initial=0.0))
    if not greatest > 0.0:  # all corners are beyond the tip of a cone
        return np.zeros(len(faces), dtype=bool)
    size = np.maximum(size, TIP * greatest)
    deepest = np.zeros(len(faces))
    highest = np.zeros(len(faces))
    np.minimum.at(deepest, row, off / size)
    np.maximum.at(highest, row, off / size)
    aligned = np.abs(np.einsum("ij,ij->i", surface.normal(look.first_middles[faces]), look.normal[faces]))
    between: Flags = (deepest > -MAX_SAG_RADIUS_RATIO) & (highest < 2.0 * ON_SURFACE)
    return np.asarray(between & (aligned > np.cos(SMOOTH_RAD / 2.0)))


# Facets that keep turning the same way on their other side, as the chords of a curve do.


BESIDE_SHARE = 0.3
"""Angle on the other side of a facet, as a share of the smallest angle that an arc has there, above which the
facets keep turning. Beyond a blunt edge between two surfaces of the part there is less, or nothing."""
FLAT_SHARE = 0.1
"""Facets that meet at less than this share of their largest angles are about one, drawn askew."""
AS_WIDE = 4.5
"""Chords of one curve side by side are less than so many times as wide as each other; planes beside the first
chord of an arc, or beside a chamfer, are wider."""
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


def widths(look: Look, turns: Turns) -> Array:
    """Return the widths (2, n) of the two faces at each edge across it [mm]."""
    return np.stack([widths_across(look, *each) for each in zip(turns.faces, turns.away, strict=True)])


def widths_across(look: Look, faces: Indices, away: Array) -> Array:
    """Return the widths of faces (n,) in directions (3, n) [mm]."""
    row, point = look.corners(faces)
    reach = dotted(point.T, away.take(row, axis=1))
    least, most = np.full(len(faces), np.inf), np.full(len(faces), -np.inf)
    np.minimum.at(least, row, reach)
    np.maximum.at(most, row, reach)
    return np.asarray(np.maximum(most - least, 0.0))


def goes_on(look: Look, turns: Turns) -> Flags:
    """Mark the edges (n,) at which either facet keeps turning the same way on its other side."""
    return np.asarray(goes_on_beyond(look, turns).any(axis=0))


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
