"""Comparison of numbers without the last digits, in which processors differ: the first of equals wins.

Mirrored cuts have effects that are equal except for rounding. Which of them leaves less in the sixteenth
digit differs from processor to processor, and with it the plan would.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from autobalance.types import Array, Indices

DIGITS = 36
"""Binary digits that are kept: sums and products of some hundred numbers agree in more."""


def rounded(values: ArrayLike) -> Array:
    """Return numbers rounded to `DIGITS` binary digits each."""
    share, power = np.frexp(np.asarray(values, dtype=np.float64))
    return np.asarray(np.ldexp(np.round(np.ldexp(share, DIGITS)), power - DIGITS))


def key(value: float) -> float:
    return float(rounded(value))


def in_order(values: ArrayLike) -> Indices:
    """Return the indices of numbers, the least first; equal ones keep their order."""
    return np.argsort(rounded(values), kind="stable")


def is_less(one: float, other: float) -> bool:
    """Return whether one number is below another by more than rounding."""
    return key(one) < key(other)
