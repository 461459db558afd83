"""The file formats of the table, loaded: found by name or by the ending of a file."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import MappingProxyType

from autobalance.errors import FormatError
from autobalance.solid.formats.format import Format
from autobalance.solid.formats.table import ENTRIES

FOREIGN_CAD = (".fcstd", ".sldprt", ".sldasm", ".ipt", ".prt", ".catpart", ".f3d", ".x_t")
"""Endings of files of CAD programs that only they read."""


def _loaded(name: str) -> Format:
    module, variable = ENTRIES[name].place.split(":")
    format_: Format = getattr(import_module(f"autobalance.solid.formats.{module}"), variable)
    return format_


WRITTEN_FORMATS: Mapping[str, Format] = MappingProxyType({name: _loaded(name) for name in ENTRIES})
"""Formats that can be written, by their name in ``Source.format``: STL is of two kinds."""
FORMATS: Mapping[str, Format] = MappingProxyType(
    {name: kind for name, kind in WRITTEN_FORMATS.items() if ENTRIES[name].endings}
)
"""Formats that can be read, by name."""
_BY_ENDING = {ending: kind for name, kind in FORMATS.items() for ending in ENTRIES[name].endings}


def format_named(name: str) -> Format:
    """Return a format by its name.

    Raises
    ------
    FormatError
        If it cannot be read and written.
    """
    if name not in WRITTEN_FORMATS:
        raise FormatError(
            f"the format '{name}' cannot be written; expected one of {', '.join(WRITTEN_FORMATS)}"
        )
    return WRITTEN_FORMATS[name]


def format_of(path: Path) -> Format | None:
    """Return the format that a file's ending names; None if it is unknown."""
    return _BY_ENDING.get(path.suffix.lower().lstrip("."))


def name_of_ending(ending: str) -> str:
    """Return the name of the format that an ending without its dot stands for, or the ending itself."""
    entry = _BY_ENDING.get(ending)
    return ending if entry is None else entry.name


def written_ending(path: Path) -> str:
    """Return the ending, with its dot, of the file that a solid from a file is written to."""
    format_ = format_of(path)
    other = "" if format_ is None else ENTRIES[format_.name].written_as
    return f".{ENTRIES[other].endings[0]}" if other else path.suffix.lower()


def written_name(name: str) -> str:
    """Return the name of the format that a solid from a file of a format is written in."""
    return ENTRIES[format_named(name).name].written_as or name


def needs_unit(path: Path) -> bool:
    """Return whether a file has no unit of length, because of its format or because it leaves it out."""
    format_ = format_of(path)
    if format_ is None or not format_.carries_unit:
        return format_ is not None
    return format_.states_no_unit is not None and path.is_file() and format_.states_no_unit(path)


def names_bodies(path: Path) -> bool:
    """Return whether the bodies in a file of its format have names."""
    format_ = format_of(path)
    return format_ is not None and format_.names_bodies


def kind_of(name: str, data: bytes) -> str:
    """Return the name of a file's kind within its format, from the format's name and the file's bytes."""
    form_of = FORMATS[name].form_of
    return name if form_of is None else form_of(data)
