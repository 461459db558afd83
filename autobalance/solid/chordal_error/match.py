"""Chord error of a mesh after a cut: the facets left are recognised by their planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.chordal_error.revolved import SIX_POINTS, Revolved, lens
from autobalance.solid.mesh.adjacency import unit
from autobalance.types import Array, Floats, Indices

SAME_PLANE = 4e-6
"""Distance of corners from a facet's plane, as a share of the part's reach: roundings of float32."""
SAME_WAY = 5e-3
"""Largest lean of a triangle against its facet [rad]; thin ones that lean more hide nothing."""
LOOKED_AT = 4
"""Facets of nearly one plane that are compared with a triangle."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """Surfaces fitted to facets, in the rotor frame.

    Attributes
    ----------
    surfaces : tuple of Revolved
    normals, heights : (k, 3), (k,) float
        Planes of the facets.
    number : (k,) int
        Surface that each facet stands for.
    diagonal_mm : float
        Size of the part.
    density_g_mm3 : float
    """

    surfaces: tuple[Revolved, ...]
    normals: Array
    heights: Array
    number: Indices
    diagonal_mm: float
    density_g_mm3: float

    def missing(self, soup: Floats, frame: Array) -> Moments:
        """Return the metal between the true surface and loose triangles (m, 3, 3) left of the facets.

        Triangles on other planes, those of cuts, hide nothing. ``frame`` (4, 4) takes the triangles to the
        rotor frame.
        """
        if len(self.number) == 0:
            return Moments.zero()
        reach = self.diagonal_mm + float(np.abs(soup).max(initial=0.0))
        corners = soup.astype(np.float64) @ frame[:3, :3].T + frame[:3, 3]
        doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        number = self._numbers(corners, doubled, SAME_PLANE * reach)
        total = Moments.zero()
        for one in np.unique(number[number >= 0]):
            mine = np.flatnonzero(number == one)
            surface = self.surfaces[int(one)]
            total = (
                total + lens(surface, corners[mine], doubled[mine], self.density_g_mm3, SIX_POINTS).moments
            )
        return total

    def _numbers(self, corners: Array, doubled: Array, flat_mm: float) -> Indices:
        """Return the surface that each triangle's facet stands for (m,), or −1."""
        from scipy.spatial import cKDTree

        scale = self.diagonal_mm  # a leaning plane passes that far from where it should, at the other end
        normal = unit(doubled)
        planes = cKDTree(np.column_stack([scale * self.normals, self.heights]))
        height = np.einsum("ij,ij->i", corners.mean(axis=1), normal)
        count = min(LOOKED_AT, len(self.number))
        _, near = planes.query(np.column_stack([scale * normal, height]), k=count)
        number = np.full(len(corners), -1)
        best = np.full(len(corners), np.inf)
        for column in np.asarray(near).reshape(len(corners), count).T:
            plane = self.normals[column]
            aligned = np.einsum("ij,ij->i", plane, normal) > 1.0 - 0.5 * SAME_WAY**2
            apart = np.abs(np.einsum("mkd,md->mk", corners, plane) - self.heights[column, None]).max(axis=1)
            rows = np.flatnonzero(aligned & (apart < np.minimum(best, flat_mm)))
            best[rows], number[rows] = apart[rows], self.number[column[rows]]
        return number
