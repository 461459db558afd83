"""Plane faces of a scanned crank that are square to its axis: located by height, fitted, grown."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from autobalance.crank.recognition.rough_fits import Fit, Region, fit_plane, spread_of
from autobalance.solid.mesh.components import numbered_components
from autobalance.solid.mesh.mesh import Mesh, compacted
from autobalance.types import Array, Indices

MIN_AXIAL_COMPONENT = 0.97
"""A triangle may belong to a plane square to the axis when its smoothed direction has this much along it."""
BIN_MM = 0.05
"""Height of a bin [mm] of the histogram of areas: as high as the least distance that planes may have."""
LEAST_AREA_SHARE = 1.5e-3
"""Planes smaller than this share of the surface are of no use."""
MAX_PLANE_DISTANCE = (4.0, 0.05)
"""A plane's triangles lie within so many times the local roughness, and this much more [mm]."""
MAX_FIT_SIGMAS = 4.0
"""... and of the fitted plane within so many times what its own points spread."""


@dataclass(frozen=True, eq=False)
class RoughPlane:
    """A plane face: the mesh's triangles, its fit in the turned axes, its middle (3,) there and its area."""

    rows: Indices
    fit: Fit
    centroid: Array
    normal: Array
    area_mm2: float

    @property
    def rms_mm(self) -> float:
        """Root mean square of its points' distances from the plane [mm]."""
        return self.fit.rms_mm

    @property
    def flatness_mm(self) -> float:
        """Distance of the two planes that hold 95 % of its area [mm]."""
        order = np.argsort(self.fit.residuals)
        share = np.cumsum(self.fit.weights[order]) / self.fit.weights.sum()
        low, high = np.searchsorted(share, [0.025, 0.975])
        ends = self.fit.residuals[order[[low, min(high, len(order) - 1)]]]
        return float(ends[1] - ends[0])


def rough_planes(
    mesh: Mesh, vertices: Array, directions: Array, at_vertex: Array, local_mm: float
) -> tuple[RoughPlane, ...]:
    """Return the planes square to z of a scanned mesh, the largest first.

    Parameters
    ----------
    mesh : Mesh
    vertices : (n, 3) float
        Its vertices, turned so that the axis is z [mm].
    directions : (m, 3) float
        Smoothed directions of its triangles, turned likewise.
    at_vertex : (n,) float
        Area that each vertex stands for.
    local_mm : float
        Its local roughness.
    """
    area = 0.5 * mesh.doubled_areas
    least = LEAST_AREA_SHARE * float(area.sum())
    thick = MAX_PLANE_DISTANCE[0] * local_mm + MAX_PLANE_DISTANCE[1]
    planes: list[RoughPlane] = []
    for side in (1.0, -1.0):
        rows = np.flatnonzero(side * directions[:, 2] > MIN_AXIAL_COMPONENT)
        if len(rows) == 0:
            continue
        height = vertices[:, 2].take(mesh.triangles.take(rows, axis=0)).mean(axis=1)
        for group in _groups(mesh, rows, height, area.take(rows), thick, least):
            plane = _plane(mesh, vertices, rows, group, area, at_vertex, side)
            if plane is not None and plane.area_mm2 >= least:
                planes.append(plane)
    return tuple(sorted(planes, key=lambda plane: -plane.area_mm2))


def _groups(
    mesh: Mesh, rows: Indices, height: Array, area: Array, thick: float, least: float
) -> Iterator[Indices]:
    """Yield connected triangles (places in ``rows``) about the heights where most area lies."""
    free = np.ones(len(rows), dtype=bool)
    low = float(height.min()) - 1.0
    width = max(1, round(thick / BIN_MM))
    for _ in range(60):
        share = np.bincount(((height - low) / BIN_MM).astype(np.int64), np.where(free, area, 0.0))
        dense = np.convolve(share, np.ones(width), mode="same")
        if float(dense.max(initial=0.0)) < 0.5 * least:
            return
        peak = low + (int(np.argmax(dense)) + 0.5) * BIN_MM
        near = np.flatnonzero(free & (np.abs(height - peak) < thick))
        free[near] = False
        used, corners = compacted(mesh.triangles.take(rows[near], axis=0), len(mesh.vertices))
        number, count = numbered_components(corners, int(used.sum()))
        label = number.take(corners[:, 0])
        size = np.bincount(label, area[near], count)
        for one in np.flatnonzero(size > 0.5 * least):
            yield near[label == one]


def _plane(
    mesh: Mesh, vertices: Array, rows: Indices, group: Indices, area: Array, at_vertex: Array, side: float
) -> RoughPlane | None:
    corners = np.unique(mesh.triangles.take(rows[group], axis=0))
    fit = fit_plane(Region(vertices.take(corners, axis=0), at_vertex.take(corners)))
    if len(fit.points) < 8:
        return None
    inside = np.zeros(len(mesh.vertices), dtype=bool)
    middle = fit.weights @ fit.points / fit.weights.sum()
    off = vertices.take(corners, axis=0) - middle
    away = off[:, 2] - off[:, :2] @ fit.values[1:]
    inside[corners] = np.abs(away) < MAX_FIT_SIGMAS * max(spread_of(fit.residuals), 1e-6)
    members = rows[group][inside.take(mesh.triangles.take(rows[group], axis=0)).sum(axis=1) >= 2]
    if len(members) == 0:
        return None
    normal = side * np.array([-fit.values[1], -fit.values[2], 1.0])
    size = area.take(members)
    centres = vertices.take(mesh.triangles.take(members, axis=0), axis=0).mean(axis=1)
    centroid = size @ centres / size.sum()
    centroid[2] = middle[2] + (centroid[:2] - middle[:2]) @ fit.values[1:]
    return RoughPlane(members, fit, centroid, normal / np.linalg.norm(normal), float(size.sum()))
