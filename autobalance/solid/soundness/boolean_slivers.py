"""Removal of flakes that a boolean between near surfaces leaves; refusal of loose pieces after a cut."""

# Needed by solids that manifold3d cut near their own faces (tests/geometry/test_traces.py, the flake).

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import SolidError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.mesh.measure import part_volumes
from autobalance.solid.mesh.mesh import Mesh
from autobalance.types import Array, Indices

FLAKE_SHARE = 1e-7
"""Share of a solid's volume up to which a piece apart from it is rounding."""


def without_flakes(cut: Solid, before: Solid) -> Solid:
    """Return a solid that was cut from another without the flakes that rounding left beside it.

    A reader of its file would find several bodies, some of them inside out.

    Raises
    ------
    SolidError
        If a piece of it that is not a flake has come loose.
    """
    mesh = cut.mesh
    part_of, count = _parts_at_vertices(mesh)
    if count == 1:
        return cut
    _, had = _parts_at_vertices(before.mesh)
    if count <= had:
        return cut
    volumes = part_volumes(mesh, part_of, count)
    is_flake = np.abs(volumes) <= FLAKE_SHARE * cut.volume_mm3
    left = count - int(is_flake.sum())
    if left > had and left > len(before.pieces()):  # which separates bodies that touch
        _refuse_loose(cut, part_of, volumes, is_flake)
    return Solid.of_parts(mesh.part(~is_flake.take(part_of))) if is_flake.any() else cut


def _parts_at_vertices(mesh: Mesh) -> tuple[Indices, int]:
    """Return the part (m,) of each triangle, where those that share a vertex are one, and their number."""
    part_of_vertex, count = mesh.parts_at_vertices
    if count == 1:
        return np.zeros(len(mesh.triangles), dtype=np.int64), 1
    part_of = part_of_vertex.take(mesh.triangles[:, 0])
    used = np.bincount(part_of, minlength=count) > 0  # not the vertices of no triangle
    return (np.cumsum(used) - 1).take(part_of), int(used.sum())


def _refuse_loose(cut: Solid, part_of: Indices, volumes: Array, is_flake: NDArray[np.bool_]) -> None:
    loose = int(np.argmin(np.where(is_flake, np.inf, np.abs(volumes))))
    x, y, z = cut.mesh.corners[part_of == loose].mean(axis=(0, 1))
    raise SolidError(
        f"the cuts leave a loose piece of {abs(volumes[loose]):.4g} mm³ around ({x:.6g}, {y:.6g}, {z:.6g}) mm"
        " in the file's coordinates; expected a crank in one piece: other faces, sectors or depths"
    )
