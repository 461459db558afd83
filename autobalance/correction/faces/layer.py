"""The metal under a planar face in cross-sections parallel to it, as curves over the depth."""

from __future__ import annotations

import math
from bisect import bisect_right, insort
from collections.abc import Callable
from dataclasses import field
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.measure import Stretches
from autobalance.solid.mesh.mesh import Mesh, compacted, least_and_greatest, longest_sides
from autobalance.solid.slicing.slices import Spans, cross_sections, thinned
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Quantity sampled at some depths and interpolated at all of them, with its integral.


NODES = (5, 9)
"""Samples of a piece, and their number where that is too few: every other one must predict those between."""
CHECK_SHARE = 1e-5
"""Permitted error of these predictions, as a share of the largest: all samples are far nearer."""
ROUGH_CHECK_SHARE = 1e-3
"""The same of a rough surface, which no polynomial follows closer; what a cut takes of it is measured."""
SPLITS = 3
"""Largest number of splits of a piece with larger errors, as at a kink."""


@dataclass(frozen=True, eq=False)
class _Rule:
    """A number of samples at Chebyshev's places, from −1 to 1; every other one is a smaller rule's too.

    ``fit`` makes coefficients of samples; ``check`` predicts the samples between every other one from these.
    """

    places: Array
    fit: Array
    check: Array

    @classmethod
    def of(cls, nodes: int) -> _Rule:
        places = -np.cos(np.pi * np.arange(nodes) / (nodes - 1))
        coarse = _fitted(places[::2])
        return cls(places, _fitted(places), chebyshev.chebvander(places[1::2], nodes // 2) @ coarse)


def _fitted(places: Array) -> Array:
    """Return the matrix from samples at as many places to Chebyshev coefficients."""
    fit: Array = np.linalg.inv(chebyshev.chebvander(places, len(places) - 1)).astype(np.float64)
    return fit


_RULES = tuple(_Rule.of(nodes) for nodes in NODES)


@dataclass(frozen=True, eq=False)
class _Piece:
    start: float
    end: float
    value: Array
    """Chebyshev coefficients (k, n) over the piece."""
    integral: Array
    """Chebyshev coefficients of the antiderivative, zero at depth 0."""

    def place(self, depth: float) -> float:
        """Return the place of a depth, from −1 at the start to 1 at the end."""
        return (2.0 * depth - self.start - self.end) / (self.end - self.start)


class DepthCurve:
    """A vector of numbers over the depths from 0 to a largest one, in pieces of Chebyshev polynomials.

    Parameters
    ----------
    sample : callable
        Takes a depth and returns the vector (n,) there; called from shallow to deep within a piece.
    least, most : float
        Depths between which to sample, 0 <= least < most; above ``least`` the first piece continues.
    scale : (n,) float
        Scale of the components' errors.
    breaks : (k,) float
        Depths at which the curve may have a kink.
    share : float
        Permitted error of samples that were left out, as a share of the scale.
    """

    def __init__(
        self,
        sample: Callable[[float], Array],
        least: float,
        most: float,
        scale: Array,
        breaks: Array,
        share: float = CHECK_SHARE,
    ) -> None:
        self._sample, self._permitted = sample, share * scale
        self._breaks = breaks
        self._pieces: list[_Piece] = []
        self._add(least, most, SPLITS)

    def _add(self, start: float, end: float, splits: int) -> None:
        middle, half = 0.5 * (start + end), 0.5 * (end - start)
        sampled: dict[float, Array] = {}
        for rule in _RULES:
            depths = [start, *(middle + half * float(place) for place in rule.places[1:-1]), end]
            sampled |= {depth: self._sample(depth) for depth in depths if depth not in sampled}
            exact = np.stack([sampled[depth] for depth in depths])
            off = np.abs(rule.check @ exact[::2] - exact[1::2])
            if is_close := bool((off <= self._permitted).all()):
                break
        if splits and not is_close:
            inner = self._breaks[np.abs(self._breaks - middle) < 0.5 * half]
            if len(inner):
                middle = float(inner[np.argmin(np.abs(inner - middle))])
            self._add(start, middle, splits - 1)
            self._add(middle, end, splits - 1)
            return
        value = rule.fit @ exact
        integral: Array = half * chebyshev.chebint(value, lbnd=-1.0).astype(np.float64)
        if self._pieces:
            integral[0] += self._pieces[-1].integral.sum(axis=0)  # all the polynomials are 1 at 1
        else:
            integral[0] -= _at(-middle / half, integral)  # nothing at depth zero
        self._pieces.append(_Piece(start, end, value, integral))

    def _piece(self, depth: float) -> _Piece:
        return next((piece for piece in self._pieces if depth <= piece.end), self._pieces[-1])

    def value(self, depth: float) -> Array:
        piece = self._piece(depth)
        return _at(piece.place(depth), piece.value)

    def integral(self, depth: float) -> Array:
        """Return the integral of the vector from zero to a depth."""
        piece = self._piece(depth)
        return _at(piece.place(depth), piece.integral)


def _at(place: float, coefficients: Array) -> Array:
    """Return the values (n,) of Chebyshev series (k, n) at a place from −1 to 1."""
    values: Array = chebyshev.chebvander(np.array([place]), len(coefficients) - 1)[0] @ coefficients
    return values


# The metal under a planar face, seen in cross-sections parallel to it.
#
# A cross-section costs a thousandth of a boolean, and between the heights of neighbouring vertices its
# moments are polynomials in the depth. So the cut of a face is planned on sections alone, and the solid is
# cut once.


SAME_FACE_AREA_SHARE = 0.01
"""Share of the metal just under a face and in a sector over which the face lies if it is there at all."""
MAX_NORMAL_COMPONENT = -0.5
"""A surface counts as the next one behind the face if its normal has at most this component along the face's.
Side walls that lean back a little are not a wall behind the face (ours)."""
ABOVE_AND_BELOW = 3
"""Bit 1: a triangle with a corner above the lower height of a slab; bit 2: with one below the upper."""
IN_LINE = 1.0 / 32.0
"""Share of the grain by which a corner of a section may be out of line and be left out. A cut face's area
changes by a millionth at most, while the time of booleans grows with the number of corners."""
SAME_AXIS = 1.0 - 1e-6
"""Cosine of two faces' normals, up to sign, from which on the heights of triangles along one serve both."""
MIN_COSINE = 1.0 - 1e-5
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
        """Return the triangles that reach into low..high after ``frame`` (4, 4) has placed the mesh."""
        rows = _near(mesh, frame[2], low_mm, high_mm)
        used, numbers = compacted(mesh.triangles.take(rows, axis=0), len(mesh.vertices))
        vertices = mesh.vertices.take(np.flatnonzero(used), axis=0)
        z = vertices @ frame[2, :3] + frame[2, 3]
        sides = (z > low_mm).view(np.uint8) | (z < high_mm).view(np.uint8) << 1
        a, b, c = sides.take(numbers).T
        reaches = np.flatnonzero((a | b | c) == ABOVE_AND_BELOW)
        rows, part = rows.take(reaches), Mesh(vertices, numbers).at(reaches).moved(frame)
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
        return np.flatnonzero(self.leans >= MIN_COSINE * self.areas)

    @cached_property
    def backward(self) -> Indices:
        """The rows of triangles that face backward."""
        return np.flatnonzero(self.leans <= MAX_NORMAL_COMPONENT * self.areas)

    def is_thick(self, rows: Indices) -> NDArray[np.bool_]:
        """Return whether triangles are not slivers lower than rounding, which face nowhere (j,)."""
        thick: NDArray[np.bool_] = self.areas.take(rows) > self.grain_mm * longest_sides(self.corners(rows))
        return thick

    def thick(self, rows: Indices) -> Indices:
        """Return the triangles of ``rows`` without slivers."""
        chosen: Indices = rows[self.is_thick(rows)]
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
        """The vertices (k, 3) that have no higher neighbour."""
        z = self.vertices[:, 2]
        highest = np.full(len(z), -math.inf)
        for corner in self.numbers.T:
            np.maximum.at(highest, corner, self.tops)
        return self.vertices[highest <= z]

    @cached_property
    def saddle_heights_mm(self) -> Array:
        """Heights of vertices where the surface is not a simple slope: its sections join or divide there.

        Around a vertex of a slope lie two triangles in which it is the middle vertex by height. Around a
        summit or the bottom of a hollow the number is zero, around a saddle four or more. Equal heights count
        in turn.
        """
        by_height = np.argsort(self.vertices[:, 2], kind="stable")
        rank = np.zeros(len(by_height), dtype=np.int64)
        rank[by_height] = np.arange(len(by_height))
        a, b, c = rank.take(self.numbers).T
        middle = a + b + c - np.minimum(np.minimum(a, b), c) - np.maximum(np.maximum(a, b), c)
        heights: Array = self.vertices[by_height[np.bincount(middle, minlength=len(rank)) > 2], 2]
        return heights


_SEEN: WeakKeyDictionary[Mesh, tuple[Array, Stretches]] = WeakKeyDictionary()


def _near(mesh: Mesh, row: Array, low_mm: float, high_mm: float) -> Indices:
    """Return the triangles that may reach into low..high after ``row`` (4,) of a frame has placed the mesh.

    Faces of webs are square to one axis, nearly: heights along it are kept, and others searched with the
    difference that the directions make.
    """
    direction, size = row[:3], float(np.abs(mesh.bounds).max())
    seen = _SEEN.get(mesh)
    cosine = 0.0 if seen is None else float(seen[0] @ direction)
    if seen is None or abs(cosine) < SAME_AXIS:
        seen = direction.copy(), Stretches.of(mesh.vertices @ direction, mesh.triangles)
        _SEEN[mesh], cosine = seen, 1.0
    axis, stretches = seen
    sign = math.copysign(1.0, cosine)
    slack = 2.0 * size * float(np.abs(sign * direction - axis).sum()) + 1e-9 * size
    low, high = low_mm - float(row[3]) - slack, high_mm - float(row[3]) + slack
    if sign < 0.0:
        low, high = -high, -low
    return stretches.within(low, high)


@dataclass(eq=False)
class FaceLayer:
    """Metal connected to a face, section by section.

    Attributes
    ----------
    section : callable
        Takes a height in the face's frame and returns the crank's cross-section there.
    height_mm : float
        Of the face.
    outline : Region
        The face itself.
    standing : Region
        Footprint of metal on the face: the tool keeps from under it.
    room : Region
        Area open to the tool.
    within : Solid or None
        The part of space to which the cut keeps, in the face's frame.
    grain_mm : float
        Lengths below it are rounding.
    rough_mm : float
        Of a scanned face: its waves reach down to here, and sections show the holes between them; the section
        at this depth stands for those above it.
    """

    section: Callable[[float], Region]
    height_mm: float
    outline: Region
    standing: Region
    room: Region
    within: Solid | None
    grain_mm: float
    rough_mm: float = 0.0
    _depths: list[float] = field(default_factory=list)
    _kept: dict[float, Region] = field(default_factory=dict)
    _spared: dict[float, Region] = field(default_factory=dict)

    @property
    def holds_its_face(self) -> bool:
        """Whether metal connected to the face lies under it within, and not only beside it."""
        first = self.kept(self.grain_mm)
        if first.is_empty or self.within is None:
            return not first.is_empty
        inside = self.outline & self.within.section(self.height_mm)
        return inside.area_mm2 > SAME_FACE_AREA_SHARE * first.area_mm2

    def kept(self, depth_mm: float) -> Region:
        """Return the section at a depth of the metal connected to the face."""
        depth_mm = max(depth_mm, self.rough_mm)
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
        """Return the shadow of other metal down to a depth: of every section seen, and of the last."""
        depth_mm = max(depth_mm, self.rough_mm)
        self.kept(depth_mm)
        shadow = Region.of([])
        for depth in self._depths:
            if depth <= depth_mm and not self._spared[depth].is_empty:
                shadow = shadow + self._spared[depth]
        return shadow if shadow.is_empty else shadow.grown(self.grain_mm)

    def taken(self, depth_mm: float) -> Region:
        """Return the shadow of metal connected to the face, in every section seen and the last."""
        depth_mm = max(depth_mm, self.rough_mm)
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
        if self.rough_mm == 0.0:
            return DepthCurve(at, self.grain_mm, most_mm, scale, breaks_mm)
        breaks = np.append(breaks_mm, self.rough_mm)
        return DepthCurve(at, 0.0, most_mm, scale, breaks, ROUGH_CHECK_SHARE)


def plane_moments(region: Region, z_mm: float) -> Moments:
    """Return ∫ (1, r, r rᵀ) dA over a region that lies at a height."""
    area, first, second = region.area_moments()
    second3 = np.zeros((3, 3))
    second3[:2, :2] = second
    second3[:2, 2] = second3[2, :2] = first * z_mm
    second3[2, 2] = area * z_mm * z_mm
    return Moments(area, np.array([*first, area * z_mm]), second3)


def moments_scale(region: Region, z_mm: float) -> Array:
    """Return the scale (13,) of the moments of a region and of those like it."""
    length = max(float(np.abs(region.bounds).max()), abs(z_mm))
    return region.area_mm2 * np.concatenate([[1.0], np.full(3, length), np.full(9, length**2)])


def numbers_of(moments: Moments) -> Array:
    """Return moments as numbers (13,)."""
    return np.concatenate([[moments.mass_g], moments.first_g_mm, moments.second_g_mm2.reshape(-1)])


def moments_of(numbers: Array) -> Moments:
    """Return the moments of numbers (13,), as `numbers_of` returns them."""
    return Moments(float(numbers[0]), numbers[1:4], numbers[4:].reshape(3, 3))
