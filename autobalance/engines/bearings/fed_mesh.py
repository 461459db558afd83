"""Finite volumes of a developed bush with feeds: cells, their conductances, forces of their pressures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csc_array

from autobalance.engines.bearings.film import JournalBearing
from autobalance.engines.bearings.oil_feeds import Feed
from autobalance.types import Array


@dataclass(frozen=True, eq=False)
class Mesh:
    """Cells of the developed bush; half the length, counted twice, where all feeds lie in its middle."""

    bearing: JournalBearing
    feeds: tuple[Feed, ...]
    edges: Array
    """Angles of the lines along (n + 1,), the last one a turn after the first."""
    angle: Array
    """Angles of the cells' middles (n,)."""
    cosine: Array
    """∫cos θ dθ over each cell (n,)."""
    sine: Array
    ends: Array
    """Places z of the lines around (m + 1,)."""
    halves: float
    """2 where only half the length has cells, else 1."""
    feed_at: npt.NDArray[np.int_]
    """Number of the feed in which a cell lies (n, m), −1: none."""

    @classmethod
    def of(cls, bearing: JournalBearing, feeds: tuple[Feed, ...], grid: tuple[int, int]) -> Mesh:
        """Return the cells, about as many around and along as requested."""
        half = 0.5 * bearing.length_m
        mirrored = all(feed.z_m == 0.0 for feed in feeds)
        around = _lines(
            [
                feed.angle_rad + side * 0.5 * feed.width_rad
                for feed in feeds
                for side in (-1.0, 1.0)
                if not feed.is_ring
            ],
            grid[0],
        )
        along = [feed.z_m + side * 0.5 * feed.length_m for feed in feeds for side in (-1.0, 1.0)]
        low, cells = (0.0, grid[1] // 2) if mirrored else (-half, grid[1])
        ends = _divided(sorted({low, *(z for z in along if z > low), half}), cells)
        angle, place = 0.5 * (around[:-1] + around[1:]), 0.5 * (ends[:-1] + ends[1:])
        feed_at = np.full((len(angle), len(place)), -1)
        for number, feed in enumerate(feeds):
            for j, z in enumerate(place):
                if abs(z - feed.z_m) < 0.5 * feed.length_m:
                    feed_at[[feed.covers(float(each), float(z)) for each in angle], j] = number
        cosine, sine = np.diff(np.sin(around)), -np.diff(np.cos(around))
        return cls(bearing, feeds, around, angle, cosine, sine, ends, 2.0 if mirrored else 1.0, feed_at)

    @property
    def place(self) -> Array:
        """Places z of the cells' middles (m,)."""
        return 0.5 * (self.ends[:-1] + self.ends[1:])

    @property
    def breadth(self) -> Array:
        """Length along of the cells (m,), twice if the other half has no cells."""
        return self.halves * np.diff(self.ends)

    @property
    def unknown(self) -> npt.NDArray[np.int_]:
        """Number of the unknown of each cell (n, m): feeds first, then each cell between them."""
        free = self.feed_at < 0
        numbers = np.where(free, 0, self.feed_at)
        numbers[free] = len(self.feeds) + np.arange(int(free.sum()))
        return numbers

    def summed(self, cells: Array) -> Array:
        """Return values of cells (n, m) summed over each unknown."""
        return np.asarray(np.bincount(self.unknown.ravel(), weights=cells.ravel()), dtype=np.float64)

    def force(self, pressure: Array) -> Array:
        """Return the force on the journal (2,) of pressures (n, m)."""
        lines = pressure @ self.breadth * self.bearing.radius_m
        return np.array([-lines @ self.cosine, -lines @ self.sine])


def _lines(edges: list[float], cells: int) -> Array:
    """Return the angles of the lines along over one turn, through all edges of feeds."""
    turn = 2.0 * math.pi
    if not edges:
        return np.linspace(0.0, turn, cells + 1)
    first = edges[0]
    inside = sorted({round((each - first) % turn, 12) for each in edges} - {0.0})
    return first + _divided([0.0, *(each for each in inside if each < turn - 1e-9), turn], cells)


def _divided(marks: Sequence[float], cells: int) -> Array:
    """Return lines through all marks, some ``cells`` steps in all, at least two between any two."""
    whole = marks[-1] - marks[0]
    parts = [
        np.linspace(low, high, max(2, math.ceil(cells * (high - low) / whole)), endpoint=False)
        for low, high in pairwise(marks)
    ]
    return np.append(np.concatenate(parts), marks[-1])


@dataclass(frozen=True, eq=False)
class Conductances:
    """Outflow of each unknown by all pressures, ``matrix`` (k, k), and ``out`` (k,) of it at the ends."""

    matrix: csc_array
    out: Array


def conductances(mesh: Mesh, at_edges: Array, at_cells: Array) -> Conductances:
    """Return the conductances of flows h³/(12 η), given at the lines along (n,) and the cells (n,)."""
    numbers, land = mesh.unknown, (mesh.feed_at < 0).astype(np.float64)
    turn, radius = np.diff(mesh.edges), mesh.bearing.radius_m
    deep = 0.5 * radius * turn[:, None] * land  # a feed's pressure reaches its edge
    around = _over(at_edges[:, None] * mesh.breadth, deep + np.roll(deep, -1, axis=0))
    inward = 0.5 * np.diff(mesh.ends) * land
    strip = mesh.halves * at_cells[:, None] * radius * turn[:, None]
    along = _over(np.broadcast_to(strip, land[:, 1:].shape), inward[:, :-1] + inward[:, 1:])
    total = int(numbers.max()) + 1
    pairs = [
        (numbers.ravel(), np.roll(numbers, -1, axis=0).ravel(), around.ravel()),
        (numbers[:, :-1].ravel(), numbers[:, 1:].ravel(), along.ravel()),
    ]
    rows, columns, values = [], [], []
    for one, other, conductance in pairs:
        apart = one != other
        a, b, g = one[apart], other[apart], conductance[apart]
        rows += [a, b, a, b]
        columns += [a, b, b, a]
        values += [g, g, -g, -g]
    outer = [-1] if mesh.halves == 2.0 else [0, -1]  # in the middle of the length nothing flows
    out = np.zeros(total)
    for j in outer:
        np.add.at(out, numbers[:, j], (strip[:, 0] / inward[:, j]))
    everyone = np.arange(total)
    matrix = coo_array(
        (
            np.concatenate([*values, out]),
            (np.concatenate([*rows, everyone]), np.concatenate([*columns, everyone])),
        ),
        shape=(total, total),
    )
    return Conductances(csc_array(matrix), out)


def _over(breadth: Array, distance: Array) -> Array:
    """Return breadth over distance, 0 inside a feed, which has no distance and no flow."""
    return np.divide(breadth, distance, out=np.zeros(distance.shape), where=distance > 0.0)
