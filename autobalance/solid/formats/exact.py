"""Common part of the formats of true surfaces, which the CAD kernel reads."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.raw import Raw
from autobalance.types import Floats, Indices

if TYPE_CHECKING:
    from autobalance.solid.cad.cad_file import CadFile


def exact_format(
    name: str,
    read: Callable[[bytes], CadFile],
    carries_unit: bool = True,
    names_bodies: bool = False,
) -> Format:
    """Return a format of true surfaces, which is not a mesh; cut solids are written as STEP."""

    def no_mesh(data: bytes) -> Raw:
        raise FormatError(f"a {name.upper()} file holds exact surfaces, no mesh")

    def no_surfaces(vertices: Floats, triangles: Indices, mm_per_unit: float) -> bytes:
        raise FormatError(f"a mesh cannot be written as {name.upper()}; write stl")

    return Format(
        name,
        no_mesh,
        no_surfaces,
        np.float64,
        carries_unit=carries_unit,
        names_bodies=names_bodies,
        read_exact=read,
    )
