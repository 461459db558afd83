"""Open edges of a mesh: those that no two triangles share, and the rims that they make."""

from __future__ import annotations

import numpy as np

from autobalance.solid.mesh.mesh import hash_numbers
from autobalance.solid.mesh.tetrahedra import CHUNK
from autobalance.types import Array, Indices


def is_closed(triangles: Indices) -> bool:
    """Return whether triangles (m, 3) run through each edge equally often in both directions.

    By sums of a hash of the edges, one for each direction: no sorting, and wrong once in 2⁶⁴ times.
    """
    count = int(triangles.max(initial=0)) + 1
    balance = np.zeros(1, dtype=np.uint64)
    for begin in range(0, len(triangles), CHUNK):
        start = np.ascontiguousarray(triangles[begin : begin + CHUNK].T)
        end = start[[1, 2, 0]]
        key = hash_numbers(np.minimum(start, end) * count + np.maximum(start, end))
        balance += np.where(start < end, key, ~key + np.uint64(1)).sum()  # two's complement: less the key
    return not balance.any()


def open_edges(triangles: Indices) -> Indices:
    """Return the edges (k, 2) that are not run through equally often in both directions."""
    if is_closed(triangles):  # as usual
        return np.zeros((0, 2), dtype=np.int64)
    start, end = triangles.reshape(-1), triangles[:, [1, 2, 0]].reshape(-1)
    key = np.minimum(start, end) * (int(triangles.max()) + 1) + np.maximum(start, end)
    upward = start < end
    ordered = np.sort(2 * key + upward)  # an edge and its twins stand side by side
    edge, sense = ordered >> 1, 2 * (ordered & 1) - 1
    first = np.flatnonzero(np.diff(edge, prepend=-1))
    unbalanced = edge.take(first[np.add.reduceat(sense, first) != 0])
    place = np.searchsorted(unbalanced, key).clip(max=len(unbalanced) - 1)
    rows = np.flatnonzero(unbalanced.take(place) == key)
    bad = rows[np.unique(key.take(rows), return_index=True)[1]]
    return np.stack([start[bad], end[bad]], axis=1)


def rims(edges: Indices) -> list[Indices]:
    """Chain the reversed open edges (k, 2) to closed loops; a rim that touches itself falls into several."""
    following: dict[int, list[int]] = {}
    for start, end in edges.tolist():
        following.setdefault(end, []).append(start)
    loops: list[Indices] = []
    for first in list(following):
        path, seen = [first], {first: 0}
        while following.get(path[-1]):
            at = following[path[-1]].pop()
            if at in seen:  # a loop closes here: take it off the path
                loop, path = path[seen[at] :], path[: seen[at] + 1]
                for corner in loop[1:]:
                    del seen[corner]
                if len(loop) > 2:
                    loops.append(np.array(loop, dtype=np.int64))
            else:
                seen[at] = len(path)
                path.append(at)
    return loops


def doubled_area_vector(rim: Array) -> Array:
    """Return twice the area within a closed rim (k, 3), along its normal."""
    local = rim - rim.mean(axis=0)
    vector: Array = np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)
    return vector
