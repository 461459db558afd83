"""Volume, first and second moments by a second method: from areas and moments of slices along z."""

from __future__ import annotations

import numpy as np

from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Polygons
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Flags, Indices
from autobalance.value_classes import dataclass

# Volume, first and second moments by a second method: from areas and moments of slices along z.


GAUSS = np.polynomial.legendre.leggauss(3)
"""Exact up to degree 5; between two corners of a triangle the moments of its slices are of degree 4."""
CHUNK = 1 << 16
"""Triangles at a time."""


def slice_moments(mesh: Mesh, density_g_mm3: float, frame: Array | None = None) -> Moments:
    """Return the mass moments of the solid that a closed mesh bounds, from its slices.

    Each triangle cuts a segment from a slice. Green's theorem makes area and moments of the slice from the
    segments, Gauss points between the triangle's corners make the integral along z: no tetrahedra, and no
    formula in common with ``mesh_moments``.

    Parameters
    ----------
    mesh : Mesh
        Closed, outward [mm].
    density_g_mm3 : float
        Density [g/mm³].
    frame : (4, 4) float, optional
        Rigid motion from the mesh's coordinates to those the moments are wanted in.
    """
    placed = mesh if frame is None else mesh.moved(frame)
    near = placed.bounds.mean(axis=0)
    vertices = placed.vertices - near
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for start in range(0, len(placed.triangles), CHUNK):
        part = _sliced(vertices[placed.triangles[start : start + CHUNK]])
        volume += part[0]
        first += part[1]
        second += part[2]
    shift = np.eye(4)
    shift[:3, 3] = near
    return Moments(density_g_mm3 * volume, density_g_mm3 * first, density_g_mm3 * second).moved(shift)


def trimesh_moments(mesh: Mesh, density_g_mm3: float, frame: Array | None = None) -> Moments:
    """Return the mass moments of the solid that a closed mesh bounds, by trimesh: by somebody else's code.

    Parameters
    ----------
    mesh, density_g_mm3, frame
        As for ``slice_moments``.

    Notes
    -----
    trimesh gives the inertia I about the centre of mass, off-diagonals −∫xy dm: ∫ r rᵀ dm = ½ tr(I) E − I.
    """
    from trimesh.triangles import mass_properties

    placed = mesh if frame is None else mesh.moved(frame)
    near = placed.bounds.mean(axis=0)
    found = mass_properties((placed.vertices - near)[placed.triangles], density=density_g_mm3)
    mass, centre = float(found["mass"]), np.asarray(found["center_mass"])
    inertia = np.asarray(found["inertia"])
    about_centre = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    shift = np.eye(4)
    shift[:3, 3] = near
    return Moments(mass, mass * centre, about_centre + mass * np.outer(centre, centre)).moved(shift)


def _sliced(corners: Array) -> tuple[float, Array, Array]:
    """Return the contribution of triangles (m, 3, 3) to volume, first and second moments."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    order = np.argsort(corners[:, :, 2], axis=1)
    low, middle, high = np.take_along_axis(corners, order[:, :, None], axis=1).transpose(1, 0, 2)
    span = high[:, 2] - low[:, 2]
    upright = span > 0.0
    low, middle, high, normal, span = (each[upright] for each in (low, middle, high, normal, span))
    across = middle - (low + ((middle[:, 2] - low[:, 2]) / span)[:, None] * (high - low))
    metal_left = np.sign(across[:, 1] * normal[:, 0] - across[:, 0] * normal[:, 1])
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for bottom, top in ((low, middle), (middle, high)):
        height = top[:, 2] - bottom[:, 2]
        for place, weight in zip(*GAUSS, strict=True):
            share = 0.5 * (1.0 + place)
            z = bottom[:, 2] + share * height
            p = low + ((z - low[:, 2]) / span)[:, None] * (high - low)
            q = bottom + share * (top - bottom)
            factor = 0.5 * weight * height * metal_left
            cross = factor * (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
            area, total = 0.5 * cross, p[:, :2] + q[:, :2]
            flat = cross @ total / 6.0
            volume += area.sum()
            first += [*flat, area @ z]
            for pair in (total, p[:, :2], q[:, :2]):
                second[:2, :2] += (cross[:, None] * pair).T @ pair / 24.0
            second[:2, 2] += (cross * z) @ total / 6.0
            second[2, 2] += area @ (z * z)
    second[2, :2] = second[:2, 2]
    return volume, first, second


def agreement(one: Moments, other: Moments) -> float:
    """Return the largest difference of two sets of moments, as a share of mass times size to the power."""
    size = float(np.sqrt(np.trace(one.second_g_mm2) / one.mass_g))
    return max(
        abs(one.mass_g - other.mass_g) / one.mass_g,
        float(np.abs(one.first_g_mm - other.first_g_mm).max()) / (one.mass_g * size),
        float(np.abs(one.second_g_mm2 - other.second_g_mm2).max()) / (one.mass_g * size * size),
    )


# Grid of cells over a plane region, to sort many boxes at once into inside and outside.


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
