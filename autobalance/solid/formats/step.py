"""STEP: true surfaces, which the CAD kernel reads and writes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.solid.formats.format import exact_format

if TYPE_CHECKING:
    from autobalance.solid.cad.files import CadFile


def _read(data: bytes) -> CadFile:
    from autobalance.solid.cad.files import read_foreign_file

    return read_foreign_file("step", data)


STEP = exact_format("step", _read, names_bodies=True)
