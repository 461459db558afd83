"""What a file format says of itself: one object a format, at the end of the format's own file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autobalance.solid.formats.raw import Raw
from autobalance.solid.mesh.mesh import Floats, Indices

Reader = Callable[[bytes], Raw]
Writer = Callable[[Floats, Indices, float], bytes]


@dataclass(frozen=True)
class Format:
    """How to read and write one kind of file.

    Attributes
    ----------
    name : str
        As reports have it.
    endings : tuple of str
        Of its files, without the dot; none: another form of a format, told by the bytes.
    read : callable
        Bytes of a file → its triangles.
    write : callable
        (vertices in the file's unit, triangles, mm per unit) → bytes.
    number : type
        What the file holds coordinates as: float32 or float64.
    carries_unit : bool
        Whether the file says its unit of length.
    names_bodies : bool
        Whether its bodies have names.
    exact : bool
        Whether the file keeps true surfaces; it is no mesh then, and ``read`` and ``write`` refuse.
    mm_per_unit : float or None
        Of the one unit that the format prescribes, where it does.
    form_of : callable or None
        Tells the name of the form that a file has, where the format has several.
    """

    name: str
    endings: tuple[str, ...]
    read: Reader
    write: Writer
    number: type[np.float32] | type[np.float64]
    carries_unit: bool = False
    names_bodies: bool = False
    exact: bool = False
    mm_per_unit: float | None = None
    form_of: Callable[[bytes], str] | None = None
