"""Parts of a closed mesh that bound next to nothing: folded triangles, no metal."""

# Needed by finely drawn STL whose folded slivers close on themselves (tests: "crumbs that bound nothing").

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from autobalance.solid.mesh.components import numbered_components
from autobalance.solid.mesh.measure import part_volumes
from autobalance.solid.mesh.mesh import Mesh
from autobalance.solid.mesh.non_manifold_edges import linked_triangles
from autobalance.types import Indices

CRUMB_VOLUME_SHARE = 1e-12
"""Share of a file's volume that a body must bound: rounding to single precision leaves far less."""


_PARTS: WeakKeyDictionary[Mesh, tuple[Indices, int]] = WeakKeyDictionary()
"""Parts of meshes without crumbs: their bodies are requested as soon as they are built."""


def parts_at_edges(mesh: Mesh) -> tuple[Indices, int]:
    """Return the part (m,) of each triangle of a closed mesh, which may touch itself, and their number."""
    known = _PARTS.get(mesh)
    return numbered_components(linked_triangles(mesh), len(mesh.triangles)) if known is None else known


def without_crumbs(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """Return a closed mesh without its crumbs, and a note on those, if any."""
    part_of, count = parts_at_edges(mesh)
    volumes = np.abs(part_volumes(mesh, part_of, count))
    is_crumb = volumes <= CRUMB_VOLUME_SHARE * volumes.sum()
    number = int(is_crumb.sum())
    if number in (0, count):
        _PARTS[mesh] = part_of, count
        return mesh, []
    stays = ~is_crumb.take(part_of)
    kept = mesh.part(stays)
    _PARTS[kept] = (np.cumsum(~is_crumb) - 1).take(part_of[stays]), count - number
    return kept, [crumbs_dropped(number, float(volumes[is_crumb].sum()))]


def crumbs_dropped(number: int, volume_mm3: float) -> str:
    """Return a note on dropped crumbs."""
    name = "1 crumb" if number == 1 else f"{number} crumbs"
    return f"{name} dropped that bound {volume_mm3:.3g} mm³: folded triangles, no metal"
