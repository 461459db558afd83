"""STEP: true surfaces, which the CAD kernel reads and writes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalance.solid.formats.exact import exact_format

if TYPE_CHECKING:
    from autobalance.solid.cad.cad_file import CadFile


def _read(data: bytes) -> CadFile:
    from autobalance.solid.cad.step_file import read_step_file

    return read_step_file(data)


STEP = exact_format("step", ("step", "stp"), _read, names_bodies=True)
