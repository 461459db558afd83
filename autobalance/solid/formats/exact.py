"""Formats of true surfaces, which the CAD kernel reads: STEP, IGES and the kernel's own BREP."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.raw import Raw
from autobalance.types import Floats, Indices

if TYPE_CHECKING:
    from autobalance.solid.cad.files import CadFile


def exact_format(name: str, carries_unit: bool = True, names_bodies: bool = False) -> Format:
    """Return a format of true surfaces, which is not a mesh; cut solids are written as STEP."""

    def no_mesh(data: bytes) -> Raw:
        raise FormatError(f"a {name.upper()} file holds exact surfaces, no mesh")

    def no_surfaces(vertices: Floats, triangles: Indices, mm_per_unit: float) -> bytes:
        raise FormatError(f"a mesh cannot be written as {name.upper()}; write stl")

    def read_exact(data: bytes) -> CadFile:
        from autobalance.solid.cad.files import read_foreign_file

        return read_foreign_file(name, data)

    return Format(
        name, no_mesh, no_surfaces, np.float64,
        carries_unit=carries_unit, names_bodies=names_bodies, read_exact=read_exact,
    )  # fmt: skip


STEP = exact_format("step", names_bodies=True)
IGES = exact_format("iges")
BREP = exact_format("brep", carries_unit=False)
