"""Writing of solids to files, and reading of files back as any reader sees them."""

from __future__ import annotations

import numpy as np

from autobalance.errors import SolidError
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.registry import format_named
from autobalance.solid.mesh.measure import signed_volume_mm3
from autobalance.solid.mesh.mesh import Mesh, hash_rows, weld, without_collapsed
from autobalance.solid.soundness.repair import without_opposite_pairs
from autobalance.types import Array, Floats, Indices
from autobalance.value_classes import dataclass

Number = type[np.float32] | type[np.float64]

ROUNDINGS = (2.0, 8.0, 32.0, 128.0)
"""Spacings of the file's numbers to merge, one after the other, until a rounded solid stays closed."""


def encode(mesh: Mesh, format: str, mm_per_unit: float) -> bytes:  # noqa: A002
    """Write the mesh of a solid as the bytes of a file.

    Triangles that collapse by rounding to the file's numbers are left out, so that an exact weld of the
    others is a closed mesh again.

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
    return _encoded(mesh, format, mm_per_unit)[0]


def _encoded(mesh: Mesh, format: str, mm_per_unit: float) -> tuple[bytes, Solid | None]:  # noqa: A002
    """Return the bytes of a file, and their solid where rounding made building it necessary, else None."""
    kind = format_named(format)
    vertices = _rounded(mesh.vertices, mm_per_unit, kind.number)
    triangles, solid = mesh.triangles, None
    if not _all_distinct(vertices):
        vertices, triangles, solid = _welded_after_rounding(mesh, mm_per_unit, kind.number)
    return kind.write(vertices, triangles, mm_per_unit), solid


def decode(data: bytes, format: str, mm_per_unit: float) -> Floats:  # noqa: A002
    """Return the loose triangles (m, 3, 3) of a file [mm]: enough to measure it.

    Raises
    ------
    FormatError
        If the bytes are not a file of this format.
    """
    with np.errstate(all="ignore"):  # as in ``read``
        soup = format_named(format).read(data).soup
    return soup if mm_per_unit == 1.0 else soup.astype(np.float64) * mm_per_unit


def through_file(mesh: Mesh, format: str, mm_per_unit: float) -> tuple[bytes, Floats]:  # noqa: A002
    """Return the bytes of a file of a solid, and the loose triangles (m, 3, 3) read back from them [mm]."""
    data = encode(mesh, format, mm_per_unit)
    return data, decode(data, format, mm_per_unit)


@dataclass(frozen=True, eq=False)
class Written:
    """File of a solid, as bytes and as read back.

    Attributes
    ----------
    data : bytes
    soup : (m, 3, 3) float
        The loose triangles read back from these bytes [mm].
    solid : Solid or None
        The solid of these triangles, where rounding made building it necessary.
    """

    data: bytes
    soup: Floats
    solid: Solid | None

    @classmethod
    def of(cls, mesh: Mesh, format: str, mm_per_unit: float) -> Written:  # noqa: A002
        """Write a solid's mesh and read it back."""
        data, solid = _encoded(mesh, format, mm_per_unit)
        soup = decode(data, format, mm_per_unit)
        same = solid is not None and np.array_equal(soup, solid.mesh.corners)
        return cls(data, soup, solid if same else None)


def _rounded(vertices: Array, mm_per_unit: float, number: Number) -> Floats:
    scaled = vertices if mm_per_unit == 1.0 else vertices / mm_per_unit
    rounded: Floats = scaled.astype(number)
    rounded += number(0.0)  # −0 becomes 0
    return rounded


def _all_distinct(vertices: Floats) -> bool:
    """Return whether no two vertices are equal; a shared hash counts as equal."""
    key = hash_rows(vertices)
    key.sort()
    return not bool((key[1:] == key[:-1]).any())


def _welded_after_rounding(mesh: Mesh, mm_per_unit: float, number: Number) -> tuple[Floats, Indices, Solid]:
    """Merge vertices that rounding made equal; where that spoils the solid, merge near ones before it."""
    spacing = float(np.spacing(number(np.abs(mesh.vertices).max() / mm_per_unit))) * mm_per_unit
    volume = signed_volume_mm3(mesh)
    candidate = mesh
    for roundings in (0.0, *ROUNDINGS):
        if roundings:
            coarser = Solid.from_mesh(mesh).simplified(roundings * spacing)
            if coarser.is_empty:
                break
            candidate = coarser.mesh
        vertices, row = weld(_rounded(candidate.vertices, mm_per_unit, number))
        triangles = without_opposite_pairs(without_collapsed(row[candidate.triangles]))
        solid = _solid_of(Mesh(vertices.astype(np.float64) * mm_per_unit, triangles), volume)
        if solid is not None:
            return vertices, triangles, solid
    raise SolidError(
        f"the solid does not stay closed when its coordinates are rounded to {spacing:.3g} mm,"
        " as its format does; expected a part nearer to the file's origin, or a coarser mesh"
    )


def _solid_of(mesh: Mesh, volume_mm3: float) -> Solid | None:
    """Return the solid of a mesh; None if it bounds none, or not one of the expected volume."""
    try:
        solid = Solid.of_closed(mesh) or Solid.from_mesh(mesh)
    except SolidError:
        return None
    off = abs(solid.volume_mm3 - volume_mm3)
    return solid if off <= 1e-4 * volume_mm3 else None  # rounding moves a surface by far less
