"""Triangles over a plane region, and the number of them that share more than an area with it."""

# Needed by a crank whose equal faces got depths of 9.1, 14.2 and 18.3 mm, the last through its main journal:
# a summit over a wall lies on a section's outline, where rounding decided whether it was inside.

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalance.solid.csg.region import Region
from autobalance.solid.slicing.raster import Raster
from autobalance.types import Array, Indices

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
