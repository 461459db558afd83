"""Declaration of a file format, one object for each; digits and bytes of files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from autobalance.errors import FileError, file_errors, refuse_pipe
from autobalance.runtime import note_read
from autobalance.solid.formats.raw import Raw
from autobalance.types import Floats, Indices
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from autobalance.solid.cad.files import CadFile


# Declaration of a file format: one object for each, at the end of the format's own module.


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


# Common part of the formats of true surfaces, which the CAD kernel reads.


# Resolution of the numbers in a text file, from the digits that its writer gave them.


SAMPLE: Final = 4_000
"""Vertices of a sample of a file's."""
MIN_HABIT_SHARE: Final = 0.05
"""Share of numbers that show a writer's habit: fewer may be odd by chance, or by another hand."""


T = TypeVar("T")


def spread(rows: Sequence[T]) -> Sequence[T]:
    """Return at most some thousands of rows, evenly from all over."""
    return rows[:: max(1, len(rows) // SAMPLE)]


def step_of_text(words: Iterable[bytes]) -> float:
    """Return the step between two numbers that a text's digits distinguish at its far end; 0 if none does.

    Parameters
    ----------
    words : iterable of bytes
        Coordinates as they are written.

    Returns
    -------
    float
        In the file's unit: a power of ten.

    Notes
    -----
    Writers give each number so many places after the point (``%.3f``), or so many significant digits
    (``%.6g``), and many leave off zeros at the end. Of the first kind numbers of every size end at the same
    place; of the second the largest end soonest.

    Examples
    --------
    >>> step_of_text([b"12.346", b"0.251", b"3.5", b"-8.126", b"104", b"0.007"])
    0.001
    >>> step_of_text([b"12.3463", b"0.251337", b"-8.12609", b"104.001", b"1.23457e-05", b"3.14159"])
    0.001
    """
    places = np.array([place for place in map(_first_and_last, words) if place is not None])
    if not len(places):
        return 0.0
    first, last = places.T
    ends = [
        _quantile(last[first == size])
        for size in np.unique(first)
        if (first == size).sum() >= MIN_HABIT_SHARE * len(first)
    ]
    if len(ends) > 1 and ends.count(min(ends)) > 1:  # the same place at several sizes
        return float(10.0 ** min(ends))
    most_digits = 1 - _quantile(last - first)
    return float(10.0 ** (int(first.max()) + 1 - most_digits))


def _first_and_last(word: bytes) -> tuple[int, int] | None:
    """Return the powers of ten of a number's first and last digit; None of zero and of other text."""
    mantissa, _, power = word.lower().partition(b"e")
    whole, _, fraction = mantissa.lstrip(b"+-").partition(b".")
    digits = (whole + fraction).lstrip(b"0")
    if not digits.isdigit() or len(power) > 4:
        return None
    last = int(power or 0) - len(fraction)
    return last + len(digits) - 1, last


def _quantile(numbers: Indices) -> int:
    """Return the least number except for a share of ``MIN_HABIT_SHARE``."""
    return int(np.quantile(numbers, MIN_HABIT_SHARE, method="inverted_cdf"))


# The bytes of a file on disk.


LARGEST_BYTES = 2 << 30
"""Bytes of a solid's file at most: scanners write some hundred megabytes, and reading takes ten times as much
memory."""


def one_file_bytes(path: Path) -> bytes:
    """Return the bytes of a file.

    Raises
    ------
    FileError
        If it is missing, no regular file, or cannot be read.
    """
    with file_errors(f"read {path}"):
        if path.is_dir():
            raise FileError(f"{path} is a folder; expected a file")
        if not path.exists():
            raise FileError(f"{path} does not exist")
        refuse_pipe(path)
        note_read(path)
        size = path.stat().st_size
        if size > LARGEST_BYTES:
            raise FileError(
                f"{path} has {size / 2**30:.1f} GB; expected at most {LARGEST_BYTES >> 30} GB, "
                "a crank of 40 million triangles: decimate it"
            )
        return path.read_bytes()
