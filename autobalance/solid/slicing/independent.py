"""Volume, first and second moments by a second method: from areas and moments of slices along z."""

from __future__ import annotations

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array

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
