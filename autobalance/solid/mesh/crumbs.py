"""Parts of a closed mesh that bound next to nothing: folded triangles, no metal."""

from __future__ import annotations

import numpy as np

from autobalance.solid.mesh.components import numbered_components
from autobalance.solid.mesh.measure import part_volumes
from autobalance.solid.mesh.mesh import Indices, Mesh
from autobalance.solid.mesh.pinched import linked_triangles

CRUMB = 1e-12
"""Share of a file's volume that a body must bound: what coordinates of single precision leave is far less."""


def parts_at_edges(mesh: Mesh) -> tuple[Indices, int]:
    """Return the part (m,) of each triangle of a closed mesh, which may touch itself, and their number."""
    return numbered_components(linked_triangles(mesh), len(mesh.triangles))


def without_crumbs(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Return a closed mesh without its crumbs, and what was dropped."""
    part_of, count = parts_at_edges(mesh)
    volumes = np.abs(part_volumes(mesh, part_of, count))
    is_crumb = volumes <= CRUMB * volumes.sum()
    number = int(is_crumb.sum())
    if number in (0, count):
        return mesh, []
    kept = mesh.part(~is_crumb.take(part_of))
    return kept, [crumbs_dropped(number, float(volumes[is_crumb].sum()))]


def crumbs_dropped(number: int, volume_mm3: float) -> str:
    """Say what was dropped."""
    name = "1 crumb" if number == 1 else f"{number} crumbs"
    return f"{name} dropped that bound {volume_mm3:.3g} mm³: folded triangles, no metal"
