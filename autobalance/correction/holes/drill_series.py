"""The drills that shops have: whole and half millimetres, inch fractions, letters and numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import cache
from typing import Literal

from autobalance.units import MM_PER

Series = Literal["mm", "inch", "letter", "number"]
INCH_MM = MM_PER["inch"]
SAME_MM = 1e-6
"""Difference of two sizes up to which they are the same: rounding of inches."""
LETTERS_IN = (
    *(0.234, 0.238, 0.242, 0.246, 0.250, 0.257, 0.261, 0.266, 0.272, 0.277, 0.281, 0.290, 0.295),
    *(0.302, 0.316, 0.323, 0.332, 0.339, 0.348, 0.358, 0.368, 0.377, 0.386, 0.397, 0.404, 0.413),
)
"""Letter drills A to Z (ASME B94.11M) [in]."""
NUMBERS_IN = (
    *(0.2280, 0.2210, 0.2130, 0.2090, 0.2055, 0.2040, 0.2010, 0.1990, 0.1960, 0.1935),
    *(0.1910, 0.1890, 0.1850, 0.1820, 0.1800, 0.1770, 0.1730, 0.1695, 0.1660, 0.1610),
    *(0.1590, 0.1570, 0.1540, 0.1520, 0.1495, 0.1470, 0.1440, 0.1405, 0.1360, 0.1285),
    *(0.1200, 0.1160, 0.1130, 0.1110, 0.1100, 0.1065, 0.1040, 0.1015, 0.0995, 0.0980),
    *(0.0960, 0.0935, 0.0890, 0.0860, 0.0820, 0.0810, 0.0785, 0.0760, 0.0730, 0.0700),
    *(0.0670, 0.0635, 0.0595, 0.0550, 0.0520, 0.0465, 0.0430, 0.0420, 0.0410, 0.0400),
)
"""Number drills 1 to 60 (ASME B94.11M) [in]."""
SIXTY_FOURTHS = (*range(8, 32), *range(32, 65, 2))
"""Inch fractions: 1/8 to 1/2 by 1/64, to 1 by 1/32."""


@cache
def drills_of(series: Series) -> Mapping[str, float]:
    """Return the diameters of a series by the drills' names, thinnest first [mm]."""
    if series == "inch":
        return {f"{Fraction(part, 64)} in": part / 64.0 * INCH_MM for part in SIXTY_FOURTHS}
    if series == "letter":
        return {f"letter {chr(65 + k)}": size * INCH_MM for k, size in enumerate(LETTERS_IN)}
    if series == "number":
        numbers = reversed(list(enumerate(NUMBERS_IN, 1)))
        return {f"No. {number}": size * INCH_MM for number, size in numbers}
    return {f"{0.5 * half:g} mm": 0.5 * half for half in range(8, 51)}


def sizes_mm(series: Series | Iterable[Series | float]) -> tuple[float, ...]:
    """Return the diameters of a series, or of a list of series and diameters, thinnest first [mm]."""
    parts: Iterable[Series | float] = [series] if isinstance(series, str) else series
    sizes: list[float] = []
    for part in parts:
        sizes += drills_of(part).values() if isinstance(part, str) else [part]
    return tuple(sorted(set(sizes)))


def drill_name(series: Series | Iterable[Series | float] | None, diameter_mm: float) -> str | None:
    """Return the name of a drill in the named series; None where only its diameter is its name."""
    parts: Iterable[Series | float] = [series] if isinstance(series, str) else series or ()
    for part in parts:
        if isinstance(part, str) and part != "mm":
            for name, size in drills_of(part).items():
                if abs(size - diameter_mm) < SAME_MM:
                    return name
    return None
