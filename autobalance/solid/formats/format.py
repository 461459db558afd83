"""What a file format declares: one object a format, at the end of the format's own file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
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
    """How to read and write one kind of file; the endings of such files stand in ``table.py``.

    Attributes
    ----------
    name : str
        As reports and ``table.py`` have it.
    read : callable
        Bytes of a file → its triangles.
    write : callable
        (vertices in the file's unit, triangles, mm per unit) → bytes.
    number : type
        What the file holds coordinates as: float32 or float64.
    carries_unit : bool
        Whether the file holds its unit of length.
    names_bodies : bool
        Whether its bodies have names.
    read_exact : callable or None
        Bytes of a file → its solids with true surfaces, where it keeps them; it is not a mesh then, and
        ``read`` and ``write`` refuse.
    mm_per_unit : float or None
        Of the one unit that the format prescribes, where it does.
    form_of : callable or None
        Returns the name of the form that a file has, where the format has several.
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

    @property
    def exact(self) -> bool:
        """Whether its files keep true surfaces."""
        return self.read_exact is not None
