"""Largest depth to which a planar face may be lowered, and its limit.

The shallowest of these counts:

- the reach of the search, or the job's ``max_depth_mm``.
- the wall to leave in front of the next surface behind the cut.
- another plane that faces the same way and joins the section, whose area would jump there.
- another raised part that becomes one with the section, so that all of it would be removed from there on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.correction.faces.cover import Cover, doubled_areas
from autobalance.correction.faces.layer import FaceLayer, Layer
from autobalance.quantities import mm, said
from autobalance.solid.csg.region import Region
from autobalance.types import Array, Indices

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
