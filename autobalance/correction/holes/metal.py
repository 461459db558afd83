"""The metal that is missing in the round holes of a crank, from their walls and bottoms."""

# Needed by the section table of drilled cranks, whose rows add up only with the missing metal listed.

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from autobalance.correction.holes.bores import Bore, find_bores
from autobalance.correction.holes.surface import Surface, edge_pairs
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.mesh.components import components
from autobalance.solid.mesh.measure import soup_moments
from autobalance.types import Array, Indices

MOUTHS_OF_A_BORE = 2
"""A bore's wall has two ends: both are mouths of a through hole, one of a blind one."""


@dataclass(frozen=True, eq=False)
class HoleMetal:
    """A round hole and the metal that would fill it.

    Attributes
    ----------
    diameter_mm : float
    direction : "radial" or "axial"
    through : bool
    filling : Moments
        Of metal that fills it to its mouth, at density 1, in the rotor frame: its mass is the volume [mm³].
    """

    diameter_mm: float
    direction: str
    through: bool
    filling: Moments


def holes_of(surface: Surface) -> Iterator[HoleMetal]:
    """Yield the round holes of a crank that run towards its axis, or along it.

    Parameters
    ----------
    surface : Surface
        The whole boundary, in the rotor frame. Holes whose wall ends in other than two rims (cross-drilled
        ones) are left out.
    """
    pairs = np.stack(edge_pairs(surface.vertex), axis=1)
    for direction in ("axial", "radial"):
        for bore in find_bores(surface, direction):
            rims = _rims(surface.vertex, bore.rows)
            if len(rims) != MOUTHS_OF_A_BORE:
                continue
            bottom, mouths = _bottom(surface, pairs, bore, rims)
            soup = surface.corners[np.concatenate([bore.rows, bottom])][:, ::-1]
            caps = [_cap(surface, rim, bore) for rim in mouths]
            filling = soup_moments(np.concatenate([soup, *caps]), 1.0)
            if filling.mass_g > 0.0:
                yield HoleMetal(2.0 * bore.radius_mm, direction, len(mouths) == MOUTHS_OF_A_BORE, filling)


def _edges(vertex: Indices) -> Indices:
    edges: Indices = vertex[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    return edges


def _rims(vertex: Indices, rows: Indices) -> list[Indices]:
    """Return the directed edges (k, 2) of each closed rim of a patch of triangles."""
    edges = _edges(vertex[rows])
    inside = {(int(a), int(b)) for a, b in edges}
    rim = np.array([edge for edge in edges if (int(edge[1]), int(edge[0])) not in inside])
    if not len(rim):
        return []
    _, number = np.unique(rim, return_inverse=True)
    links = number.reshape(-1, 2)
    label = components(links, int(links.max()) + 1)[links[:, 0]]
    return [rim[label == each] for each in np.unique(label)]


def _bottom(
    surface: Surface, pairs: Indices, bore: Bore, rims: list[Indices]
) -> tuple[Indices, list[Indices]]:
    """Return the triangles that close a bore at one end, none for a through hole, and the rims left open."""
    wall = np.zeros(len(surface.vertex), dtype=bool)
    wall[bore.rows] = True
    label = components(pairs[~wall[pairs].any(axis=1)], len(surface.vertex))
    owner = np.repeat(np.arange(len(surface.vertex)), 3)
    edges = _edges(surface.vertex)
    sides: list[int] = []
    for rim in rims:
        a, b = rim[0]
        beyond = owner[(edges[:, 0] == b) & (edges[:, 1] == a)]
        sides.append(int(label[beyond[0]]))
    if sides[0] == sides[1]:
        return np.zeros(0, dtype=np.int64), rims
    areas = [float(_area(surface.corners[label == side])) for side in sides]
    closed = int(np.argmin(areas))
    return np.flatnonzero(label == sides[closed]), [rims[1 - closed]]


def _area(corners: Array) -> float:
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * float(np.linalg.norm(cross, axis=1).sum())


def _cap(surface: Surface, rim: Indices, bore: Bore) -> Array:
    """Return triangles (k, 3, 3) that close a mouth, raised as much as the round rim of a web is over it.

    Over a circle of radius r on a cylinder of radius R the surface lies r²/(8 R) above the mean of the mouth;
    a fan from its middle must be raised by three times that.
    """
    start, end = _places(surface, rim)
    middle = start.mean(axis=0)
    outward = bore.outward if float((middle - bore.point_mm) @ bore.outward) > 0.0 else -bore.outward
    height = (start - middle) @ outward
    table = np.column_stack([start - middle, np.ones(len(start))])
    across = table - np.outer(table[:, :3] @ outward, np.append(outward, 0.0))
    level = height - across @ np.linalg.lstsq(across, height, rcond=None)[0]
    apex = middle + 0.75 * float(np.ptp(level)) * outward
    return np.stack([start, end, np.broadcast_to(apex, start.shape)], axis=1)


def _places(surface: Surface, rim: Indices) -> tuple[Array, Array]:
    """Return the starts and ends (k, 3) of a rim's edges."""
    rims, number = np.unique(rim, return_inverse=True)
    flat = surface.vertex.reshape(-1)
    order = np.argsort(flat, kind="stable")
    first = order[np.searchsorted(flat[order], rims)]
    corner = surface.corners.reshape(-1, 3)[first][number.reshape(-1, 2)]
    return corner[:, 0], corner[:, 1]
