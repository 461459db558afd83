"""Reading of a crank in the memory of a CAD program, as the file that it could have come in."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from typing import Any

from autobalance.errors import FormatError
from autobalance.solid.formats.read import Source, source_of_bytes, source_of_cad
from autobalance.units import MM_PER


def source_of_shape(shape: Any, unit: str, body: int | str | None = None, pressed_up: bool = False) -> Source:
    """Return the checked solid of a shape, or of a STEP or BREP file's bytes, as ``read`` does of a file's.

    Parameters
    ----------
    shape : TopoDS_Shape, object that wraps one, or bytes
    unit : str
        Of a shape or a BREP file: mm, cm, m or inch.
    body, pressed_up
        As for ``read``.

    Raises
    ------
    FormatError
        If it is neither, the unit is not known, or the CAD kernel is missing.
    SolidError
        As for ``read``.
    """
    from autobalance.solid.cad.build import EXPECTED, step_of_shape
    from autobalance.solid.cad.files import BEGINNING, read_step_file

    if unit not in MM_PER:
        raise FormatError(f"the unit '{unit}' is not known; expected one of {', '.join(MM_PER)}")
    if not isinstance(shape, bytes | bytearray | memoryview):
        data = step_of_shape(shape, unit)
        digest = hashlib.sha256(data).hexdigest()
        source = source_of_cad(read_step_file(data), digest, "step", None, body, pressed_up)
        return replace(source, in_memory_file=data)
    data = bytes(shape)
    if b"ISO-10303-21" in data[:256]:
        name, its_unit = "step", None
    elif BEGINNING.match(data):
        name, its_unit = "brep", unit
    else:
        raise FormatError(f"shape: found bytes that are neither STEP nor BREP; expected {EXPECTED}")
    return replace(source_of_bytes(data, name, its_unit, body, pressed_up), in_memory_file=data)
