"""Contents of a CAD file: bodies of the kernel, with their names and the file's unit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from autobalance.solid.cad.kernel import scaled
from autobalance.units import MM_PER


@dataclass(frozen=True, eq=False)
class NamedBody:
    """A solid of a CAD file with its part's name, and its place's in the assembly; both may be empty."""

    name: str
    body: Any
    place: str = ""


@dataclass(frozen=True, eq=False)
class CadFile:
    """The solids of a CAD file [mm], the name of its unit, and the repairs that the solids needed.

    Where the file carries no unit, ``unit`` is None and its bodies are in the file's numbers.
    """

    bodies: tuple[NamedBody, ...]
    unit: str | None
    repairs: tuple[str, ...] = ()


def in_unit(file: CadFile, unit: str) -> CadFile:
    """Return a file that carries no unit, with its numbers taken in a unit."""
    if MM_PER[unit] == 1.0:
        return replace(file, unit=unit)
    bodies = (replace(one, body=scaled(one.body, MM_PER[unit])) for one in file.bodies)
    return replace(file, bodies=tuple(bodies), unit=unit)
