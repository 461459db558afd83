"""Resolution of the numbers in a text file, from the digits that its writer gave them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final, TypeVar

import numpy as np

from autobalance.types import Indices

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
