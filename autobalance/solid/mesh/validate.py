"""The last look at a solid before anything is measured on it."""

from __future__ import annotations

import numpy as np

from autobalance.errors import SolidError
from autobalance.solid.chordal_error.from_slices import signed_area_mm2
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.measure import mesh_moments
from autobalance.solid.mesh.mesh import Array, Mesh

SECTIONS = 24
"""Heights at which a solid is looked at for metal that counts twice."""
FINE = 200_000
FINE_SECTIONS = 6
"""The same above so many triangles, where a section costs more and nothing is doubtful."""
OVERLAP_MOST = 1e-3
"""Share of a solid that may count twice: less than the density of steel is known to."""
NEAR_HULL = 1e-9
"""How far outside the hull rounding may put a centre of mass, as a share of the diagonal."""


def check_solid(solid: Solid, doubtful: bool) -> None:
    """Refuse a solid that cannot be one; that it is closed and has a volume is known already.

    Parameters
    ----------
    solid : Solid
    doubtful : bool
        Whether it was repaired or put together, so that looking at the hull too is worth the time.

    Raises
    ------
    SolidError
        If its centre of mass lies outside of it, or more than ``OVERLAP_MOST`` of it counts twice.
    """
    volume = solid.volume_mm3
    if not 0.0 < volume < np.inf:
        raise SolidError(f"the solid has a volume of {volume:.6g} mm³; it must be positive")
    mesh = solid.mesh
    if doubtful:
        centre = mesh_moments(mesh, 1.0).centre_mm
        if hull_distance_mm(mesh, centre) > NEAR_HULL * mesh.diagonal_mm:
            x, y, z = centre
            raise SolidError(
                f"the solid's centre of mass ({x:.6g}, {y:.6g}, {z:.6g}) mm, in the file's coordinates, lies "
                "outside its hull: some of its metal counts as negative"
            )
    few = not doubtful and solid.triangle_count > FINE
    share, height = overlap(solid, FINE_SECTIONS if few else SECTIONS)
    if share > OVERLAP_MOST:
        raise SolidError(
            f"the solid overlaps itself: {100.0 * share:.3g} % of it counts twice, most of that at "
            f"z = {height:.6g} mm in the file's coordinates; at most {100.0 * OVERLAP_MOST:g} % may"
        )


def hull_distance_mm(mesh: Mesh, point_mm: Array) -> float:
    """Return how far a point (3,) lies outside the convex hull of a mesh, at least; negative inside.

    By qhull: manifold3d's hull may hold triangles that face inward.
    """
    from scipy.spatial import ConvexHull

    planes = ConvexHull(mesh.vertices).equations
    return float((planes[:, :3] @ point_mm + planes[:, 3]).max())


def overlap(solid: Solid, sections: int = SECTIONS) -> tuple[float, float]:
    """Return the share of a solid that counts twice, from sections, and the height z with most of it.

    Of a section, the signed area inside its outlines counts metal as often as it is there; what is left when
    they are united counts it once.
    """
    low, high = (float(value) for value in solid.bounds[:, 2])
    heights = low + (np.arange(sections) + 0.5) / sections * (high - low)
    signed = signed_area_mm2(solid.mesh, np.array([0.0, 0.0, 1.0]), heights)
    once = np.array([solid.section(float(height)).area_mm2 for height in heights])
    twice = signed - once
    worst = int(np.argmax(twice))
    return float(twice.sum() / max(signed.sum(), 1e-300)), float(heights[worst])
