"""What hangs together: connected components of many nodes, without a loop over them."""

from __future__ import annotations

import numpy as np

from autobalance.solid.mesh import Indices


def components(links: Indices, count: int) -> Indices:
    """Return for each node the lowest node of its connected component (count,).

    Every link hangs its higher ends under its lowest; then roots that links still join are hung under one
    another until none is left. Numbers that follow the surface, as a weld gives them, need a few rounds.

    Parameters
    ----------
    links : (k, m) int
        Nodes that belong together, m at a time: the triangles of a mesh, or pairs.
    count : int
        Nodes in all, numbered from 0.
    """
    root = np.arange(count)
    columns = [np.ascontiguousarray(column) for column in links.T]
    while len(columns[0]):
        low = columns[0]
        for column in columns[1:]:
            low = np.minimum(low, column)
        for column in columns:
            above = np.flatnonzero(column > low)
            root[column.take(above)] = low.take(above)  # of several lower ones any will do
        while not np.array_equal(higher := root.take(root), root):
            root = higher
        ends = [root.take(column) for column in columns]
        apart = np.zeros(len(low), dtype=bool)
        for end in ends[1:]:
            apart |= end != ends[0]
        rows = np.flatnonzero(apart)
        columns = [end.take(rows) for end in ends]
    return root


def numbered_components(links: Indices, count: int) -> tuple[Indices, int]:
    """Return for each node the number of its component (count,), from 0 by the lowest node; and how many."""
    lowest = components(links, count)
    is_lowest = lowest == np.arange(count)
    number = np.cumsum(is_lowest) - 1
    return number[lowest], int(is_lowest.sum())
