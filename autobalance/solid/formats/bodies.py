"""All solids of a file, each by itself: the parts of an assembly."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any

from autobalance.errors import FormatError, SolidError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.gltf import file_bytes
from autobalance.solid.formats.read import Source, every_source, source_of_bytes, source_of_cad
from autobalance.solid.formats.registry import format_of
from autobalance.units import MM_PER
from autobalance.value_classes import dataclass


@dataclass(frozen=True, eq=False)
class BodySource:
    """One solid of a file by itself: its number, as ``body`` counts them, and its name if it has one."""

    number: int
    name: str
    source: Source


def read_bodies(path: Path, unit: str | None) -> tuple[BodySource, ...]:
    """Read every solid of a file, each by itself, by falling volume.

    A name that two of them share is left out: it distinguishes nothing.

    Raises
    ------
    FileError, FormatError, SolidError
        As for ``solid.formats.read.read``.
    """
    kind = format_of(path)
    if kind is None:
        raise FormatError(f"{path}: the ending '{path.suffix}' is not known")
    data = file_bytes(path)
    try:
        sources = _of_cad(kind, data, unit) if kind.exact else every_source(data, kind.name, unit)
    except (FormatError, SolidError) as error:
        raise type(error)(f"{path}: {error}") from None
    names = ["" if source.exact is None else source.exact.name for source in sources]
    return tuple(
        BodySource(number, name if names.count(name) == 1 else "", source)
        for number, (name, source) in enumerate(zip(names, sources, strict=True), 1)
    )


def _of_cad(kind: Format, data: bytes, unit: str | None) -> list[Source]:
    assert kind.read_exact is not None
    file, digest = kind.read_exact(data), hashlib.sha256(data).hexdigest()
    return [source_of_cad(file, digest, kind.name, unit, body) for body in range(1, len(file.bodies) + 1)]


# Reading of a crank in the memory of a CAD program, as the file that it could have come in.


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
