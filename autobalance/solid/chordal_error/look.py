"""Search of a mesh for smooth surfaces: plane faces, and facets that keep turning."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from autobalance.solid.chordal_error.revolved import RevolvedSurface, Sets
from autobalance.solid.mesh.adjacency import Edges, edges_of, plane_faces, unit
from autobalance.solid.mesh.mesh import Mesh, compacted, ranked
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
    def vertices(self) -> Array:
        """The mesh's vertices by columns (3, n): numpy is many times as fast along them."""
        return np.ascontiguousarray(self.mesh.vertices.T)

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

    def first_middles(self, faces: Indices) -> Array:
        """Return the middle (k, 3) of a triangle of each of some faces."""
        corners = self.mesh.triangles.take(self.order.take(self.starts.take(faces)), axis=0)
        middles: Array = sum(self.mesh.vertices.take(each, axis=0) for each in corners.T) / 3.0
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
    def corner_counts(self) -> Indices:
        """Corners of each face (count,), as often as its triangles have them."""
        real = sum(self.is_corner.take(each).view(np.int8) for each in self.mesh.triangles.T)
        return np.bincount(self.face, real, self.count).astype(np.int64)

    def reach_mm(self, faces: Indices) -> Array:
        """Return the diagonal of the box around the corners of each of some faces (k,)."""
        row, place = self.corners(faces)
        some = np.flatnonzero(self.corner_counts.take(faces))
        reach = np.zeros(len(faces))
        if len(some):
            sets = Sets.of(row)
            reach[some] = np.linalg.norm(sets.most(place) - sets.least(place), axis=1)
        return reach

    def part(self, faces: Indices) -> Look:
        """Return the look at some faces (k,), numbered as there, with the edges between them."""
        sizes = self.sizes.take(faces)
        starts = np.cumsum(sizes) - sizes
        rows = self.order.take(np.repeat(self.starts.take(faces) - starts, sizes) + np.arange(sizes.sum()))
        triangle = np.full(len(self.face), -1)
        triangle[rows] = np.arange(len(rows))
        used, triangles = compacted(self.mesh.triangles.take(rows, axis=0), len(self.mesh.vertices))
        mesh = Mesh(self.mesh.vertices[used], triangles)
        doubled = self.doubled.take(rows, axis=0)
        mesh.__dict__.update(bounds=self.mesh.bounds, _areas=(doubled, self.mesh.doubled_areas.take(rows)))
        among = triangle >= 0
        within = np.flatnonzero(among.take(self.edges.left))
        within = within.take(np.flatnonzero(among.take(self.edges.right.take(within))))
        left, right = (triangle.take(side.take(within)) for side in (self.edges.left, self.edges.right))
        ends = (np.cumsum(used) - 1).take(self.edges.ends.take(within, axis=0))
        angle, flat = self.edges.angle_rad.take(within), self.edges.flat.take(within)
        edges = Edges(left, right, ends, angle, flat)
        is_smooth = np.zeros(len(self.edges.left), dtype=bool)
        is_smooth[self.smooth] = True
        smooth = np.flatnonzero(is_smooth.take(within))
        face = np.repeat(np.arange(len(faces)), sizes)
        normal = self.normal.take(faces, axis=0)
        part = Look(
            mesh, doubled, edges, face, len(faces), normal, np.arange(len(rows)), starts, sizes, smooth
        )
        part.__dict__["is_corner"] = self.is_corner[used]
        return part

    def corners(self, faces: Indices) -> tuple[Indices, Array]:
        """Return the corners of some faces, one after the other: row in ``faces`` (k,), point (k, 3)."""
        size = self.sizes.take(faces)
        row = np.repeat(np.arange(len(faces)), size)
        shift = self.starts.take(faces) - (np.cumsum(size) - size)
        triangles = self.order.take(shift.take(row) + np.arange(len(row)))
        vertex = self.mesh.triangles.take(triangles, axis=0).reshape(-1)
        real = np.flatnonzero(self.is_corner.take(vertex))
        return row.take(real // 3), self.mesh.vertices.take(vertex.take(real), axis=0)


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


def lies_on(look: Look, surface: RevolvedSurface, faces: Indices) -> Flags:
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
    between: Flags = (deepest > -MAX_SAG_RADIUS_RATIO) & (highest < 2.0 * ON_SURFACE)
    return between & faces_along(look, surface, faces)


def faces_along(look: Look, surface: RevolvedSurface, faces: Indices) -> Flags:
    """Mark the faces whose normal is across a surface."""
    normal = surface.normal(look.first_middles(faces))
    aligned = np.abs(np.einsum("ij,ij->i", normal, look.normal.take(faces, axis=0)))
    return np.asarray(aligned > np.cos(SMOOTH_RAD / 2.0))
