"""Meshes for other libraries."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.solid.mesh.mesh import Mesh

if TYPE_CHECKING:
    import trimesh


def to_trimesh(mesh: Mesh) -> trimesh.Trimesh:
    """Return a mesh of trimesh with the same corners and triangles."""
    import trimesh

    return trimesh.Trimesh(mesh.vertices.copy(), mesh.triangles.copy(), process=False, validate=False)
