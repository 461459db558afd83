"""The metal under a planar face, seen in cross-sections parallel to it.

A cross-section costs a thousandth of a boolean, and between the heights of neighbouring vertices its moments
are polynomials in the depth. So the cut of a face is planned on sections alone, and the
solid is cut once.
"""

from __future__ import annotations

import math
from bisect import bisect_right, insort
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from autobalance.correction.curve import DepthCurve
from autobalance.correction.kind import Array
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.solid import Region, Solid
from autobalance.solid.mesh.mesh import Indices, Mesh, least_and_greatest, longest_sides
from autobalance.solid.slicing.raster import Raster
from autobalance.solid.slicing.slices import Spans, cross_sections, thinned

BACKWARD = -0.5
"""A surface counts as the next one behind the face if its normal has at most this component along the face's:
side walls that lean back a little are no wall behind the face (ours)."""
ABOVE_AND_BELOW = 3
"""Of a triangle with a corner above the lower height of a slab, bit 1, and one below the upper, bit 2."""
IN_LINE = 1.0 / 32.0
"""Share of the grain by which a corner of a section may be out of line and be left out: a cut face's area
changes by a millionth at most, while booleans take as long as there are corners."""
FLAT = 1.0 - 1e-5
"""Triangles whose normal has at least this component along the face's are planes that face the same way."""


@dataclass(frozen=True, eq=False)
class Layer:
    """The triangles of a solid between two heights over a face's frame, with their directions.

    Attributes
    ----------
    vertices : (n, 3) float
        In the face's frame [mm].
    numbers : (k, 3) int
        The triangles' vertices.
    bottoms, tops : (k,) float
        Heights of their lowest and highest corners [mm].
    areas, leans : (k,) float
        Twice their areas, and the components of their doubled area vectors along the face's normal [mm²].
    grain_mm : float
        Lengths below it are rounding.
    """

    vertices: Array
    numbers: Indices
    bottoms: Array
    tops: Array
    areas: Array
    leans: Array
    grain_mm: float

    @classmethod
    def of(cls, mesh: Mesh, frame: Array, low_mm: float, high_mm: float, grain_mm: float) -> Layer:
        """Pick the triangles that reach into low..high once ``frame`` (4, 4) has placed the mesh."""
        z = mesh.vertices @ frame[2, :3] + frame[2, 3]
        sides = (z > low_mm).view(np.uint8) | (z < high_mm).view(np.uint8) << 1
        a, b, c = sides.take(mesh.triangles).T
        picked = (a | b | c) == ABOVE_AND_BELOW
        rows, part = np.flatnonzero(picked), mesh.part(picked).moved(frame)
        bottoms, tops = least_and_greatest(part.vertices[:, 2], part.triangles)
        return cls(
            vertices=part.vertices,
            numbers=part.triangles,
            bottoms=bottoms,
            tops=tops,
            areas=mesh.doubled_areas.take(rows),
            leans=mesh.area_vectors.take(rows, axis=0) @ frame[2, :3],
            grain_mm=grain_mm,
        )

    def corners(self, rows: Indices) -> Array:
        """Return the corners (j, 3, 3) of some triangles."""
        return self.vertices.take(self.numbers.take(rows, axis=0), axis=0)

    @cached_property
    def upward(self) -> Indices:
        """The rows of triangles that lie on planes that face the same way."""
        return np.flatnonzero(self.leans >= FLAT * self.areas)

    @cached_property
    def backward(self) -> Indices:
        """The rows of triangles that face backward."""
        return np.flatnonzero(self.leans <= BACKWARD * self.areas)

    def thick(self, rows: Indices) -> Indices:
        """Return those of some triangles that are no slivers lower than rounding, which face nowhere."""
        longest = longest_sides(self.corners(rows))
        chosen: Indices = rows[self.areas.take(rows) > self.grain_mm * longest]
        return chosen

    def section(self, height_mm: float) -> Region:
        """Return the solid's cross-section at a height within the slab."""
        crossing = np.flatnonzero((self.bottoms < height_mm) & (self.tops >= height_mm))
        met = Spans(np.zeros(len(crossing), np.uint8), np.ones(len(crossing), np.uint8))
        numbers = self.numbers.take(crossing, axis=0)
        outlines = cross_sections(self.vertices, numbers, np.array([height_mm]), met)[0]
        return Region.of(thinned(outline, IN_LINE * self.grain_mm) for outline in outlines)

    @cached_property
    def summits(self) -> Array:
        """The vertices (k, 3) that have no higher neighbour, by falling height."""
        z = self.vertices[:, 2]
        highest = np.full(len(z), -math.inf)
        for corner in self.numbers.T:
            np.maximum.at(highest, corner, self.tops)
        alone = self.vertices[highest <= z]
        return alone[np.argsort(-alone[:, 2])]


@dataclass(eq=False)
class FaceLayer:
    """What hangs together with a face, section by section.

    Attributes
    ----------
    section : callable
        Takes a height in the face's frame and returns the crank's cross-section there.
    height_mm : float
        Of the face.
    outline : Region
        The face itself.
    room : Region
        Where the tool may be: not under what stands on the face.
    within : Solid or None
        The part of space to which the cut keeps, in the face's frame.
    grain_mm : float
        Lengths below it are rounding.
    """

    section: Callable[[float], Region]
    height_mm: float
    outline: Region
    room: Region
    within: Solid | None
    grain_mm: float
    _depths: list[float] = field(default_factory=list)
    _kept: dict[float, Region] = field(default_factory=dict)
    _spared: dict[float, Region] = field(default_factory=dict)

    def kept(self, depth_mm: float) -> Region:
        """Return the section at a depth of the metal that hangs together with the face."""
        if depth_mm in self._kept:
            return self._kept[depth_mm]
        place = bisect_right(self._depths, depth_mm)
        above = self._kept[self._depths[place - 1]] if place else self.outline
        section = self.section(self.height_mm - depth_mm) & self.room
        if self.within is not None:
            section = section & self.within.section(self.height_mm - depth_mm)
        kept: list[Region] = []
        spared: list[Region] = []
        low, high = above.bounds
        for piece in section.pieces():
            begin, end = piece.bounds
            beside = above.is_empty or (begin >= high).any() or (end <= low).any()
            hangs = not beside and (piece & above).area_mm2 > self.grain_mm**2
            (kept if hangs else spared).append(piece)
        insort(self._depths, depth_mm)
        self._kept[depth_mm] = Region.beside_each_other(kept)
        self._spared[depth_mm] = Region.beside_each_other(spared)
        return self._kept[depth_mm]

    def spared(self, depth_mm: float) -> Region:
        """Return the shadow of other metal down to a depth: of every section looked at, and of the last."""
        self.kept(depth_mm)
        shadow = Region.of([])
        for depth in self._depths:
            if depth <= depth_mm and not self._spared[depth].is_empty:
                shadow = shadow + self._spared[depth]
        return shadow if shadow.is_empty else shadow.grown(self.grain_mm)

    def taken(self, depth_mm: float) -> Region:
        """Return the shadow of what hangs together with the face, in every section looked at and the last."""
        shadow = self.outline + self.kept(depth_mm)
        for depth in self._depths:
            if depth <= depth_mm:
                shadow = shadow + self._kept[depth]
        return shadow

    def section_moments(self, depth_mm: float) -> Moments:
        """Return ∫ (1, r, r rᵀ) dA over the section at a depth, in the face's frame."""
        return plane_moments(self.kept(depth_mm), self.height_mm - depth_mm)

    def curve(self, most_mm: float, breaks_mm: Array) -> DepthCurve:
        """Return the section's moments, as numbers (13,), over the depths down to ``most_mm``."""

        def at(depth: float) -> Array:
            return numbers_of(self.section_moments(depth))

        scale = moments_scale(self.outline, self.height_mm)
        return DepthCurve(at, self.grain_mm, most_mm, scale, breaks_mm)

    # --- where the depth ends -------------------------------------------------------------------------------

    def step_depth_mm(self, slab: Layer, deepest_mm: float) -> float | None:
        """Return the depth at which another plane that faces the same way joins the section, if any does."""
        tops = slab.tops
        below = (tops > self.height_mm - deepest_mm) & (tops < self.height_mm - 2.0 * self.grain_mm)
        planes = slab.thick(slab.upward[below.take(slab.upward)])
        depth_of = self.height_mm - tops.take(planes)
        for depth in np.unique(np.round(depth_of / self.grain_mm)) * self.grain_mm:
            corners = slab.corners(planes[np.abs(depth_of - depth) <= self.grain_mm])[:, :, :2]
            floor_mm2 = 0.5 * float(_doubled_areas(corners).sum())
            kept = self.kept(float(depth) + 2.0 * self.grain_mm)
            if Cover(kept, corners).area_over(JOINED * floor_mm2) is not None:
                return float(depth)
        return None

    def merge_depth_mm(self, slab: Layer, deepest_mm: float) -> float | None:
        """Return the depth at which another raised part becomes one with the section, if one does.

        From there on that part hangs together with the face, all of it: the removed metal would jump.
        """
        summits = slab.summits
        summits = summits[self.height_mm - summits[:, 2] > 2.0 * self.grain_mm]

        def joined(depth: float) -> bool:
            apart = summits[self.height_mm - summits[:, 2] < depth - 2.0 * self.grain_mm]
            return bool(self.kept(depth).contains(apart[:, :2]).any())

        if not len(summits) or not joined(deepest_mm):
            return None
        free, merged = 0.0, deepest_mm
        while merged - free > self.grain_mm:
            middle = 0.5 * (free + merged)
            free, merged = (free, middle) if joined(middle) else (middle, merged)
        return free

    def back_height_mm(self, slab: Layer, lowest_mm: float, deepest_mm: float) -> float | None:
        """Return the height of the next surface behind the cut, if there is one above ``lowest_mm``."""
        tops = slab.tops
        below = (tops > lowest_mm) & (tops < self.height_mm - 2.0 * self.grain_mm)
        rows = slab.thick(slab.backward[below.take(slab.backward)])
        rows = rows[np.argsort(-tops[rows])]
        if not len(rows):
            return None
        over = np.clip(self.height_mm - tops[rows] - 2.0 * self.grain_mm, self.grain_mm, deepest_mm)
        first = np.linspace(self.grain_mm, over[0], SECTIONS_ABOVE)
        later = over[(np.linspace(0.0, 1.0, SECTIONS_BELOW, endpoint=False) ** 2 * len(over)).astype(int)]
        depths = np.unique(np.concatenate([first, later]))
        group = np.searchsorted(depths, over, side="right") - 1
        cut = Region.of([])
        for number, depth in enumerate(depths.tolist()):
            cut = cut + self.kept(depth)
            some = rows[group == number]
            count = Cover(cut, slab.corners(some)[:, ::-1, :2]).area_over(self.grain_mm**2)
            if count is not None:
                return float(tops[some[count - 1]])
        return None


SECTIONS_ABOVE, SECTIONS_BELOW = 4, 16
"""Of the metal to be cut, over all that faces backward and beside it: together they make the shadow in which
a surface lies behind the cut."""
CUT_MOST = 1000
"""Triangles on the outline of a region that are cut to it to know the area they share with it."""
CELLS_LEAST, CELLS_MOST = 64, 1024
"""Of the grid on which triangles are told apart: about as small as they are."""


@dataclass(frozen=True, eq=False)
class Cover:
    """Triangles (k, 3, 2), counter-clockwise and side by side, over a region."""

    region: Region
    corners: Array

    def area_over(self, area_mm2: float) -> int | None:
        """Return how many of the triangles, from the first, share more than an area with the region.

        Only those near its outline must be cut to it; of many small ones, corners and middle tell.
        """
        if self.region.is_empty or not len(self.corners):
            return None
        cells = min(max(int(2.0 * len(self.corners) ** 0.5), CELLS_LEAST), CELLS_MOST)
        raster, boxes = Raster.of(self.region.polygons, cells), _boxes(self.corners)
        met = np.flatnonzero(raster.meets(*boxes))
        held = raster.holds(*(box[met] for box in boxes))
        areas = 0.5 * _doubled_areas(self.corners[met])
        enough = int(np.searchsorted(np.cumsum(np.where(held, areas, 0.0)), area_mm2, side="right")) + 1
        edge = np.flatnonzero(~held[:enough])
        if len(edge) <= CUT_MOST:
            count = self._count(met, np.where(held, areas, 0.0), edge, area_mm2)
        else:
            share = held.astype(np.float64)
            share[edge] = self._inside(met[edge])
            count = int(np.searchsorted(np.cumsum(share * areas), area_mm2, side="right")) + 1
        return int(met[count - 1]) + 1 if count <= len(met) else None

    def _inside(self, rows: Indices) -> Array:
        """Return about which share of triangles lies inside."""
        corners = self.corners[rows]
        points = np.concatenate([corners, corners.mean(axis=1, keepdims=True)], axis=1)
        inside = self.region.contains(points.reshape(-1, 2)).reshape(-1, 4)
        share: Array = inside.mean(axis=1)
        return share

    def _count(self, met: Indices, surely: Array, edge: Indices, area_mm2: float) -> int:
        """Return how many of the triangles ``met`` share more than an area, those on the ``edge`` cut."""
        total = np.cumsum(surely)

        def over(count: int) -> bool:
            cut = Region.of(list(self.corners[met[edge[: np.searchsorted(edge, count)]]])) & self.region
            return float(total[count - 1]) + cut.area_mm2 > area_mm2

        few, many = 0, min(int(np.searchsorted(total, area_mm2, side="right")) + 1, len(met))
        if not many or not over(many):
            return len(met) + 1
        while many - few > 1:
            middle = (few + many) // 2
            few, many = (few, middle) if over(middle) else (middle, many)
        return many


def _boxes(corners: Array) -> tuple[Array, Array]:
    """Return the least and greatest coordinates (k, 2) of triangles (k, 3, 2)."""
    a, b, c = corners.transpose(1, 0, 2)
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def _doubled_areas(corners: Array) -> Array:
    """Return twice the areas (k,) of plane triangles (k, 3, 2), counter-clockwise."""
    a, b, c = corners.transpose(1, 0, 2)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    areas: Array = ux * vy - uy * vx
    return areas


def plane_moments(region: Region, z_mm: float) -> Moments:
    """Return ∫ (1, r, r rᵀ) dA over a region that lies at a height."""
    area, first, second = region.area_moments()
    second3 = np.zeros((3, 3))
    second3[:2, :2] = second
    second3[:2, 2] = second3[2, :2] = first * z_mm
    second3[2, 2] = area * z_mm * z_mm
    return Moments(area, np.array([*first, area * z_mm]), second3)


def moments_scale(region: Region, z_mm: float) -> Array:
    """Return the size (13,) of what the moments of a region, and of those like it, are added up from."""
    length = max(float(np.abs(region.bounds).max()), abs(z_mm))
    return region.area_mm2 * np.concatenate([[1.0], np.full(3, length), np.full(9, length**2)])


def numbers_of(moments: Moments) -> Array:
    """Return moments as numbers (13,)."""
    return np.concatenate([[moments.mass_g], moments.first_g_mm, moments.second_g_mm2.reshape(-1)])


def moments_of(numbers: Array) -> Moments:
    """Return the moments that numbers (13,) stand for."""
    return Moments(float(numbers[0]), numbers[1:4], numbers[4:].reshape(3, 3))


JOINED = 1e-3
"""A plane has joined the section when more than this share of it lies inside."""
