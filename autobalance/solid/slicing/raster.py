"""Grid of cells over a plane region, to sort many boxes at once into inside and outside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.solid.csg.region import Polygons
from autobalance.types import Array, Flags, Indices

CELLS = 256
"""Cells of the grid along the longer side of the region."""


@dataclass(frozen=True, eq=False)
class Raster:
    """Cells over a region and one ring around it: wholly inside, wholly outside, or near its outline.

    Attributes
    ----------
    origin : (2,) float
        Corner of the grid [mm].
    cell_mm : float
        Side of a cell.
    inside, touched : (n + 1, m + 1) int
        Number of cells before a row and a column that are wholly inside, and that are not wholly outside.
    """

    origin: Array
    cell_mm: float
    inside: Indices
    touched: Indices

    @classmethod
    def of(cls, polygons: Polygons, cells: int = CELLS) -> Raster:
        """Draw closed outlines (k, 2), holes clockwise, on a grid."""
        corners = np.concatenate(polygons)
        ends = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons])
        low, high = corners.min(axis=0), corners.max(axis=0)
        cell = float((high - low).max()) / cells or 1.0
        origin = low - 2.0 * cell
        shape = tuple((np.ceil((high - low) / cell).astype(int) + 5).tolist())
        start, end = (corners - origin) / cell, (ends - origin) / cell
        near = _near(start, end, shape)
        filled = _filled(start, end, shape)
        return cls(origin, cell, _summed(filled & ~near), _summed(filled | near))

    def holds(self, low: Array, high: Array) -> Flags:
        """Mark the boxes (k,) between corners (k, 2) that lie inside for sure."""
        first, last = self._cells(low), self._cells(high)
        inside = (low >= self.origin).all(axis=1) & (last < np.array(self.inside.shape) - 1).all(axis=1)
        size = np.prod(last - first + 1, axis=1)
        held: Flags = inside & (self._count(self.inside, first, last) == size)
        return held

    def meets(self, low: Array, high: Array) -> Flags:
        """Mark the boxes (k,) between corners (k, 2) that may reach inside: others are outside for sure."""
        first, last = self._cells(low), self._cells(high)
        met: Flags = self._count(self.touched, first, last) > 0
        return met

    def _cells(self, points: Array) -> Indices:
        """Return the cell (k, 2) of each point, beyond the grid the nearest one in line with it."""
        cells = np.floor((points - self.origin) / self.cell_mm).astype(np.int64)
        return np.clip(cells, 0, np.array(self.inside.shape) - 1)

    @staticmethod
    def _count(table: Indices, first: Indices, last: Indices) -> Indices:
        (x0, y0), (x1, y1) = first.T, np.minimum(last.T + 1, np.array(table.shape)[:, None] - 1)
        counted: Indices = table[x1, y1] - table[x0, y1] - table[x1, y0] + table[x0, y0]
        return counted


def _summed(flags: Flags) -> Indices:
    """Return the number of flags set before each row and column (n + 1, m + 1)."""
    table = np.zeros((flags.shape[0] + 1, flags.shape[1] + 1), dtype=np.int64)
    table[1:, 1:] = flags.cumsum(axis=0).cumsum(axis=1)
    return table


def _near(start: Array, end: Array, shape: tuple[int, ...]) -> Flags:
    """Mark the cells within one cell of an outline: points along it mark themselves and their neighbours."""
    steps = np.ceil(2.0 * np.abs(end - start).max(axis=1)).astype(np.int64) + 1
    which = np.repeat(np.arange(len(steps)), steps)
    number = np.arange(len(which)) - np.repeat(np.cumsum(steps) - steps, steps)
    share = (number / steps.take(which))[:, None]
    x, y = np.floor(start[which] + share * (end - start)[which]).astype(np.int64).T
    on = np.zeros(shape, dtype=bool)
    on[x, y] = True
    for near in (on, on.T):  # the ring around the region keeps the grid's ends free
        beside = near[1:] | near[:-1]
        near[1:] |= beside
        near[:-1] |= beside
    return on


def _filled(start: Array, end: Array, shape: tuple[int, ...]) -> Flags:
    """Mark the cells whose middles lie inside: left of each lies an outline that goes up more than down."""
    y0, y1 = start[:, 1], end[:, 1]
    first, last = (np.ceil(each(y0, y1) - 0.5).astype(np.int64) for each in (np.minimum, np.maximum))
    rows = last - first
    which = np.repeat(np.arange(len(rows)), rows)
    row = np.arange(len(which)) + np.repeat(first - (np.cumsum(rows) - rows), rows)
    share = (row + 0.5 - y0.take(which)) / (y1 - y0).take(which)
    x = start[which, 0] + share * (end - start)[which, 0]
    column = np.clip(np.ceil(x - 0.5).astype(np.int64), 0, shape[0] - 1)
    cell, weight = column * shape[1] + row, np.where(y1.take(which) > y0.take(which), -1.0, 1.0)
    turns = np.bincount(cell, weight, shape[0] * shape[1]).reshape(shape)
    filled: Flags = turns.cumsum(axis=0) > 0.0
    return filled
