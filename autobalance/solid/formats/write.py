"""Solids become files, and files are read back as any reader sees them."""

from __future__ import annotations

import numpy as np

from autobalance.errors import SolidError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.registry import format_named
from autobalance.solid.mesh.mesh import Array, Floats, Indices, Mesh, hash_rows, weld, without_collapsed
from autobalance.solid.mesh.repair import without_opposite_pairs

Number = type[np.float32] | type[np.float64]

ROUNDINGS = (2.0, 8.0, 32.0, 128.0)
"""Spacings of the file's numbers to merge, one after the other, until a rounded solid stays closed."""


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
    kind = format_named(format)
    vertices = _rounded(mesh.vertices, mm_per_unit, kind.number)
    triangles = mesh.triangles
    if not _all_distinct(vertices):
        vertices, triangles = _welded_after_rounding(mesh, mm_per_unit, kind.number)
    return kind.write(vertices, triangles, mm_per_unit)


def decode(data: bytes, format: str, mm_per_unit: float) -> Floats:  # noqa: A002
    """Return the loose triangles (m, 3, 3) [mm] that a file holds: enough to measure it.

    Raises
    ------
    FormatError
        If the bytes are no file of this format.
    """
    with np.errstate(all="ignore"):  # as in ``read``
        soup = format_named(format).read(data).soup
    return soup if mm_per_unit == 1.0 else soup.astype(np.float64) * mm_per_unit


def through_file(mesh: Mesh, format: str, mm_per_unit: float) -> tuple[bytes, Floats]:  # noqa: A002
    """Return what a file of a solid holds, and the loose triangles (m, 3, 3) read back from that [mm]."""
    data = encode(mesh, format, mm_per_unit)
    return data, decode(data, format, mm_per_unit)


def _rounded(vertices: Array, mm_per_unit: float, number: Number) -> Floats:
    scaled = vertices if mm_per_unit == 1.0 else vertices / mm_per_unit
    rounded: Floats = scaled.astype(number)
    rounded += number(0.0)  # −0 becomes 0
    return rounded


def _all_distinct(vertices: Floats) -> bool:
    """Tell whether no two vertices are equal; a shared hash counts as equal."""
    key = hash_rows(vertices)
    key.sort()
    return not bool((key[1:] == key[:-1]).any())


def _welded_after_rounding(mesh: Mesh, mm_per_unit: float, number: Number) -> tuple[Floats, Indices]:
    """Merge what rounding made equal; where that spoils the solid, merge near vertices before rounding."""
    spacing = float(np.spacing(number(np.abs(mesh.vertices).max() / mm_per_unit))) * mm_per_unit
    volume = Solid.from_mesh(mesh).volume_mm3
    candidate = mesh
    for roundings in (0.0, *ROUNDINGS):
        if roundings:
            solid = Solid.from_mesh(mesh).simplified(roundings * spacing)
            if solid.is_empty:
                break
            candidate = solid.mesh
        vertices, row = weld(_rounded(candidate.vertices, mm_per_unit, number))
        triangles = without_opposite_pairs(without_collapsed(row[candidate.triangles]))
        if _is_solid(Mesh(vertices.astype(np.float64) * mm_per_unit, triangles), volume):
            return vertices, triangles
    raise SolidError(
        f"the solid does not stay closed when its coordinates are rounded to {spacing:.3g} mm,"
        " as its format does; needed: a part nearer to the file's origin, or a coarser mesh"
    )


def _is_solid(mesh: Mesh, volume_mm3: float) -> bool:
    try:
        solid = Solid.from_mesh(mesh)
    except SolidError:
        return False
    return abs(solid.volume_mm3 - volume_mm3) <= 1e-4 * volume_mm3  # rounding moves a surface by far less
