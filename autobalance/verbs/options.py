"""Numbers beside a verb's job, refused beyond any length, mass or speed of a crank."""

from __future__ import annotations

import math

from autobalance.declare import MIN_POSITIVE
from autobalance.errors import UsageError
from autobalance.toml_files.table import MAX_NUMBER


def positive(option: str, value: float) -> float:
    """Return a number that must be positive.

    Raises
    ------
    UsageError
        If it is not, or so small or large that nothing could be computed with it.
    """
    if not 0.0 < value < math.inf:
        raise UsageError(f"{option} is {value:g}; must be > 0")
    if not MIN_POSITIVE <= value <= MAX_NUMBER:
        raise UsageError(f"{option} is {value:g}; must be {MIN_POSITIVE:g} to {MAX_NUMBER:g}")
    return value


def place_mm(option: str, value: float) -> float:
    """Return a place on the axis [mm].

    Raises
    ------
    UsageError
        If it is not a number, or farther away than anything is.
    """
    if not math.isfinite(value):
        raise UsageError(f"{option} is {value:g}; must be a finite number [mm]")
    if abs(value) > MAX_NUMBER:
        raise UsageError(f"{option} is {value:g}; must be at most {MAX_NUMBER:g} mm in size")
    return value
