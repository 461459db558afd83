"""Largest depth to which a planar face may be lowered, its limit, and the pins that end its cut."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.faces.layer import FaceLayer, Layer
from autobalance.correction.faces.patches import MIN_AXIAL_COMPONENT
from autobalance.crank.anatomy import Anatomy, Pin
from autobalance.quantities import mm, said
from autobalance.solid.csg.region import Region
from autobalance.solid.slicing.independent import Raster
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Triangles over a plane region, and the number of them that share more than an area with it.


# Needed by a crank whose equal faces got depths of 9.1, 14.2 and 18.3 mm, the last through its main journal:
# a summit over a wall lies on a section's outline, where rounding decided whether it was inside.


CUT_MOST = 1000
"""Largest number of triangles on a region's outline that are cut to it for their common area."""
CELLS_LEAST, CELLS_MOST = 64, 1024
"""Cells of the grid on which triangles are distinguished: about as small as they are."""


@dataclass(frozen=True, eq=False)
class Cover:
    """Triangles (k, 3, 2), counter-clockwise and side by side, over a region."""

    region: Region
    corners: Array

    def area_over(self, area_mm2: float) -> int | None:
        """Return the number of first triangles with more than an area in the region; None: all have less.

        Only those near its outline must be cut to it; of many small ones, corners and middle are enough.
        """
        if self.region.is_empty or not len(self.corners):
            return None
        cells = min(max(int(2.0 * len(self.corners) ** 0.5), CELLS_LEAST), CELLS_MOST)
        raster, (low, high) = Raster.of(self.region.polygons, cells), _boxes(self.corners)
        least, greatest = self.region.bounds
        met = np.flatnonzero(((low < greatest) & (high > least)).all(axis=1))
        met = met[raster.meets(low[met], high[met])]
        held = raster.holds(low[met], high[met])
        areas = 0.5 * doubled_areas(self.corners[met])
        enough = int(np.searchsorted(np.cumsum(np.where(held, areas, 0.0)), area_mm2, side="right")) + 1
        edge = np.flatnonzero(~held[:enough])
        if len(edge) <= CUT_MOST:
            count = self._count(met, np.where(held, areas, 0.0), edge, area_mm2)
        else:
            share = held.astype(np.float64)
            share[edge] = self._inside(met[edge])
            count = int(np.searchsorted(np.cumsum(share * areas), area_mm2, side="right")) + 1
        return int(met[count - 1]) + 1 if count <= len(met) else None

    def held(self) -> NDArray[np.bool_]:
        """Return whether each triangle surely lies inside (k,)."""
        if self.region.is_empty or not len(self.corners):
            return np.zeros(len(self.corners), dtype=bool)
        return Raster.of(self.region.polygons).holds(*_boxes(self.corners))

    def _inside(self, rows: Indices) -> Array:
        """Return the approximate share of each triangle inside (k,)."""
        corners = self.corners[rows]
        points = np.concatenate([corners, corners.mean(axis=1, keepdims=True)], axis=1)
        inside = self.region.contains(points.reshape(-1, 2)).reshape(-1, 4)
        share: Array = inside.mean(axis=1)
        return share

    def _count(self, met: Indices, surely: Array, edge: Indices, area_mm2: float) -> int:
        """Return the number of triangles ``met`` with more than an area inside, those on the ``edge`` cut."""
        total = np.cumsum(surely)

        def cut(few: int, many: int) -> float:
            """Return the area inside of those on the edge from one number of triangles to another."""
            some = met[edge[slice(*np.searchsorted(edge, (few, many)))]]
            return (Region.of(list(self.corners[some])) & self.region).area_mm2 if len(some) else 0.0

        few, many = 0, min(int(np.searchsorted(total, area_mm2, side="right")) + 1, len(met))
        if not many:
            return len(met) + 1
        before, last = cut(0, many - 1), cut(many - 1, many)
        if float(total[many - 1]) + before + last <= area_mm2:
            return len(met) + 1
        if many == 1 or float(total[many - 2]) + before <= area_mm2:
            return many  # mostly the first that lies inside for sure
        inside = 0.0  # they lie side by side, so that areas of further ones add
        while many - few > 1:
            middle = (few + many) // 2
            more = cut(few, middle)
            if float(total[middle - 1]) + inside + more > area_mm2:
                many = middle
            else:
                few, inside = middle, inside + more
        return many


def _boxes(corners: Array) -> tuple[Array, Array]:
    """Return the least and largest coordinates (k, 2) of triangles (k, 3, 2)."""
    a, b, c = corners.transpose(1, 0, 2)
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def doubled_areas(corners: Array) -> Array:
    """Return twice the areas (k,) of plane triangles (k, 3, 2), counter-clockwise."""
    a, b, c = corners.transpose(1, 0, 2)
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    areas: Array = ux * vy - uy * vx
    return areas


# Largest depth to which a planar face may be lowered, and its limit.
#
# The shallowest of these counts:
#
# - the reach of the search, or the job's ``max_depth_mm``.
# - the wall to leave in front of the next surface behind the cut.
# - another plane that faces the same way and joins the section, whose area would jump there.
# - another raised part that becomes one with the section, so that all of it would be removed from there on.


JOINED_AREA_SHARE = 1e-3
"""A plane has joined the section when more than this share of it lies inside."""
AT_A_TIME = 512
"""Triangles compared with a shadow at a time, the highest first, then four times as many."""
SECTIONS_ABOVE, SECTIONS_BELOW = 4, 16
"""Sections of the metal to be cut, over all that faces backward beside the face and among it: together they
make the shadow in which a surface lies behind the cut."""
UNDER_SADDLE = 3.0
"""Grains under a saddle at which the parts that meet there are seen to be one: a rise of less than two grains
over a section counts for no part."""


@dataclass(frozen=True)
class DepthLimit:
    """Largest depth, its limit in words, and whether that is only the reach of the search."""

    depth_mm: float
    reason: str
    is_reach: bool = False

    def or_sooner(self, depth_mm: float | None, reason: str) -> DepthLimit:
        """Return the shallower of this and another end, if there is another."""
        return self if depth_mm is None or depth_mm >= self.depth_mm else DepthLimit(depth_mm, reason)


def depth_limit(layer: FaceLayer, slab: Layer, reach: DepthLimit, wall_mm: float) -> DepthLimit:
    """Return the largest depth to which a face may be lowered, and its limit.

    Parameters
    ----------
    layer : FaceLayer
    slab : Layer
        The triangles under it, down to the reach and a wall more.
    reach : DepthLimit
        Largest depth of the search.
    wall_mm : float
        Metal to leave in front of the next surface behind the cut.
    """
    search = _Search(layer, slab)
    wall = said("the wall of {} behind it", mm(wall_mm, ".3g"))
    straight = search.depth_straight_under_mm(reach.depth_mm + wall_mm)
    limit = reach if straight is None else reach.or_sooner(straight - wall_mm, wall)
    for sought, reason in (
        (search.step_mm, "the height of the shoulder over the next plane"),
        (search.merge_mm, "another raised part beside the face"),
    ):
        if limit.depth_mm > 2.0 * layer.grain_mm:
            limit = limit.or_sooner(sought(limit.depth_mm), reason)
    if limit.depth_mm > 2.0 * layer.grain_mm:
        beside = search.depth_beside_mm(limit.depth_mm, wall_mm)
        limit = limit if beside is None else limit.or_sooner(beside - wall_mm, wall)
    return limit


@dataclass(frozen=True, eq=False)
class _Search:
    """Search for limits of a cut among the triangles of a slab; depths from the face [mm]."""

    layer: FaceLayer
    slab: Layer

    def _among(self, rows: Indices, deepest_mm: float) -> Indices:
        """Return the triangles of ``rows`` whose tops lie under the face, above a depth."""
        depth = self.layer.height_mm - self.slab.tops.take(rows)
        chosen: Indices = rows[(depth > 2.0 * self.layer.grain_mm) & (depth < deepest_mm)]
        return chosen

    # --- surfaces behind the cut ----------------------------------------------------------------------------

    def depth_straight_under_mm(self, deepest_mm: float) -> float | None:
        """Return the depth of the next surface straight under the face."""
        rows = self._backward(deepest_mm)
        first = self._first_behind(self.layer.kept(self.layer.grain_mm), rows)
        return None if first is None else self._depth_mm(rows[first])

    def depth_beside_mm(self, deepest_mm: float, wall_mm: float) -> float | None:
        """Return the depth of the next surface behind metal that is cut, down to a depth, beside the face.

        Where metal widens under the face, sections show it, each for the surfaces below it.
        """
        layer = self.layer
        rows = self._within_room(self._backward(deepest_mm + wall_mm))
        if not len(rows):
            return None
        over = layer.height_mm - self.slab.tops[rows] - 2.0 * layer.grain_mm
        over = np.clip(over, layer.grain_mm, deepest_mm)
        first = np.linspace(layer.grain_mm, over[0], SECTIONS_ABOVE)
        later = over[(np.linspace(0.0, 1.0, SECTIONS_BELOW, endpoint=False) ** 2 * len(over)).astype(int)]
        depths = np.unique(np.concatenate([first, later]))
        group = np.searchsorted(depths, over, side="right") - 1
        shadow = Region.of([])
        for number, depth in enumerate(depths.tolist()):
            shadow = shadow + layer.kept(depth)
            some = rows[group == number]
            behind = self._first_behind(shadow, some)
            if behind is not None:
                return self._depth_mm(some[behind])
        return None

    def _backward(self, deepest_mm: float) -> Indices:
        """Return the triangles above a depth that face backward, the highest first."""
        rows = self._among(self.slab.backward, deepest_mm)
        highest: Indices = rows[np.argsort(-self.slab.tops.take(rows), kind="stable")]
        return highest

    def _within_room(self, rows: Indices) -> Indices:
        """Return the triangles of ``rows``, high to low, that may reach beyond what is on the face."""
        if not len(rows):
            return rows
        corners = self._seen(rows)
        around = Region.rectangle(corners.min(axis=(0, 1)).tolist(), corners.max(axis=(0, 1)).tolist())
        first = self._first_behind(self.layer.room & around, rows)
        if first is None:
            return rows[:0]
        rows = self.slab.thick(rows[first:])
        within: Indices = rows[~Cover(self.layer.standing, self._seen(rows)).held()]
        return within

    def _first_behind(self, shadow: Region, rows: Indices) -> int | None:
        """Return the index of the first triangle with which ``rows`` lie behind a shadow; else None."""
        begin, some = 0, AT_A_TIME
        while begin < len(rows):
            chosen = np.arange(begin, min(begin + some, len(rows)))
            chosen = chosen[self.slab.is_thick(rows[chosen])]
            count = Cover(shadow, self._seen(rows[chosen])).area_over(self.layer.grain_mm**2)
            if count is not None:
                return int(chosen[count - 1])
            begin, some = begin + some, 4 * some
        return None

    def _seen(self, rows: Indices) -> Array:
        """Return the corners (k, 3, 2) of triangles that face backward, seen from the face."""
        return self.slab.corners(rows)[:, ::-1, :2]

    def _depth_mm(self, row: int) -> float:
        return float(self.layer.height_mm - self.slab.tops[row])

    # --- where the section would jump -----------------------------------------------------------------------

    def step_mm(self, deepest_mm: float) -> float | None:
        """Return the depth just above another plane that faces the same way and joins the section."""
        layer, slab = self.layer, self.slab
        planes = slab.thick(self._among(slab.upward, deepest_mm))
        depth_of = layer.height_mm - slab.tops.take(planes)
        for depth in np.unique(np.round(depth_of / layer.grain_mm)) * layer.grain_mm:
            corners = slab.corners(planes[np.abs(depth_of - depth) <= layer.grain_mm])[:, :, :2]
            floor_mm2 = 0.5 * float(doubled_areas(corners).sum())
            kept = layer.kept(float(depth) + 2.0 * layer.grain_mm)
            if Cover(kept, corners).area_over(JOINED_AREA_SHARE * floor_mm2) is not None:
                return float(depth) - layer.grain_mm
        return None

    def merge_mm(self, deepest_mm: float) -> float | None:
        """Return the largest depth at which no other raised part is one with the section.

        Parts of a section meet where the surface has a saddle, so sections just under saddles show at which,
        and one just above it confirms that. Parts that the tool's room keeps apart may meet elsewhere; then
        the interval is halved.
        """
        if not self._is_merged(deepest_mm):
            return None
        grain = self.layer.grain_mm
        free, merged = 0.0, deepest_mm
        under = np.unique(self.layer.height_mm - self.slab.saddle_heights_mm) + UNDER_SADDLE * grain
        while len(under := under[(under > free) & (under < merged)]):
            free, merged = self._narrowed(free, merged, float(under[len(under) // 2]))
        over = max(merged - (UNDER_SADDLE + 1.0) * grain, free)
        free, merged = self._narrowed(free, merged, over)
        while free < over and merged - free > grain:
            free, merged = self._narrowed(free, merged, 0.5 * (free + merged))
        return free

    def _narrowed(self, free_mm: float, merged_mm: float, depth_mm: float) -> tuple[float, float]:
        """Return the part of an interval, divided at a depth, in which the parts become one."""
        return (free_mm, depth_mm) if self._is_merged(depth_mm) else (depth_mm, merged_mm)

    def _is_merged(self, depth_mm: float) -> bool:
        """Return whether at a depth the section holds the place of a summit apart from the face."""
        depths = self.layer.height_mm - self.slab.summits[:, 2]
        grain = self.layer.grain_mm
        apart = self.slab.summits[(depths > 2.0 * grain) & (depths < depth_mm - 2.0 * grain), :2]
        if not len(apart):
            return False
        around = self.layer.kept(depth_mm).grown(2.0 * grain)  # many stand over a wall, on its outline
        return bool(around.contains(apart).any())


# Pins beside a face that looks across the crank: its cut ends before it bites into them.


# Needed by the generated twin: named sides of its webs could be lowered 18 mm, 9 mm of that through the main
# journal, since a pin beside the web stands out nowhere over the face.


BARE_PIN_SHARE = 0.98
"""Share of a pin's radius and length that is surely its own: no fillet, no web."""


def clear_of_pins(layer: FaceLayer, to_face: Array, anatomy: Anatomy, limit: DepthLimit) -> DepthLimit:
    """Return the depth limit of a face whose cut must not bite into a pin; the other one if that is sooner.

    Pins are on faces that look along the axis, or lie behind the wall: those are left as they are. A pin
    whose axis lies above the face is on it too; of one that the face cuts through, nothing may be taken.

    Parameters
    ----------
    layer : FaceLayer
    to_face : (4, 4)
        Turns the rotor frame to the face's.
    anatomy : Anatomy
    limit : DepthLimit
        Limit of the cut otherwise.
    """
    along = abs(float(to_face[2, 2]))
    if along >= MIN_AXIAL_COMPONENT:
        return limit
    for name, pin in _pins(anatomy):
        axis = float(to_face[2, :3] @ pin.centre_mm)
        top = axis + 0.5 * (pin.diameter_mm * math.sqrt(1.0 - along**2) + pin.width_mm * along)
        sooner = limit.or_sooner(max(layer.height_mm - top, 0.0), f"the surface of {name}")
        if layer.height_mm > axis and sooner is not limit:
            bitten = layer.taken(limit.depth_mm) & _footprint(pin, to_face)
            limit = limit if bitten.is_empty else sooner
    return limit


def _pins(anatomy: Anatomy) -> Iterator[tuple[str, Pin]]:
    for journal in anatomy.main_journals:
        yield f"main journal {journal.number}", journal
    for throw in anatomy.throws:
        yield f"crankpin {throw.number}", throw.crankpin


def _footprint(pin: Pin, to_face: Array) -> Region:
    """Return a pin's bare cylinder as seen from the face: a rectangle."""
    ends = pin.centre_mm + 0.5 * BARE_PIN_SHARE * pin.width_mm * np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    low, high = ends @ to_face[:2, :3].T
    ahead = (high - low) / float(np.linalg.norm(high - low))
    aside = 0.5 * BARE_PIN_SHARE * pin.diameter_mm * np.array([-ahead[1], ahead[0]])
    return Region.of([np.array([low - aside, high - aside, high + aside, low + aside])])
