"""All solids of a file, each by itself: the parts of an assembly."""

from __future__ import annotations

import hashlib
from pathlib import Path

from autobalance.errors import FormatError, SolidError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.gltf import file_bytes
from autobalance.solid.formats.read import Source, every_source, source_of_cad
from autobalance.solid.formats.registry import format_of
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
