"""Pairing of triangles at edges shared by more than two, in meshes that touch themselves."""

# Needed by files of two bodies that lie against each other, as tests/geometry/test_solid_pinched.py draws.

from __future__ import annotations

import numpy as np

from autobalance.solid.mesh.adjacency import sides_of
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Flags, Indices

SAME_RAD = 1e-6
"""Directions about an edge that are one: faces that lie against each other."""


def linked_triangles(mesh: Mesh) -> Indices:
    """Return the pairs of triangles (k, 2) between which the inside of a closed, outward mesh lies.

    At most edges there are just two. Where parts touch along an edge there are more; of these, two belong
    together that follow each other about the edge with the inside between them. Faces that lie against each
    other have nothing between them and stay apart.
    """
    if mesh.twins is not None:
        return mesh.twins.T.astype(np.int64) // 3
    sides = sides_of(mesh.triangles)
    pairs = [np.stack(sides.of_two, axis=1) // 3]
    crowded = sides.count > 2
    for at, many in zip(sides.first[crowded], sides.count[crowded], strict=True):
        around = sides.order[at : at + many]
        runs_up = sides.start[around] < sides.end[around]
        angle = _angles(mesh, around, runs_up)
        pairs.append(around[_wedges(angle, runs_up)] // 3)
    return np.concatenate(pairs)


def _angles(mesh: Mesh, sides: Indices, runs_up: Flags) -> Array:
    """Return the direction of triangles about their common edge (k,) [rad]; ``sides`` are 3 t + corner."""
    triangle, corner = mesh.triangles[sides // 3], sides % 3
    row = np.arange(len(sides))
    begin, end, apex = (mesh.vertices[triangle[row, (corner + k) % 3]] for k in range(3))
    low, high = (begin[0], end[0]) if runs_up[0] else (end[0], begin[0])
    along = (high - low) / np.linalg.norm(high - low)
    away = apex - low
    away = away - np.outer(away @ along, along)
    x = away[0] / (np.linalg.norm(away[0]) or 1.0)
    y = np.cross(along, x)
    angles: Array = np.arctan2(away @ y, away @ x)
    return angles


def _wedges(angle: Array, runs_up: Flags) -> Indices:
    """Return pairs (k, 2) of places: from a triangle that runs down, about the edge, to one that runs up.

    Outward triangles that run up the edge have the inside before them, those that run down behind them.
    """
    order = np.argsort(np.mod(np.where(runs_up, angle - SAME_RAD, angle), 2.0 * np.pi), kind="stable")
    depth = np.cumsum(np.where(runs_up[order], -1, 1))
    order = np.roll(order, -(int(depth.argmin()) + 1))  # begins outside of every wedge
    begun: list[int] = []
    wedges = []
    for place in order.tolist():
        if not runs_up[place]:
            begun.append(place)
        elif begun:
            wedges.append((begun.pop(), place))
    return np.array(wedges, dtype=np.int64).reshape(-1, 2)
