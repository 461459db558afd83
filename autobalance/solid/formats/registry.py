"""The registry of mesh formats, by file ending, which is also the format's name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.formats.glb import read_glb, write_glb
from autobalance.solid.formats.obj_off import read_obj, read_off, write_obj, write_off
from autobalance.solid.formats.ply import read_ply, write_ply
from autobalance.solid.formats.raw import Raw
from autobalance.solid.formats.stl import is_binary, read_stl, write_ascii_stl, write_stl
from autobalance.solid.formats.threemf import UNITS, read_3mf, write_3mf
from autobalance.solid.mesh.mesh import Floats, Indices


@dataclass(frozen=True)
class Format:
    """How to read and write one kind of file.

    Attributes
    ----------
    read : callable
        Bytes of a file → its triangles.
    write : callable
        (vertices in the file's unit, triangles, mm per unit) → bytes.
    number : type
        What the file holds coordinates as: float32 or float64.
    exact : bool
        Whether the file keeps true surfaces; it is no mesh then, and ``read`` and ``write`` refuse.
    """

    read: Callable[[bytes], Raw]
    write: Callable[[Floats, Indices, float], bytes]
    number: type[np.float32] | type[np.float64]
    exact: bool = False


def _write_3mf(vertices: Floats, triangles: Indices, mm_per_unit: float) -> bytes:
    unit = next((name for name, mm in UNITS.items() if mm == mm_per_unit), None)
    if unit is None:
        raise FormatError(f"3MF has no unit of {mm_per_unit:g} mm; needed one of {', '.join(UNITS)}")
    return write_3mf(vertices, triangles, unit)


def _no_mesh(data: bytes) -> Raw:
    raise FormatError("a STEP file holds exact surfaces, no mesh")


def _no_step(vertices: Floats, triangles: Indices, mm_per_unit: float) -> bytes:
    raise FormatError("a mesh cannot be written as STEP; needed stl")


FORMATS: Final = {
    "stl": Format(lambda data: Raw(read_stl(data)), lambda v, t, _: write_stl(v, t), np.float32),
    "obj": Format(read_obj, lambda v, t, _: write_obj(v, t), np.float64),
    "ply": Format(read_ply, lambda v, t, _: write_ply(v, t), np.float64),
    "off": Format(read_off, lambda v, t, _: write_off(v, t), np.float64),
    "3mf": Format(read_3mf, _write_3mf, np.float64),
    "step": Format(_no_mesh, _no_step, np.float64, exact=True),
    "glb": Format(read_glb, lambda v, t, _: write_glb(v, t), np.float32),
}


TEXT_STL: Final = Format(lambda data: Raw(read_stl(data)), lambda v, t, _: write_ascii_stl(v, t), np.float64)
WRITTEN: Final = {**FORMATS, "stl-ascii": TEXT_STL}
"""What can be written, by the name that ``Source.format`` gives it: STL is of two kinds."""

ALIASES: Final = {"stp": "step"}
"""Other file endings of a format."""


def format_named(name: str) -> Format:
    """Return a format by its name.

    Raises
    ------
    FormatError
        If it is not one of those that can be read and written.
    """
    if name not in WRITTEN:
        raise FormatError(f"the format '{name}' cannot be written; needed one of {', '.join(WRITTEN)}")
    return WRITTEN[name]


def kind_of(name: str, data: bytes) -> str:
    """Return the name of the kind of a file, from that of its format and its bytes."""
    return "stl-ascii" if name == "stl" and not is_binary(data) else name
