"""Contents of a file before any check: loose triangles, and the unit if it carries one."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

import numpy as np

from autobalance.errors import FormatError
from autobalance.types import Array, Floats, Indices
from autobalance.value_classes import dataclass

BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""First bytes of texts from some editors."""
SHOWN_CHARACTERS = 40
"""Characters of a wrong line that an error shows."""
CORNERS_MOST = 100_000
"""Most corners of one face."""


@dataclass(frozen=True, eq=False)
class Raw:
    """Triangles of a file.

    Attributes
    ----------
    soup : (m, 3, 3) float32 or float64
        Corners in the file's unit, finite; m ≥ 1.
    unit : str or None
        Name of the unit, if the format carries one.
    mm_per_unit : float or None
        Its length [mm].
    vertices : int or None
        Number of shared vertices that the file lists, where it does.
    step : float
        Between two numbers that the file's digits distinguish at its far end, in its unit; 0: that of the
        type of ``soup``.
    """

    soup: Floats
    unit: str | None = None
    mm_per_unit: float | None = None
    vertices: int | None = None
    step: float = 0.0


def point_cloud(what: str, points: int) -> str:
    """Return the message on a file that lists points and no faces."""
    return (
        f"the {what} file holds {points} points and no triangles: a point cloud; expected faces; let the"
        " scanner's software make a mesh of it"
    )


def soup_of(vertices: Floats, triangles: Indices, what: str) -> Floats:
    """Return listed triangles as loose ones (m, 3, 3), after a check of their numbers.

    Raises
    ------
    FormatError If there is no triangle, a vertex number is out of range or a used coordinate is not finite.
    """
    if len(triangles) == 0:
        raise FormatError(
            point_cloud(what, len(vertices))
            if len(vertices)
            else f"the {what} file holds no triangles; expected at least one"
        )
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


class Polygons:
    """The polygons of a file, one after the other, in little memory."""

    def __init__(self, what: str) -> None:
        """Begin a list of polygons of a file of the format ``what``."""
        self._what = what
        self._counts = array("q")
        self._corners = array("q")

    def add(self, corners: Sequence[int]) -> None:
        """Append a polygon by its vertex numbers.

        Raises
        ------
        FormatError
            If it has more corners than any face of a part, or its numbers are beyond all count.
        """
        if len(corners) > CORNERS_MOST:
            raise FormatError(
                f"the {self._what} file has a face of {len(corners)} corners; expected at most {CORNERS_MOST}"
            )
        self._counts.append(len(corners))
        try:
            self._corners.extend(corners)
        except OverflowError:
            raise FormatError(
                f"the {self._what} file has a face with a vertex number of more than 63 bits"
            ) from None

    def triangles(self) -> Indices:
        """Return all polygons cut into triangles (m, 3)."""
        return fans(np.array(self._counts, dtype=np.int64), np.array(self._corners, dtype=np.int64))


def fans(counts: Indices, corners: Indices) -> Indices:
    """Cut polygons into triangles around their first corner; the signed volume is the polygon's own.

    ``counts`` (k,) are their numbers of corners, ``corners`` the corners of all, one after the other.
    """
    if (counts == 3).all():
        return corners.reshape(-1, 3)
    number = np.maximum(counts - 2, 0)
    first = np.repeat(np.cumsum(counts) - counts, number)
    second = first + 1 + np.arange(number.sum()) - np.repeat(np.cumsum(number) - number, number)
    return corners.take(np.stack([first, second, second + 1], axis=1))


def text_of(array: Array) -> list[str]:
    """Return each row of numbers (n, 3) with all their digits, separated by blanks."""
    return [f"{x!r} {y!r} {z!r}" for x, y, z in array.tolist()]


def shown(line: bytes) -> str:
    """Return the beginning of a line, for display in an error."""
    return line[:SHOWN_CHARACTERS].decode("ascii", "replace").replace("\n", " ")
