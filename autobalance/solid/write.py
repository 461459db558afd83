"""Solids become files, and files are read back as any reader sees them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalance.errors import FormatError, SolidError
from autobalance.solid.csg import Solid
from autobalance.solid.mesh import Array, Indices, Mesh, _hash, weld, without_collapsed
from autobalance.solid.repair import without_opposite_pairs
from autobalance.solid.stl import read_stl, write_stl

ROUNDINGS = (2.0, 8.0, 32.0, 128.0)
"""How many float32 spacings to merge, one after the other, until a rounded solid stays closed."""


def encode(mesh: Mesh, format: str, mm_per_unit: float) -> bytes:  # noqa: A002
    """Write the mesh of a solid as the bytes of a file.

    What rounding to the file's numbers makes collapse is left out, so that an exact weld of what was written
    is a closed mesh again.

    Parameters
    ----------
    mesh : Mesh
        Closed, outward [mm].
    format : str
        As in ``Source.format``.
    mm_per_unit : float
        Millimetres in one unit of the file.

    Raises
    ------
    FormatError
        If the format cannot be written.
    SolidError
        If the solid is too fine for the numbers of the format.
    """
    _check(format)
    vertices = _rounded(mesh.vertices, mm_per_unit)
    triangles = mesh.triangles
    if not _all_distinct(vertices):
        vertices, triangles = _welded_after_rounding(mesh, mm_per_unit)
    return write_stl(vertices, triangles)


def decode(data: bytes, format: str, mm_per_unit: float) -> Mesh:  # noqa: A002
    """Return the mesh [mm] that a file holds, corners not welded: enough to measure it.

    Raises
    ------
    FormatError
        If the bytes are no file of this format.
    """
    _check(format)
    points = read_stl(data).reshape(-1, 3).astype(np.float64)
    if mm_per_unit != 1.0:
        points *= mm_per_unit
    return Mesh(points, np.arange(len(points), dtype=np.int64).reshape(-1, 3))


def _check(name: str) -> None:
    if name != "stl":
        raise FormatError(f"the format '{name}' cannot be written; needed stl")


def _rounded(vertices: Array, mm_per_unit: float) -> NDArray[np.float32]:
    scaled = vertices if mm_per_unit == 1.0 else vertices / mm_per_unit
    rounded: NDArray[np.float32] = scaled.astype(np.float32)
    rounded += np.float32(0.0)  # −0 becomes 0
    return rounded


def _all_distinct(vertices: NDArray[np.float32]) -> bool:
    """Tell whether no two vertices are equal; a shared hash counts as equal."""
    key = _hash(np.ascontiguousarray(vertices).view(np.uint32))
    key.sort()
    return not bool((key[1:] == key[:-1]).any())


def _welded_after_rounding(mesh: Mesh, mm_per_unit: float) -> tuple[NDArray[np.float32], Indices]:
    """Merge what rounding made equal; where that spoils the solid, merge near vertices before rounding."""
    spacing = float(np.spacing(np.float32(np.abs(mesh.vertices).max() / mm_per_unit))) * mm_per_unit
    volume = Solid.from_mesh(mesh).volume_mm3
    candidate = mesh
    for roundings in (0.0, *ROUNDINGS):
        if roundings:
            solid = Solid.from_mesh(mesh).simplified(roundings * spacing)
            if solid.is_empty:
                break
            candidate = solid.mesh
        vertices, number = weld(_rounded(candidate.vertices, mm_per_unit))
        triangles = without_opposite_pairs(without_collapsed(number[candidate.triangles]))
        if _is_solid(Mesh(vertices.astype(np.float64) * mm_per_unit, triangles), volume):
            return vertices, triangles
    raise SolidError(
        f"the solid does not stay closed when its coordinates are rounded to {spacing:.3g} mm,"
        " as a binary STL does; needed: a part nearer to the file's origin, or a coarser mesh"
    )


def _is_solid(mesh: Mesh, volume_mm3: float) -> bool:
    try:
        solid = Solid.from_mesh(mesh)
    except SolidError:
        return False
    return abs(solid.volume_mm3 - volume_mm3) <= 1e-4 * volume_mm3  # rounding moves a surface by far less
