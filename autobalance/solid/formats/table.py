"""Table of the file formats, each entered by one line; the table itself loads nothing."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class FormatEntry(NamedTuple):
    """A format's line.

    Attributes
    ----------
    endings : tuple of str
        Endings of its files, without the dot; none: another form of a format, recognised by the bytes.
    place : str
        Its ``Format``, as ``"module:NAME"``.
    written_as : str
        Name of the format for writing a solid that came in this one, where that is another; "": this.
    """

    endings: tuple[str, ...]
    place: str
    written_as: str = ""


_ENTRIES: dict[str, FormatEntry] = {}
ENTRIES: Mapping[str, FormatEntry] = MappingProxyType(_ENTRIES)
"""Formats by their name in reports."""


def enter(name: str, endings: tuple[str, ...], place: str, written_as: str = "") -> None:
    """Enter a format in the table.

    Raises
    ------
    ValueError
        If its name or one of its endings is taken.
    """
    if name in _ENTRIES:
        raise ValueError(f"the format {name!r} is there already")
    for other, entry in _ENTRIES.items():
        for ending in set(endings) & set(entry.endings):
            raise ValueError(f"the ending .{ending} is that of {other}")
    _ENTRIES[name] = FormatEntry(endings, place, written_as)


enter("stl", ("stl",), "stl:STL")
enter("stl-ascii", (), "stl:TEXT_STL")
enter("obj", ("obj",), "obj:OBJ")
enter("ply", ("ply",), "ply:PLY")
enter("off", ("off",), "off:OFF")
enter("3mf", ("3mf",), "threemf:THREEMF")
enter("step", ("step", "stp"), "exact:STEP")
enter("glb", ("glb",), "gltf:GLB")
enter("gltf", ("gltf",), "gltf:GLTF", written_as="glb")
enter("dae", ("dae",), "foreign:DAE", written_as="3mf")
enter("3dxml", ("3dxml",), "foreign:THREEDXML", written_as="3mf")
enter("xaml", ("xaml",), "foreign:XAML", written_as="3mf")
enter("iges", ("iges", "igs"), "exact:IGES", written_as="step")
enter("brep", ("brep", "brp"), "exact:BREP", written_as="step")


def endings() -> tuple[str, ...]:
    """Return the endings of all files that can be read, each with its dot."""
    return tuple(f".{ending}" for entry in _ENTRIES.values() for ending in entry.endings)


def written_endings() -> tuple[str, ...]:
    """Return the endings of all files that can be written, each with its dot."""
    written = [entry for entry in _ENTRIES.values() if not entry.written_as]
    return tuple(f".{ending}" for entry in written for ending in entry.endings)
