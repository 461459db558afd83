"""Mass moments of a closed triangle mesh, and metal that it counts twice, or not at all."""

from __future__ import annotations

from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.mesh.adjacency import linked_triangles
from autobalance.solid.mesh.mesh import (
    CHUNK,
    Mesh,
    least_and_greatest,
    numbered_components,
    six_volumes,
    summed,
)
from autobalance.types import Array, Floats, Indices
from autobalance.value_classes import dataclass

# Exact mass moments of a closed triangle mesh, from the divergence theorem.


def mesh_moments(mesh: Mesh, density_g_mm3: float, frame: Array | None = None) -> Moments:
    """Return the mass moments of the solid that a closed mesh bounds.

    Each triangle spans a tetrahedron with a point near the part, so that no digits are lost when the part
    lies far from the origin; signed, the tetrahedra add up to the solid.

    Parameters
    ----------
    mesh : Mesh
        Closed, outward [mm].
    density_g_mm3 : float
        Density [g/mm³].
    frame : (4, 4) float, optional
        Rigid motion from the mesh's coordinates to those the moments are wanted in.

    Returns
    -------
    Moments
        About the origin of the wanted frame.

    References
    ----------
    C. Zhang, T. Chen, "Efficient feature extraction for 2D/3D objects in mesh representation", 2001: signed
    tetrahedra; second moments of a tetrahedron with a corner at the origin, det/120 (s sᵀ + Σ v vᵀ).
    """
    near = mesh.bounds.mean(axis=0)
    return _placed(mesh.moments_about_middle, near, density_g_mm3, frame)


def soup_moments(soup: Floats, density_g_mm3: float, frame: Array | None = None) -> Moments:
    """Return the mass moments of the solid that loose triangles (m, 3, 3) bound, as ``mesh_moments`` does."""
    some = soup[:: max(1, len(soup) // NEAR_ENOUGH)].reshape(-1, 3)
    near = 0.5 * (some.min(axis=0) + some.max(axis=0)).astype(np.float64)
    volume = summed(
        np.ascontiguousarray((soup[start : start + CHUNK] - near).transpose(1, 2, 0))
        for start in range(0, len(soup), CHUNK)
    )
    return _placed(volume, near, density_g_mm3, frame)


NEAR_ENOUGH = 1000
"""Triangles sampled to see where a part lies."""


def _placed(volume: Moments, near: Array, density_g_mm3: float, frame: Array | None) -> Moments:
    shift = np.eye(4)
    shift[:3, 3] = near
    return volume.scaled(density_g_mm3).moved(shift if frame is None else frame @ shift)


def signed_volume_mm3(mesh: Mesh) -> float:
    """Return the volume inside a closed mesh, negative if it is inside out."""
    axes = np.ascontiguousarray((mesh.vertices - mesh.bounds.mean(axis=0)).T)
    return (
        sum(
            float(
                six_volumes(*axes.take(mesh.triangles[begin : begin + CHUNK].T, axis=1).swapaxes(0, 1)).sum()
            )
            for begin in range(0, len(mesh.triangles), CHUNK)
        )
        / 6.0
    )


def part_volumes(mesh: Mesh, part_of: Indices, count: int) -> Array:
    """Return the signed volume (count,) inside each part of a closed mesh, negative if it is inside out.

    Parameters
    ----------
    mesh : Mesh
        Closed in every part [mm].
    part_of : (m,) int
        The part, from 0 to ``count`` − 1, of each triangle.
    count : int
    """
    height = mesh.vertices[:, 2] - mesh.bounds[:, 2].mean()
    volumes = np.zeros(count)
    for start in range(0, len(part_of), CHUNK):
        some = slice(start, start + CHUNK)
        a, b, c = height.take(mesh.triangles[some]).T
        under = mesh.area_vectors[some, 2] * (a + b + c)
        volumes += np.bincount(part_of[some], weights=under, minlength=count)
    return volumes / 6.0


# Parts of a closed mesh that bound next to nothing: folded triangles, no metal.


# Needed by finely drawn STL whose folded slivers close on themselves (tests: "crumbs that bound nothing").


CRUMB_VOLUME_SHARE = 1e-12
"""Share of a file's volume that a body must bound: rounding to single precision leaves far less."""


_PARTS: WeakKeyDictionary[Mesh, tuple[Indices, int]] = WeakKeyDictionary()
"""Parts of meshes without crumbs: their bodies are requested as soon as they are built."""


def parts_at_edges(mesh: Mesh) -> tuple[Indices, int]:
    """Return the part (m,) of each triangle of a closed mesh, which may touch itself, and their number."""
    known = _PARTS.get(mesh)
    return numbered_components(linked_triangles(mesh), len(mesh.triangles)) if known is None else known


def without_crumbs(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Return a closed mesh without its crumbs, and a note on those, if any."""
    part_of, count = parts_at_edges(mesh)
    volumes = np.abs(part_volumes(mesh, part_of, count))
    is_crumb = volumes <= CRUMB_VOLUME_SHARE * volumes.sum()
    number = int(is_crumb.sum())
    if number in (0, count):
        _PARTS[mesh] = part_of, count
        return mesh, []
    stays = ~is_crumb.take(part_of)
    kept = mesh.part(stays)
    _PARTS[kept] = (np.cumsum(~is_crumb) - 1).take(part_of[stays]), count - number
    return kept, [crumbs_dropped(number, float(volumes[is_crumb].sum()))]


def crumbs_dropped(number: int, volume_mm3: float) -> str:
    """Return a note on dropped crumbs."""
    name = "1 crumb" if number == 1 else f"{number} crumbs"
    return f"{name} dropped that bound {volume_mm3:.3g} mm³: folded triangles, no metal"


# Fields of parallel rays through a closed mesh: where along them metal counts twice, or as negative.
#
# Going along a ray, a triangle that is entered adds one to the winding number and one that is left takes one
# away; in a solid the number is 0 or 1 everywhere. The mesh is cut by evenly spaced planes, and in each of
# them two fields of rays run square to each other: the segments of a plane serve both. All rays of a field
# are followed at once, without a loop.


DEPTH_BITS = 32
"""Depths along a ray are distinguished to so many bits of the body's length: half a nanometre in a metre."""
LENGTH_LEAST = 1e-8
"""Shorter stretches, as a share of the diagonal, are rounding where surfaces touch."""
SHIFT = np.array([0.3090, 0.5772, 0.4142])
"""Places of planes and rays in their cells, along each axis of the frame."""
TRIANGLES_AT_ONCE = 4 * CHUNK
"""Triangles at a time: a quarter of them is cut."""
Whole = NDArray[np.int64]
Levels = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Doubled:
    """Double or negative metal, as measured by a field of rays.

    Attributes
    ----------
    volume_mm3 : float
        Of it, counted as often as it is too much or too little.
    low_mm, high_mm : (3,) float
        Smallest and largest coordinates of the stretches of rays within it; meaningless without any.
    stretches : int
        Number of stretches of rays within it.
    pitch_mm : float
        Distance of the rays.
    """

    volume_mm3: float
    low_mm: Array
    high_mm: Array
    stretches: int
    pitch_mm: float


@dataclass(frozen=True, eq=False)
class Segments:
    """Segments (k,) in which planes cut triangles, head to tail around metal, in pitches of the rays.

    Attributes
    ----------
    plane : (k,) int
        Number of the plane, which is also its place along the second axis.
    first, third : (2, k) float
        Start and end along the first and the third axis, bitwise the same where two triangles meet.
    """

    plane: Whole
    first: Array
    third: Array


def frame_along(direction: Array, across: Array) -> Array:
    """Return a right-handed frame (3, 3), in rows: its last axis a direction, its first nearly ``across``."""
    along = direction / np.linalg.norm(direction)
    second = np.cross(along, across)
    second /= np.linalg.norm(second)
    return np.stack([np.cross(second, along), second, along])


def doubled_metal(mesh: Mesh, rays: int, axes: Array) -> list[Doubled]:
    """Follow parallel rays through a closed, outward mesh and add up the metal that does not count once.

    Parameters
    ----------
    mesh : Mesh
    rays : int
        Smallest number of rays in each field, over the rectangle that the mesh fills as seen along them.
    axes : (3, 3) float
        A right-handed frame, in rows: planes are square to its second axis.

    Returns
    -------
    list of Doubled
        By the field along the third axis, and by the one along the first.
    """
    places = axes @ mesh.vertices.T
    low, high = places.min(axis=1), places.max(axis=1)
    size = np.maximum(high - low, 1e-12 * mesh.diagonal_mm)
    pitch = float(np.sqrt(size[1] * min(size[0], size[2]) / rays))
    start = low - pitch * SHIFT
    places -= start[:, None]
    places /= pitch
    wide, _, long = (size / pitch).astype(np.int64) + 2
    cut = _segments(places, mesh.triangles)
    along_third = _stretches(cut.plane, cut.first, cut.third, wide, long)
    # seen from the other side of the plane, first and third change places and all goes round the other way
    times, ends = _stretches(cut.plane, cut.third[::-1], cut.first[::-1], long, wide)
    least = LENGTH_LEAST * mesh.diagonal_mm
    return [
        _doubled(times, start + pitch * ends, pitch, least, axes)
        for times, ends in (along_third, (times, ends[:, :, ::-1]))
    ]


def _doubled(times: Whole, ends: Array, pitch: float, least_mm: float, axes: Array) -> Doubled:
    """Return the metal on stretches of rays between ends (2, k, 3), in the frame [mm]."""
    length = np.abs(ends[1] - ends[0]).sum(axis=1)  # along one axis of the frame
    volume = float(length @ times) * pitch * pitch
    seen = ends[:, length > least_mm].reshape(-1, 3) @ axes
    if not len(seen):
        return Doubled(volume, np.zeros(3), np.zeros(3), 0, pitch)
    return Doubled(volume, seen.min(axis=0), seen.max(axis=0), len(seen) // 2, pitch)


def _segments(places: Array, triangles: Indices) -> Segments:
    """Cut triangles (m, 3) by the planes at whole numbers of the second of ``places`` (3, n).

    Segments that no ray meets are left out, which are nearly all of them where triangles are fine or thin.
    """
    level = np.ceil(places).astype(np.int32)  # a corner lies below the planes from its own on
    segments = []
    for start in range(0, len(triangles), TRIANGLES_AT_ONCE):
        corners = np.ascontiguousarray(triangles[start : start + TRIANGLES_AT_ONCE].T)
        corners = corners.take(np.flatnonzero(_apart(level[1], corners)), axis=1)
        rows = np.flatnonzero(_apart(level[0], corners) | _apart(level[2], corners))
        segments.append(_cut(places, level[1], corners.take(rows, axis=1)))
    return Segments(*(np.concatenate(column, axis=-1) for column in zip(*segments, strict=True)))


def _apart(level: Levels, corners: Indices) -> NDArray[np.bool_]:
    """Mark the triangles (k,), by their corners (3, k), that do not lie on one level."""
    a, b, c = level.take(corners)
    apart: NDArray[np.bool_] = (a != b) | (b != c)
    return apart


def _cut(places: Array, level: Levels, corners: Indices) -> tuple[Whole, Array, Array]:
    """Return plane, first and third place of the segments in which planes cut triangles, corners (3, k).

    Every plane meets the edge from a triangle's lowest to its highest corner, and one of the others: places
    on an edge are reckoned from its lower end for both of its triangles.
    """
    (low, middle, high), turned = _by_height(places[1], corners)
    x, y, z = places.take(np.concatenate([low, low, middle]), axis=1)
    u, v, w = places.take(np.concatenate([high, middle, high]), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):  # no plane meets an edge that lies in one
        slope_x, slope_z = (u - x) / (v - y), (w - z) / (v - y)
    first, bend, last = level.take([low, middle, high])
    which, plane = _expanded(first.astype(np.int64), last - first)
    other = which + np.where(plane < bend.take(which), 1, 2) * len(first)
    ends = []
    for edge in (other, which):
        up = plane - y.take(edge)
        ends.append((x.take(edge) + up * slope_x.take(edge), z.take(edge) + up * slope_z.take(edge)))
    (x0, z0), (x1, z1) = ends
    met = np.flatnonzero((np.ceil(x0) != np.ceil(x1)) | (np.ceil(z0) != np.ceil(z1)))
    swapped = turned.take(which.take(met))
    first_and_third = (np.stack([one.take(met), other.take(met)]) for one, other in ((x0, x1), (z0, z1)))
    across, along = (np.where(swapped, both[::-1], both) for both in first_and_third)
    return plane.take(met), across, along


def _by_height(height: Array, corners: Indices) -> tuple[list[Indices], NDArray[np.bool_]]:
    """Return the corners (3, k) of triangles by height, and a mark of those whose sense that turns (k,)."""
    numbers, heights = list(corners), list(height.take(corners))
    turned = np.zeros(corners.shape[1], dtype=bool)
    for one, other in ((0, 1), (1, 2), (0, 1)):
        swap = heights[one] > heights[other]
        turned ^= swap
        for values in (numbers, heights):
            a, b = values[one], values[other]
            values[one], values[other] = np.where(swap, b, a), np.where(swap, a, b)
    return numbers, turned


def _expanded(first: Whole, count: Whole | Levels) -> tuple[Indices, Whole]:
    """Return the numbers of runs of whole numbers one after the other: the run of each, and the number."""
    which = np.repeat(np.arange(len(first)), count)
    before = np.cumsum(count, dtype=np.int64) - count
    return which, np.arange(len(which)) + (first - before).take(which)


def _stretches(plane: Whole, across: Array, along: Array, columns: int, depth: int) -> tuple[Whole, Array]:
    """Follow rays that are at whole numbers across, through segments with start and end (2, k).

    Returns
    -------
    times : (n,) int
        Excess of metal's count over one, or its negative, on stretches of rays where it is wrong.
    ends : (2, n, 3) float
        Their two ends: across, plane and along, in pitches.
    """
    scale = ((1 << DEPTH_BITS) - 1) / depth
    event = _crossings(plane, across, along, columns, scale)
    event.sort()
    winding = np.cumsum(1 - 2 * (event & 1).astype(np.int8), dtype=np.int32)
    wrong = np.flatnonzero((winding < 0) | (winding > 1))  # each ray ends at 0, where the next one begins
    times = np.where(winding[wrong] > 1, winding[wrong] - 1, -winding[wrong])
    ends = np.stack([event[wrong], event[wrong + 1]])
    row, column = np.divmod(ends >> (DEPTH_BITS + 1), columns)
    return times, np.stack([column, row, ((ends >> 1) & ((1 << DEPTH_BITS) - 1)) / scale], axis=-1)


def _crossings(plane: Whole, across: Array, along: Array, columns: int, scale: float) -> Whole:
    """Return rays' crossings of segments, a number each: the ray, the depth, and 1 where metal is left.

    Segments end where others begin, so that no ray slips between them or meets both.
    """
    begin, end = np.ceil(across).astype(np.int64)
    hit = np.flatnonzero(begin != end)
    begin, end = begin.take(hit), end.take(hit)
    place, column = _expanded(np.minimum(begin, end), np.abs(end - begin))
    hit = hit.take(place)
    (x, u), (z, w) = across.take(hit, axis=1), along.take(hit, axis=1)
    depth = z + (column - x) / (u - x) * (w - z)
    depth = np.clip(depth, np.minimum(z, w), np.maximum(z, w))  # a steep one leaves its ends within rounding
    ray = plane.take(hit) * columns + column
    event: Whole = (ray << (DEPTH_BITS + 1)) | ((depth * scale).astype(np.int64) << 1) | (u < x)
    return event


# Triangles by the stretch of an axis that each covers, ready for many questions.


CELLS = 255
"""Cells of the axis: their numbers fit a byte, so that a million triangles are compared in a fifth of a
millisecond, and in four by their heights."""


@dataclass(frozen=True, eq=False)
class Stretches:
    """The smallest and the largest height (m,) of each triangle [mm]."""

    least: Array
    greatest: Array

    @classmethod
    def of(cls, heights: Array, triangles: Indices) -> Stretches:
        """Return those of triangles (m, 3) between vertices at some heights (n,)."""
        return cls(*least_and_greatest(heights, triangles))

    def within(self, low: float, high: float) -> Indices:
        """Return the rows of triangles that reach above ``low`` and below ``high``, rising."""
        first, last = self._cells
        near = np.flatnonzero((last >= self._cell(low)) & (first <= self._cell(high)))
        inside = (self.greatest.take(near) > low) & (self.least.take(near) < high)
        rows: Indices = near[inside]
        return rows

    @cached_property
    def _scale(self) -> tuple[float, float]:
        """The lowest height, and cells a millimetre."""
        if not len(self.least):
            return 0.0, 0.0
        low, high = float(self.least.min()), float(self.greatest.max())
        return low, CELLS / max(high - low, 1e-300)

    def _cell(self, height: float) -> int:
        """Return the cell of a height, by the arithmetic of the triangles' own: it rises with them."""
        low, scale = self._scale
        return int(min(max((height - low) * scale, 0.0), CELLS))

    @cached_property
    def _cells(self) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        low, scale = self._scale
        first, last = (((each - low) * scale).astype(np.uint8) for each in (self.least, self.greatest))
        return first, last
