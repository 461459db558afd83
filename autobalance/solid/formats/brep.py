"""BREP: true surfaces in the CAD kernel's own text, without a unit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.solid.formats.format import exact_format

if TYPE_CHECKING:
    from autobalance.solid.cad.files import CadFile


def _read(data: bytes) -> CadFile:
    from autobalance.solid.cad.files import read_foreign_file

    return read_foreign_file("brep", data)


BREP = exact_format("brep", _read, carries_unit=False)
