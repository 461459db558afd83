"""Triangles with shared vertices, the exact weld that makes them from loose corners, and their parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.types import Array, Floats, Indices, Numbers
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    import trimesh

    from autobalance.types import Indices


# Connected components of many nodes, without a loop over them.


def components(links: Indices, count: int) -> Indices:
    """Return the lowest node of each node's component (count,); see ``numbered_components``."""
    number, lowest = _numbered(links, count)
    return lowest.take(number)


def numbered_components(links: Indices, count: int) -> tuple[Indices, int]:
    """Return the number of each node's component (count,), from 0 by the lowest node; and their count.

    Parameters
    ----------
    links : (k, m) int
        Nodes that belong together, m at a time: the triangles of a mesh, or pairs.
    count : int
        Nodes in all, numbered from 0.
    """
    number, lowest = _numbered(links, count)
    return number, len(lowest)


def _numbered(links: Indices, count: int) -> tuple[Indices, Indices]:
    """Return the number of each node's component (count,) and the lowest node of each component.

    Every node hangs under the lowest that a link joins it to; connected nodes are one node of the next round,
    until no link joins two. Numbers that follow the surface, as a weld gives them, need a few rounds.
    """
    number = lowest = np.arange(count)
    columns = [np.ascontiguousarray(column) for column in links.T]
    while len(columns[0]):
        low = columns[0]
        for column in columns[1:]:
            low = np.minimum(low, column)
        root = np.arange(len(lowest))
        for column in columns:
            np.minimum.at(root, column, low)
        while not np.array_equal(higher := root.take(root), root):
            root = higher
        is_root = root == np.arange(len(root))
        joined = (np.cumsum(is_root) - 1).take(root)
        number, lowest = joined.take(number), lowest[is_root]
        ends = [joined.take(column) for column in columns]
        apart = np.zeros(len(low), dtype=bool)
        for end in ends[1:]:
            apart |= end != ends[0]
        left = np.flatnonzero(apart)
        columns = [end.take(left) for end in ends]
    return number, lowest


# Volume moments of the tetrahedra that triangles span with the origin.


CHUNK = 1 << 13
"""Triangles at a time: their corners stay in the processor's cache."""


def volume_moments(vertices: Array, triangles: Indices) -> Moments:
    """Return ∫ dV, ∫ r dV and ∫ r rᵀ dV about the origin, which is best near the part."""
    axes = np.ascontiguousarray(vertices.T)
    return summed(
        axes.take(triangles[start : start + CHUNK].T, axis=1).swapaxes(0, 1)
        for start in range(0, len(triangles), CHUNK)
    )


def summed(chunks: Iterable[Array]) -> Moments:
    """Add up the tetrahedra that triangles span with the origin, some at a time: corners × axes (3, 3, k)."""
    volume = 0.0
    first = np.zeros(3)
    second = np.zeros((3, 3))
    for a, b, c in chunks:
        det = six_volumes(a, b, c)
        total = a + b + c
        volume += float(det.sum())
        first += total @ det
        for corner in (total, a, b, c):
            second += (corner * det) @ corner.T
    return Moments(volume / 6.0, first / 24.0, second / 120.0)


def six_volumes(a: Array, b: Array, c: Array) -> Array:
    """Return six times the signed volumes of tetrahedra between the origin and corners (3, k)."""
    det: Array = a[0] * (b[1] * c[2] - b[2] * c[1])
    det += a[1] * (b[2] * c[0] - b[0] * c[2])
    det += a[2] * (b[0] * c[1] - b[1] * c[0])
    return det


# Triangles with shared vertices, and the exact weld that makes them from loose corners.


CACHED_VERTICES = 10_000
"""Vertices that stay in the processor's cache: the numbers of a triangle's corners should span no more."""

SAMPLE = 40_000
"""Triangles of a sample: so many of the largest, and about as many spread evenly over the rest."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles over shared vertices, counter-clockwise seen from outside.

    Attributes
    ----------
    vertices : (n, 3) float64
        Positions in the file's axes [mm].
    triangles : (m, 3) int64
        Vertex numbers.
    """

    vertices: Array
    triangles: Indices

    @property
    def corners(self) -> Array:
        """The triangles' corners (m, 3, 3) [mm]."""
        return self.vertices.take(self.triangles, axis=0)

    @cached_property
    def bounds(self) -> Array:
        """Smallest and largest coordinates (2, 3) [mm]."""
        return np.array([[column.min() for column in self.vertices.T], [c.max() for c in self.vertices.T]])

    @property
    def diagonal_mm(self) -> float:
        """Length of the diagonal of the bounding box [mm]."""
        low, high = self.bounds
        return float(np.linalg.norm(high - low))

    @property
    def area_vectors(self) -> Array:
        """Twice the area vector (m, 3) of each triangle, pointing outward [mm²]."""
        return self._areas[0]

    @property
    def doubled_areas(self) -> Array:
        """Twice the area (m,) of each triangle [mm²]."""
        return self._areas[1]

    @cached_property
    def _areas(self) -> tuple[Array, Array]:
        """Twice the area vectors (m, 3) and areas (m,)."""
        vectors, sizes = np.zeros((len(self.triangles), 3)), np.zeros(len(self.triangles))
        axes = np.ascontiguousarray(self.vertices.T)
        for begin in range(0, len(sizes), CHUNK):
            a, b, c = axes.take(self.triangles[begin : begin + CHUNK].T, axis=1).swapaxes(0, 1)
            b -= a
            c -= a
            (ux, uy, uz), (vx, vy, vz) = b, c
            x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            part = slice(begin, begin + CHUNK)
            vectors[part, 0], vectors[part, 1], vectors[part, 2] = x, y, z
            sizes[part] = np.sqrt(x * x + y * y + z * z)
        return vectors, sizes

    @cached_property
    def parts_at_vertices(self) -> tuple[Indices, int]:
        """The part (n,) of each vertex, where triangles that share a vertex are one, and the number of parts.

        A vertex of no triangle is a part too.
        """
        return numbered_components(self.triangles, len(self.vertices))

    @cached_property
    def moments_about_middle(self) -> Moments:
        """∫ dV, ∫ r dV and ∫ r rᵀ dV inside a closed mesh, about the middle of its bounding box."""
        return volume_moments(self.vertices - self.bounds.mean(axis=0), self.triangles)

    @cached_property
    def twins(self) -> NDArray[np.int32] | None:
        """The two sides (2, k) of every edge of a closed mesh; see ``twins_of``."""
        return twins_of(self.triangles)

    @cached_property
    def twin_sides(self) -> NDArray[np.int32] | None:
        """For each side 3 t + corner of the mesh, the other one on its edge (3 m,); None like `twins`."""
        if self.twins is None:
            return None
        up, down = self.twins
        beside = np.zeros(2 * len(up), dtype=np.int32)
        beside[up], beside[down] = down, up
        return beside

    @cached_property
    def sample(self) -> tuple[Indices, Array]:
        """Rows and weights of a sample of triangles: the largest, and every n-th of the rest.

        A few large triangles may be a whole face, many small ones a whole fillet.
        """
        count = len(self.triangles)
        if count <= 2 * SAMPLE:
            return np.arange(count), np.ones(count)
        large = np.argpartition(self.doubled_areas, count - SAMPLE)[-SAMPLE:]
        is_large = np.zeros(count, dtype=bool)
        is_large[large] = True
        rest = np.flatnonzero(~is_large)
        every = len(rest) // SAMPLE
        rows = np.concatenate([large, rest[::every]])
        return rows, np.concatenate([np.ones(SAMPLE), np.full(len(rows) - SAMPLE, float(every))])

    def part(self, keep: NDArray[np.bool_]) -> Mesh:
        """Return some of the triangles, marked in ``keep`` (m,), with only the vertices they use."""
        return self.at(np.flatnonzero(keep))

    def at(self, rows: Indices) -> Mesh:
        """Return some of the triangles, by their rows, with only the vertices they use."""
        used, triangles = compacted(self.triangles.take(rows, axis=0), len(self.vertices))
        return Mesh(self.vertices.take(np.flatnonzero(used), axis=0), triangles)

    def flipped(self) -> Mesh:
        """Return the mesh turned inside out."""
        return Mesh(self.vertices, self.triangles[:, ::-1])

    def moved(self, placement: Array) -> Mesh:
        """Return the mesh with the homogeneous matrix ``placement`` (4, 4) applied to its vertices."""
        moved = Mesh(self.vertices @ placement[:3, :3].T + placement[:3, 3], self.triangles)
        if "twins" in self.__dict__:
            moved.__dict__["twins"] = self.twins
        return moved

    def take_over(self, same: Mesh) -> None:
        """Take over what was computed of a mesh of the same numbers, to the bit."""
        for name in ("bounds", "_areas", "moments_about_middle", "twins", "twin_sides"):
            if name in same.__dict__:
                self.__dict__[name] = same.__dict__[name]


def weld(points: Floats) -> tuple[Floats, Indices]:
    """Find the distinct points among many, by exact equality of their coordinates.

    Parameters
    ----------
    points : (k, 3) float32 or float64
        Finite coordinates; −0 counts as 0.

    Returns
    -------
    distinct : (n, 3), of the same type
        In the order of their first appearance.
    number : (k,) int64
        For each point its row in ``distinct``.
    """
    points = points + points.dtype.type(0.0)  # −0 becomes 0, so that equal numbers have equal bits
    leader = _first_equal(points)
    is_first = leader == np.arange(len(points))
    rank = np.cumsum(is_first) - 1
    return points.take(np.flatnonzero(is_first), axis=0), rank.take(leader)


def _first_equal(points: Floats) -> Indices:
    """Return the row of the first point equal to each of points (k, 3), (k,).

    Hash and row share one number, which numpy sorts several times faster than it finds a sorting order. The
    bits left to the hash are few enough that points may share one by chance: those are grouped again.
    """
    count = len(points)
    key, order = sorted_with_rows(hash_rows(points))
    starts = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]])) if count else order
    leader = np.zeros(count, dtype=np.int64)
    leader[order] = np.repeat(order.take(starts), np.diff(starts, append=count))
    differs = np.flatnonzero(points.take(leader, axis=0) != points) // 3
    if len(differs):
        differs = np.unique(differs)
        leader[differs] = differs[_first_equal(points[differs])]
    return leader


def sorted_with_rows(numbers: NDArray[np.uint64]) -> tuple[NDArray[np.uint64], Indices]:
    """Return numbers (k,) in rising order, and the row that each had.

    They are sorted in place, with their rows in the bits below; what of them no longer fits in 64 is lost.
    """
    bits = np.uint64(len(numbers).bit_length())
    numbers <<= bits
    numbers |= np.arange(len(numbers), dtype=np.uint64)
    numbers.sort()
    rows = (numbers & ((np.uint64(1) << bits) - np.uint64(1))).view(np.int64)
    numbers >>= bits
    return numbers, rows


def ranked(numbers: Indices) -> tuple[Indices, Indices]:
    """Return whole numbers (k,), not below zero, in rising order, equal ones as they come, and their rows.

    They are sorted together with their rows, which numpy does many times as fast as finding an order.
    """
    bits = len(numbers).bit_length()
    if len(numbers) == 0 or int(numbers.max()) >> (64 - bits):
        order = np.argsort(numbers, kind="stable")
        return numbers.take(order), order
    ordered, rows = sorted_with_rows(numbers.astype(np.uint64))
    return ordered.view(np.int64), rows


def twins_of(triangles: Indices) -> NDArray[np.int32] | None:
    """Return the two sides of every edge, None unless each joins two triangles that run it opposite ways.

    Such a mesh is closed and outward or inward throughout: manifold3d asks no more of a body. Sides that run
    up, from the lower vertex, and those that run down are sorted by themselves: they must be the same edges.

    Returns
    -------
    (2, k) int32 or None
        Numbers 3 t + corner of the sides that run up, and of those that run down; edges rise by their lower,
        then by their higher vertex.
    """
    many = len(triangles)
    if many == 0 or many % 2:
        return None
    start = np.ascontiguousarray(triangles.T)
    end = start[[1, 2, 0]].reshape(-1)
    start = start.reshape(-1)
    runs_up = start < end
    up, down = np.flatnonzero(runs_up), np.flatnonzero(~runs_up)
    if len(up) != len(down):
        return None
    count = int(triangles.max()) + 1
    edge, up_rows = ranked(_edge_numbers(start.take(up), end.take(up), count))
    again, down_rows = ranked(_edge_numbers(end.take(down), start.take(down), count))
    if not np.array_equal(edge, again) or (edge[1:] == edge[:-1]).any():
        return None
    found = np.zeros((2, len(up)), dtype=np.int32)
    for out, place in zip(found, (up.take(up_rows), down.take(down_rows)), strict=True):
        corner, triangle = np.divmod(place, many)
        out[:] = 3 * triangle + corner
    return found


def _edge_numbers(low: Indices, high: Indices, count: int) -> Indices:
    """Return one number for each edge (k,) between vertices low < high < ``count``.

    They rise by the lower vertex, unless only those that rise by the higher one can be sorted with their rows
    in 64 bits: from some 2.5 million triangles on.
    """
    if (count * count) >> (64 - len(low).bit_length()):
        return high * (high - 1) // 2 + low
    return low * count + high


def hash_rows(points: Floats) -> NDArray[np.uint64]:
    """Mix each row of numbers into 64 bits (multiply and rotate, as in FNV)."""
    words = np.ascontiguousarray(points).view(np.uint32).reshape(len(points), 3 * points.itemsize // 4)
    keys = np.zeros(len(words), dtype=np.uint64)
    for start in range(0, len(words), CHUNK):
        first, *others = words[start : start + CHUNK].T
        key = keys[start : start + CHUNK]
        key += first
        for column in others:
            key *= np.uint64(0x9E3779B97F4A7C15)
            key ^= key >> np.uint64(32)
            key += column
        key *= np.uint64(0xD6E8FEB86659FD93)
        key ^= key >> np.uint64(32)
    return keys


def hash_numbers(numbers: Indices) -> NDArray[np.uint64]:
    """Mix each number into 64 bits."""
    key = numbers.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    key ^= key >> np.uint64(29)
    key *= np.uint64(0xD6E8FEB86659FD93)
    key ^= key >> np.uint64(32)
    return key


def in_space_order(mesh: Mesh) -> Mesh:
    """Return the mesh with neighbours in space close in memory, if its file has them scattered.

    A solid of a million scattered triangles takes a third longer to build, and every look at them as well.
    Vertices are sorted along Morton's curve (G. M. Morton, 1966), triangles by the first of their vertices.
    """
    some = mesh.triangles[:: max(1, len(mesh.triangles) // CHUNK)]
    if len(some) == 0 or np.median(np.ptp(some, axis=1)) <= CACHED_VERTICES:
        return mesh
    low, high = mesh.bounds
    extent = float((high - low).max())
    code = np.zeros(len(mesh.vertices), dtype=np.uint64)
    for axis, (column, least) in enumerate(zip(mesh.vertices.T, low, strict=True)):
        cell = ((column - least) / extent * (len(MORTON) - 1)).astype(np.int64)
        code |= MORTON.take(cell) << np.uint64(axis)
    order = sorted_with_rows(code)[1]
    number = np.zeros(len(order), dtype=np.int64)
    number[order] = np.arange(len(order))
    triangles = number.take(mesh.triangles)
    a, b, c = triangles.T
    first = np.minimum(np.minimum(a, b), c).view(np.uint64)
    return Mesh(mesh.vertices.take(order, axis=0), triangles.take(sorted_with_rows(first)[1], axis=0))


def _every_third_bit(bits: int) -> NDArray[np.uint64]:
    """Return the numbers below 2 ** ``bits`` with two zeros put in after each of their binary digits."""
    numbers = np.arange(1 << bits, dtype=np.uint64)
    spread = np.zeros_like(numbers)
    for bit in range(bits):
        spread |= (numbers >> np.uint64(bit) & np.uint64(1)) << np.uint64(3 * bit)
    return spread


MORTON = _every_third_bit(10)
"""For each of 1024 cells along an axis, its part in a Morton number."""


def least_and_greatest(values: Numbers, triangles: Indices) -> tuple[Numbers, Numbers]:
    """Return the least and the largest (m,) of the values (n,) at each triangle's corners."""
    values = np.ascontiguousarray(values)  # else each take would copy them all
    least, greatest = np.zeros(len(triangles), values.dtype), np.zeros(len(triangles), values.dtype)
    for begin in range(0, len(triangles), CHUNK):
        a, b, c = values.take(triangles[begin : begin + CHUNK]).T
        least[begin : begin + CHUNK] = np.minimum(np.minimum(a, b), c)
        greatest[begin : begin + CHUNK] = np.maximum(np.maximum(a, b), c)
    return least, greatest


def rows_where(condition: Callable[..., NDArray[np.bool_]], *columns: Array) -> Indices:
    """Return the rows at which columns (m,) meet a condition on them.

    So many at a time that what lies between stays in the cache: whole columns take three times as long.
    """
    found = [np.zeros(0, dtype=np.int64)]
    for begin in range(0, len(columns[0]), CHUNK):
        met = condition(*(column[begin : begin + CHUNK] for column in columns))
        found.append(begin + np.flatnonzero(met))
    return np.concatenate(found)


def longest_sides(corners: Array) -> Array:
    """Return the length (m,) of the longest side of each of loose triangles (m, 3, 3)."""
    sides = (corners[:, k] - corners[:, k - 1] for k in range(3))
    squares = [x * x + y * y + z * z for x, y, z in (side.T for side in sides)]
    longest: Array = np.sqrt(np.maximum.reduce(squares))
    return longest


def compacted(triangles: Indices, count: int) -> tuple[NDArray[np.bool_], Indices]:
    """Return a mark of the vertices in use (count,), and the triangles renumbered among those alone."""
    used = np.zeros(count, dtype=bool)
    used[triangles.reshape(-1)] = True
    return used, (np.cumsum(used) - 1).take(triangles)


def without_collapsed(triangles: Indices) -> Indices:
    """Return the triangles whose three vertex numbers differ; the others bound nothing."""
    a, b, c = triangles.T
    whole = (a != b) & (b != c) & (c != a)
    return triangles if whole.all() else triangles[whole]


def mesh_of_soup(soup: Floats, mm_per_unit: float = 1.0) -> Mesh:
    """Weld loose triangles (m, 3, 3), in any unit, to a mesh in mm; collapsed triangles are dropped."""
    distinct, number = weld(soup.reshape(-1, 3))
    vertices = distinct.astype(np.float64) * mm_per_unit
    return Mesh(vertices, without_collapsed(number.reshape(-1, 3)))


# Meshes for other libraries.


def to_trimesh(mesh: Mesh) -> trimesh.Trimesh:
    """Return a mesh of trimesh with the same corners and triangles."""
    import trimesh

    return trimesh.Trimesh(mesh.vertices.copy(), mesh.triangles.copy(), process=False, validate=False)


# List of a file's bodies in one line.


LISTED_BODIES = 12
"""Most bodies that are listed, the largest."""


def few(entries: Sequence[str]) -> str:
    """Return entries in one line, the first ``LISTED_BODIES`` and a count of the others."""
    more = len(entries) - LISTED_BODIES
    return "; ".join(entries[:LISTED_BODIES]) + (f"; and {more} smaller ones" if more > 0 else "")


def listed(entries: Sequence[str]) -> str:
    """Return a sentence on the number of a file's bodies, with their entries."""
    count = "1 body" if len(entries) == 1 else f"{len(entries)} bodies"
    return f"the file holds {count} ({few(entries)})"
