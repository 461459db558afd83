"""A solid seen lengthwise: cross-sections at stations along a supposed axis, and their pieces."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np

from autobalance.crank.recognition.circles import Circle, distances, following, hole_circles, whole_circle
from autobalance.solid.mesh.mesh import CHUNK, Mesh, least_and_greatest, rows_where
from autobalance.solid.slicing.slices import Spans, cross_sections
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

MIN_AXIAL_COMPONENT = 1.0 - 1e-4
"""A triangle is square to the axis when its normal has at least this component along it (0.8°)."""
LEVEL_SHARE = 2e-3
"""A height counts as a level, where cross-sections jump, if planes of at least this share of the largest
level's area lie there."""
ASIDE_SHARE = 2e-5
"""Distance of the sections next to a level from it, as a share of the part's length."""
MIN_STATIONS = 40
"""Stations are at most the part's length divided by this apart."""
FLAKE_SHARE = 1e-3
"""Pieces of a rough section below this share of the largest are flakes, cut off a face by a plane."""
UPRIGHT_SINE = 1e-4
"""A triangle is along the axis when the sine of its lean is below this, or its lean is but rounding."""


@dataclass(frozen=True, eq=False)
class SectionPiece:
    """One connected piece of a section: its outline (k, 2), holes, and its outline's circle, if any.

    ``rough_mm`` is the largest distance of a rough surface from a circle; 0 for a drawn one.
    """

    outline: Array
    holes: tuple[Array, ...]
    grain_mm: float
    rough_mm: float = 0.0

    @cached_property
    def circle(self) -> Circle | None:
        """The outline's circle, cut-outs apart; None if it is not round."""
        return whole_circle(self.outline, self.grain_mm, self.rough_mm)

    @cached_property
    def bores_of_holes(self) -> tuple[tuple[Circle, ...], ...]:
        """The circles of each hole; none of one that is not round."""
        return tuple(hole_circles(hole[::-1], self.grain_mm, self.rough_mm) for hole in self.holes)

    @property
    def bores(self) -> tuple[Circle, ...]:
        """Round holes; keyways and other slots in them apart."""
        return tuple(circle for circles in self.bores_of_holes for circle in circles)

    def reach_from(self, centre: Array) -> float:
        """Return the largest distance of the outline from ``centre`` (2,) [mm]."""
        return float(distances(self.outline, centre).max())


@dataclass(frozen=True, eq=False)
class CrossSection:
    """A cross-section at height ``z_mm``."""

    z_mm: float
    pieces: tuple[SectionPiece, ...]


@dataclass(frozen=True, eq=False)
class SectionStack:
    """A mesh turned so that a supposed axis is z, with its levels and sections.

    Attributes
    ----------
    turn : (4, 4) float
        From file coordinates [mm] to these.
    vertices : (n, 3) float
        Turned.
    levels_mm, level_areas_mm2 : (k,) float
        Heights of planes square to the axis, increasing, and the area that lies there.
    sections : tuple of Section
        At increasing heights; between two levels there is at least one.
    blur_mm : float
        Largest distance of levels from the sections that show them; 0 for a drawn surface.
    """

    turn: Array
    vertices: Array
    levels_mm: Array
    level_areas_mm2: Array
    sections: tuple[CrossSection, ...]
    blur_mm: float = 0.0

    @cached_property
    def by_height(self) -> tuple[Array, Array]:
        """Vertices by increasing z, and their z."""
        columns = self.vertices.T.take(np.argsort(self.vertices[:, 2]), axis=1)
        return columns.T, columns[2]

    def between(self, low: float, high: float) -> Array:
        """Return the vertices with low ≤ z ≤ high."""
        vertices, z = self.by_height
        return vertices[np.searchsorted(z, low, side="left") : np.searchsorted(z, high, side="right")]

    def placed(self, point_mm: Array) -> Array:
        """Return a point (3,) of the file in these axes."""
        here: Array = self.turn[:3, :3] @ np.asarray(point_mm, dtype=np.float64) + self.turn[:3, 3]
        return here

    def in_file(self, point_mm: Array) -> Array:
        """Return a point (3,) of these axes in the file's."""
        there: Array = self.turn[:3, :3].T @ (np.asarray(point_mm, dtype=np.float64) - self.turn[:3, 3])
        return there

    @property
    def length_mm(self) -> float:
        """Extent along the axis [mm]."""
        return float(np.ptp(self.vertices[:, 2]))


def lengthwise(mesh: Mesh, direction: Array, rounding_mm: float, rough_mm: float = 0.0) -> SectionStack:
    """Return a mesh with ``direction`` (3,) turned to z, its middle the origin, cut at stations along z.

    Vertices are off by ``rounding_mm``, outlines may be off circles by ``rough_mm``.
    Where nothing changes from one station to the next, one cut serves both.
    """
    turn = turn_to_z(direction, mesh.bounds.mean(axis=0))
    vertices = rotated(mesh.vertices, turn)
    along = mesh.area_vectors @ turn[2, :3]
    off = max(rough_mm, 2.0 * rounding_mm)  # a face's vertices are on both sides of it
    levels, areas = _levels(mesh, vertices, along, off)
    heights = _stations(vertices, levels, off)
    spans = Spans.of(vertices, mesh.triangles, heights)
    stretch = _stretches(mesh, vertices, along, spans, len(heights), rounding_mm)
    first, count = np.unique(stretch, return_index=True, return_counts=True)[1:]
    middle = first + count // 2
    outlines = cross_sections(vertices, mesh.triangles, heights[middle], spans.among(middle))
    pieces = [pieces_of(outline, rounding_mm, rough_mm) for outline in outlines]
    sections = tuple(CrossSection(float(z), pieces[one]) for z, one in zip(heights, stretch, strict=True))
    return SectionStack(turn, vertices, levels, areas, sections)


def straightened(long: SectionStack, mesh: Mesh, direction: Array) -> SectionStack:
    """Return a stack with its axis turned a very little, to ``direction``; the sections are kept."""
    turn = turn_to_z(direction, mesh.bounds.mean(axis=0))
    vertices = rotated(mesh.vertices, turn)
    levels, areas = _levels(mesh, vertices, mesh.area_vectors @ turn[2, :3])
    return SectionStack(turn, vertices, levels, areas, long.sections)


def rotated(vertices: Array, turn: Array) -> Array:
    """Return vertices moved by ``turn``; column by column, which is fastest and the same on any machine."""
    columns = np.zeros((3, len(vertices)))
    for begin in range(0, len(vertices), CHUNK):
        x, y, z = np.ascontiguousarray(vertices[begin : begin + CHUNK].T)
        for column, row in zip(columns, turn[:3], strict=True):
            column[begin : begin + CHUNK] = row[0] * x + row[1] * y + row[2] * z + row[3]
    return columns.T


def turn_to_z(direction: Array, middle: Array) -> Array:
    """Return a rigid motion (4, 4) that takes ``direction`` (3,) to z and ``middle`` (3,) to the origin."""
    z = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    helper = np.eye(3)[int(np.argmin(np.abs(np.round(z, 3))))]
    x = helper - (helper @ z) * z
    x /= np.linalg.norm(x)
    turn = np.eye(4)
    turn[:3, :3] = np.stack([x, np.cross(z, x), z])
    turn[:3, 3] = -turn[:3, :3] @ middle
    return turn


def _stretches(
    mesh: Mesh, vertices: Array, along: Array, spans: Spans, count: int, rounding_mm: float
) -> Indices:
    """Return for each of ``count`` stations the number of its stretch of equal cross-sections.

    Two neighbours show the same section when all triangles between them are along the axis: none leans by
    more than rounding, or shows its face.
    """
    size = mesh.doubled_areas
    facing = rows_where(lambda along, size: np.abs(along) > 0.5 * size, along, size)
    leaning = rows_where(
        lambda along, size: (np.abs(along) > UPRIGHT_SINE * size) & (np.abs(along) <= 0.5 * size), along, size
    )
    lowest, highest = least_and_greatest(vertices[:, 2], mesh.triangles.take(leaning, axis=0))
    rise = highest - lowest
    leaning = leaning[np.abs(along.take(leaning)) * rise > rounding_mm * size.take(leaning)]
    changing = np.concatenate([facing, leaning])
    begins = np.bincount(spans.low.take(changing), minlength=count + 1)
    ends = np.bincount(spans.high.take(changing), minlength=count + 1)
    changes = np.cumsum(begins) - np.cumsum(ends) + ends > 0
    stretch: Indices = np.cumsum(changes[:count]) - int(changes[0])
    return stretch


def _levels(mesh: Mesh, vertices: Array, along: Array, rough_mm: float = 0.0) -> tuple[Array, Array]:
    """Return the heights at which cross-sections jump, and the area of plane faces there.

    Heights of triangles no farther apart than ``rough_mm`` are one level.
    """
    apart = max(ASIDE_SHARE * float(np.ptp(vertices[:, 2])), rough_mm)
    heights, areas = plane_levels(mesh, vertices[:, 2], along, MIN_AXIAL_COMPONENT, apart)
    real = areas > LEVEL_SHARE * areas.max(initial=0.0)
    return heights[real], areas[real]


def plane_levels(mesh: Mesh, height: Array, along: Array, square: float, apart: float) -> tuple[Array, Array]:
    """Return the heights (k,), increasing, at which triangles square to a direction lie, and their area.

    Parameters
    ----------
    mesh : Mesh
    height : (n,) float
        Of the vertices along the direction [mm].
    along : (m,) float
        Components of the triangles' doubled area vectors along it [mm²].
    square : float
        A triangle is square to it when its normal has at least this component along it.
    apart : float
        Triangles no farther apart than this are at one height [mm].
    """
    rows = rows_where(lambda along, doubled: np.abs(along) > square * doubled, along, mesh.doubled_areas)
    at_corner = np.bincount(mesh.triangles[rows, 0], 0.5 * np.abs(along.take(rows)), len(height))
    there = np.flatnonzero(at_corner > 0.0)
    if len(there) == 0:
        return np.zeros(0), np.zeros(0)
    there = there.take(np.argsort(height.take(there)))
    height, area = height.take(there), at_corner.take(there)
    group = np.concatenate([[0], np.cumsum(np.diff(height) > apart)])
    total = np.bincount(group, area).astype(np.float64, copy=False)
    return np.bincount(group, area * height) / total, total


def _stations(vertices: Array, levels: Array, rough_mm: float = 0.0) -> Array:
    """Return heights on both sides of each level, beyond its waves, between levels, and all along."""
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    aside = max(ASIDE_SHARE * (high - low), rough_mm)
    walls = np.unique(np.concatenate([[low], levels, [high]]))
    walls = walls[np.concatenate([[True], np.diff(walls) > 4.0 * aside])]
    heights = [walls - 1.5 * aside, walls + 1.5 * aside]
    for a, b in pairwise(walls):
        count = max(3, int(np.ceil((b - a) / (high - low) * MIN_STATIONS)))
        heights.append(a + (b - a) * (np.arange(count) + 0.5) / count)
    stations = np.unique(np.concatenate(heights))
    return stations[(stations > low) & (stations < high)]


def pieces_of(outlines: list[Array], grain_mm: float, rough_mm: float = 0.0) -> tuple[SectionPiece, ...]:
    """Return the connected pieces of a section, from its outlines."""
    areas = [_area(outline) for outline in outlines]
    most = max((abs(area) for area in areas), default=0.0)
    least = FLAKE_SHARE * most if rough_mm else 1e-9 * most
    real = [(o, a) for o, a in zip(outlines, areas, strict=True) if abs(a) > least]
    solids = sorted((item for item in real if item[1] > 0.0), key=lambda item: item[1])
    holes: list[list[Array]] = [[] for _ in solids]
    for outline, area in real:
        if area < 0.0:
            for place, (around, size) in enumerate(solids):
                if len(solids) == 1 or (size > -area and encloses(around, outline[0])):
                    holes[place].append(outline)
                    break
    return tuple(
        SectionPiece(outline, tuple(inner), grain_mm, rough_mm)
        for (outline, _), inner in zip(solids, holes, strict=True)
    )


def _area(outline: Array) -> float:
    x, y = outline.T
    return 0.5 * float((x * following(y) - y * following(x)).sum())


def encloses(outline: Array, point: Array) -> bool:
    """Return whether a point (2,) lies within a closed outline (k, 2)."""
    a = outline - point
    b = following(a)
    crosses = (a[:, 1] > 0.0) != (b[:, 1] > 0.0)
    a, b = a[crosses], b[crosses]
    x = a[:, 0] - a[:, 1] * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
    return bool(np.count_nonzero(x > 0.0) % 2)
