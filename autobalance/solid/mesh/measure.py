"""Exact mass moments of a closed triangle mesh, from the divergence theorem."""

from __future__ import annotations

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.mesh.tetrahedra import CHUNK, six_volumes, summed
from autobalance.types import Array, Floats, Indices


def mesh_moments(mesh: Mesh, density_g_mm3: float, frame: Array | None = None) -> Moments:
    """Return the mass moments of the solid that a closed mesh bounds.

    Each triangle spans a tetrahedron with a point near the part, so that no digits are lost when the part
    lies far from the origin; signed, the tetrahedra add up to the solid.

    Parameters
    ----------
    mesh : Mesh
        Closed, outward [mm].
    density_g_mm3 : float
        Density [g/mm³].
    frame : (4, 4) float, optional
        Rigid motion from the mesh's coordinates to those the moments are wanted in.

    Returns
    -------
    Moments
        About the origin of the wanted frame.

    References
    ----------
    C. Zhang, T. Chen, "Efficient feature extraction for 2D/3D objects in mesh representation", 2001: signed
    tetrahedra; second moments of a tetrahedron with a corner at the origin, det/120 (s sᵀ + Σ v vᵀ).
    """
    near = mesh.bounds.mean(axis=0)
    return _placed(mesh.moments_about_middle, near, density_g_mm3, frame)


def soup_moments(soup: Floats, density_g_mm3: float, frame: Array | None = None) -> Moments:
    """Return the mass moments of the solid that loose triangles (m, 3, 3) bound, as ``mesh_moments`` does."""
    some = soup[:: max(1, len(soup) // NEAR_ENOUGH)].reshape(-1, 3)
    near = 0.5 * (some.min(axis=0) + some.max(axis=0)).astype(np.float64)
    volume = summed(
        np.ascontiguousarray((soup[start : start + CHUNK] - near).transpose(1, 2, 0))
        for start in range(0, len(soup), CHUNK)
    )
    return _placed(volume, near, density_g_mm3, frame)


NEAR_ENOUGH = 1000
"""Triangles sampled to see where a part lies."""


def _placed(volume: Moments, near: Array, density_g_mm3: float, frame: Array | None) -> Moments:
    shift = np.eye(4)
    shift[:3, 3] = near
    return volume.scaled(density_g_mm3).moved(shift if frame is None else frame @ shift)


def signed_volume_mm3(mesh: Mesh) -> float:
    """Return the volume inside a closed mesh, negative if it is inside out."""
    axes = np.ascontiguousarray((mesh.vertices - mesh.bounds.mean(axis=0)).T)
    return (
        sum(
            float(
                six_volumes(*axes.take(mesh.triangles[begin : begin + CHUNK].T, axis=1).swapaxes(0, 1)).sum()
            )
            for begin in range(0, len(mesh.triangles), CHUNK)
        )
        / 6.0
    )


def part_volumes(mesh: Mesh, part_of: Indices, count: int) -> Array:
    """Return the signed volume (count,) inside each part of a closed mesh, negative if it is inside out.

    Parameters
    ----------
    mesh : Mesh
        Closed in every part [mm].
    part_of : (m,) int
        The part, from 0 to ``count`` − 1, of each triangle.
    count : int
    """
    height = mesh.vertices[:, 2] - mesh.bounds[:, 2].mean()
    volumes = np.zeros(count)
    for start in range(0, len(part_of), CHUNK):
        some = slice(start, start + CHUNK)
        a, b, c = height.take(mesh.triangles[some]).T
        under = mesh.area_vectors[some, 2] * (a + b + c)
        volumes += np.bincount(part_of[some], weights=under, minlength=count)
    return volumes / 6.0
