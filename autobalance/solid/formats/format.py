"""Declaration of a file format: one object for each, at the end of the format's own module."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from autobalance.solid.formats.raw import Raw
from autobalance.types import Floats, Indices

if TYPE_CHECKING:
    from autobalance.solid.cad.cad_file import CadFile

Reader = Callable[[bytes], Raw]
Writer = Callable[[Floats, Indices, float], bytes]


@dataclass(frozen=True)
class Format:
    """Reader and writer of one kind of file, with its properties; the endings are in ``table.py``.

    Attributes
    ----------
    name : str
        As reports and ``table.py`` have it.
    read : callable
        Bytes of a file → its triangles.
    write : callable
        (vertices in the file's unit, triangles, mm per unit) → bytes.
    number : type
        Type of the file's coordinates: float32 or float64.
    carries_unit : bool
        Whether the file holds its unit of length.
    names_bodies : bool
        Whether its bodies have names.
    read_exact : callable or None
        Bytes of a file → its solids with true surfaces, where it keeps them; it is not a mesh then, and
        ``read`` and ``write`` refuse.
    mm_per_unit : float or None
        Millimetres in the one unit that the format prescribes, where it does.
    form_of : callable or None
        Returns the name of the form that a file has, where the format has several.
    states_no_unit : callable or None
        Path of a file → whether it leaves its unit out, where the format allows that.
    """

    name: str
    read: Reader
    write: Writer
    number: type[np.float32] | type[np.float64]
    carries_unit: bool = False
    names_bodies: bool = False
    read_exact: Callable[[bytes], CadFile] | None = None
    mm_per_unit: float | None = None
    form_of: Callable[[bytes], str] | None = None
    states_no_unit: Callable[[Path], bool] | None = None

    @property
    def exact(self) -> bool:
        """Whether its files keep true surfaces."""
        return self.read_exact is not None
