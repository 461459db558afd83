"""What a file says before anything is checked: loose triangles, and the unit if it carries one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.errors import FormatError
from autobalance.solid.mesh.mesh import Array, Floats, Indices

SHOWN = 40
"""Characters of a wrong line that an error shows."""


@dataclass(frozen=True, eq=False)
class Raw:
    """Triangles of a file.

    Attributes
    ----------
    soup : (m, 3, 3) float32 or float64
        Corners in the file's unit, finite; m ≥ 1.
    unit : str or None
        Name of the unit, where the format carries one.
    mm_per_unit : float or None
        Its length [mm].
    vertices : int or None
        How many shared vertices the file lists, where it does.
    """

    soup: Floats
    unit: str | None = None
    mm_per_unit: float | None = None
    vertices: int | None = None


def soup_of(vertices: Floats, triangles: Indices, what: str) -> Floats:
    """Return loose triangles (m, 3, 3) of listed ones, after checking that they can be.

    Raises
    ------
    FormatError
        If there is none, a vertex number is out of range or a used coordinate is not finite.
    """
    if len(triangles) == 0:
        raise FormatError(f"the {what} file holds no triangles; needed at least one")
    wrong = (triangles < 0) | (triangles >= len(vertices))
    if wrong.any():
        number = int(triangles[wrong][0])
        raise FormatError(
            f"the {what} file has a face with vertex {number} (from 0) and lists {len(vertices)} vertices"
        )
    soup: Floats = vertices[triangles]
    if not np.isfinite(soup).all():
        raise FormatError(f"the {what} file has a face with a corner that is not finite")
    return soup


def fans(polygons: list[list[int]]) -> Indices:
    """Cut polygons into triangles around their first corner; the signed volume is the polygon's own."""
    triangles = [(p[0], p[k], p[k + 1]) for p in polygons for k in range(1, len(p) - 1)]
    return np.array(triangles, dtype=np.int64).reshape(-1, 3)


def text_of(array: Array) -> list[str]:
    """Return each row of numbers (n, 3) with all their digits, separated by blanks."""
    return [f"{x!r} {y!r} {z!r}" for x, y, z in array.tolist()]


def triangles_of(polygons: list[list[int]], what: str) -> Indices:
    """Cut the polygons of a text file into triangles; refuse vertex numbers beyond all count."""
    try:
        return fans(polygons)
    except OverflowError:
        raise FormatError(f"the {what} file has a face with a vertex number of more than 63 bits") from None


def shown(line: bytes) -> str:
    """Return the beginning of a line that an error shows."""
    return line[:SHOWN].decode("ascii", "replace").replace("\n", " ")
