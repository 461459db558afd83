"""Meshes of solids that were cut from others, whose finest edges no mesher takes."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.errors import SolidError
from autobalance.fem_analysis.elasticity import ElasticBody
from autobalance.fem_analysis.mesher import SHARE_OF_RADIUS, SurfaceSolid, meshes_of
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import through_file
from autobalance.solid.mesh.mesh import mesh_of_soup

FINEST_MM = (0.0, 1e-3, 1e-2)
"""Edges shorter than this are merged before meshing, tried one after the other; the first are those that a
file of single precision has: what cutting leaves is finer than any mesh."""


def bodies_of_solid(
    solid: Solid,
    size_mm: float | None,
    factors: Sequence[float] = (1.0,),
    share_of_radius: float = SHARE_OF_RADIUS,
) -> list[ElasticBody]:
    """Return meshes of a solid, of so many times a size each; None: chosen.

    Raises
    ------
    FileError
        If the mesher is not installed.
    SolidError
        If it fails whatever is merged.
    """
    for finest in FINEST_MM:
        _, soup = through_file((solid.simplified(finest) if finest else solid).mesh, "stl", 1.0)
        mesh = mesh_of_soup(soup)
        try:
            made = meshes_of(SurfaceSolid(mesh.vertices, mesh.triangles), size_mm, factors, share_of_radius)
            return [ElasticBody.of(each) for each in made]
        except SolidError:
            if finest == FINEST_MM[-1]:
                raise
    raise AssertionError  # the last size has returned or raised
