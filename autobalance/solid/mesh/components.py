"""Connected components of many nodes, without a loop over them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from autobalance.types import Indices


def components(links: Indices, count: int) -> Indices:
    """Return the lowest node of each node's component (count,); see ``numbered_components``."""
    number, lowest = _numbered(links, count)
    return lowest.take(number)


def numbered_components(links: Indices, count: int) -> tuple[Indices, int]:
    """Return the number of each node's component (count,), from 0 by the lowest node; and their count.

    Parameters
    ----------
    links : (k, m) int
        Nodes that belong together, m at a time: the triangles of a mesh, or pairs.
    count : int
        Nodes in all, numbered from 0.
    """
    number, lowest = _numbered(links, count)
    return number, len(lowest)


def _numbered(links: Indices, count: int) -> tuple[Indices, Indices]:
    """Return the number of each node's component (count,) and the lowest node of each component.

    Every node hangs under the lowest that a link joins it to; connected nodes are one node of the next round,
    until no link joins two. Numbers that follow the surface, as a weld gives them, need a few rounds.
    """
    number = lowest = np.arange(count)
    columns = [np.ascontiguousarray(column) for column in links.T]
    while len(columns[0]):
        low = columns[0]
        for column in columns[1:]:
            low = np.minimum(low, column)
        root = np.arange(len(lowest))
        for column in columns:
            np.minimum.at(root, column, low)
        while not np.array_equal(higher := root.take(root), root):
            root = higher
        is_root = root == np.arange(len(root))
        joined = (np.cumsum(is_root) - 1).take(root)
        number, lowest = joined.take(number), lowest[is_root]
        ends = [joined.take(column) for column in columns]
        apart = np.zeros(len(low), dtype=bool)
        for end in ends[1:]:
            apart |= end != ends[0]
        left = np.flatnonzero(apart)
        columns = [end.take(left) for end in ends]
    return number, lowest
