"""The file formats there are: each entered by one line, found by its name or by the ending of a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from autobalance.errors import FormatError
from autobalance.solid.formats import brep, glb, iges, obj, off, ply, step, stl, threemf
from autobalance.solid.formats.format import Format

FOREIGN_CAD = (".fcstd", ".sldprt", ".sldasm", ".ipt", ".prt", ".catpart", ".f3d", ".x_t")
"""Files of CAD programs that only they read."""
_WRITTEN: dict[str, Format] = {}
_FORMATS: dict[str, Format] = {}
_BY_ENDING: dict[str, Format] = {}
WRITTEN: Mapping[str, Format] = MappingProxyType(_WRITTEN)
"""What can be written, by the name that ``Source.format`` gives it: STL is of two kinds."""
FORMATS: Mapping[str, Format] = MappingProxyType(_FORMATS)
"""What can be read, by name."""


def register(kind: Format) -> None:
    """Enter a format.

    Raises
    ------
    ValueError
        If its name or one of its endings is taken.
    """
    if kind.name in _WRITTEN:
        raise ValueError(f"the format {kind.name!r} is there already")
    for ending in kind.endings:
        if ending in _BY_ENDING:
            raise ValueError(f"the ending .{ending} is that of {_BY_ENDING[ending].name}")
    _WRITTEN[kind.name] = kind
    _BY_ENDING.update(dict.fromkeys(kind.endings, kind))
    if kind.endings:
        _FORMATS[kind.name] = kind


register(stl.STL)
register(stl.TEXT_STL)
register(obj.OBJ)
register(ply.PLY)
register(off.OFF)
register(threemf.THREEMF)
register(step.STEP)
register(glb.GLB)
register(iges.IGES)
register(brep.BREP)


def format_named(name: str) -> Format:
    """Return a format by its name.

    Raises
    ------
    FormatError
        If it is not one of those that can be read and written.
    """
    if name not in _WRITTEN:
        raise FormatError(f"the format '{name}' cannot be written; needed one of {', '.join(_WRITTEN)}")
    return _WRITTEN[name]


def format_of(path: Path) -> Format | None:
    """Return the format that a file's ending tells; None where it tells none."""
    return _BY_ENDING.get(path.suffix.lower().lstrip("."))


def name_of_ending(ending: str) -> str:
    """Return the name of the format that an ending without its dot tells, or the ending itself."""
    found = _BY_ENDING.get(ending)
    return ending if found is None else found.name


def endings() -> tuple[str, ...]:
    """Return the endings of all files that can be read, each with its dot."""
    return tuple(f".{ending}" for ending in _BY_ENDING)


def written_ending(path: Path) -> str:
    """Return the ending, with its dot, of the file that a solid from a file is written to."""
    found = format_of(path)
    if found is None or found.written_as in ("", found.name):
        return path.suffix.lower()
    return f".{format_named(found.written_as).endings[0]}"


def written_name(name: str) -> str:
    """Return the name of the format that a solid from a file of a format is written in."""
    return format_named(name).written_as or name


def needs_unit(path: Path) -> bool:
    """Tell whether a file's format carries no unit of length."""
    found = format_of(path)
    return found is not None and not found.carries_unit


def names_bodies(path: Path) -> bool:
    """Tell whether the bodies in a file of its format have names."""
    found = format_of(path)
    return found is not None and found.names_bodies


def kind_of(name: str, data: bytes) -> str:
    """Return the name of the kind of a file, from that of its format and its bytes."""
    form_of = _FORMATS[name].form_of
    return name if form_of is None else form_of(data)
