"""The units in which text and paper show lengths, masses and unbalance; files stay metric."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

from autobalance.units import G_MM_PER_OZ_IN, G_PER_OZ, MM_PER
from autobalance.wording import number

UnitSystem = Literal["metric", "inch"]


@dataclass(frozen=True)
class DisplayUnits:
    """Names of units, what one of each holds, and with how many decimals each is written."""

    length: str
    mm_per_length: float
    length_digits: int
    mass: str
    g_per_mass: float
    mass_digits: int
    unbalance: str
    g_mm_per_unbalance: float
    unbalance_digits: int

    def of_length(self, value_mm: float) -> str:
        """Return a length with its unit."""
        return f"{fixed(value_mm / self.mm_per_length, self.length_digits)} {self.length}"

    def of_mass(self, value_g: float) -> str:
        """Return a mass with its unit."""
        return f"{value_g / self.g_per_mass:.{self.mass_digits}f} {self.mass}"

    def of_unbalance(self, value_g_mm: float) -> str:
        """Return an unbalance with its unit."""
        return f"{value_g_mm / self.g_mm_per_unbalance:.{self.unbalance_digits}f} {self.unbalance}"

    @property
    def diameter_digits(self) -> int:
        """Of a drill: hundredths of a millimetre, or thousandths of an inch as drills are sold."""
        return 2 if self.length == "mm" else 3

    def mm(self, value: float | None, digits: int | None = None) -> str:
        """Return a length as a cell of a table holds it: no unit, a dash for None."""
        shown = None if value is None else value / self.mm_per_length
        return plain(shown, self.length_digits if digits is None else digits)

    def g(self, value: float | None) -> str:
        """Return a mass as a cell of a table holds it."""
        return plain(None if value is None else value / self.g_per_mass, self.mass_digits)

    def g_mm(self, value: float | None) -> str:
        """Return an unbalance as a cell of a table holds it."""
        return plain(None if value is None else value / self.g_mm_per_unbalance, self.unbalance_digits)


def fixed(value: float, digits: int) -> str:
    """Return a number with so many decimals, and no sign before a zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def plain(value: float | None, digits: int) -> str:
    """Return a number in characters that the PDF's built-in fonts have, thousands not parted."""
    return number(value, digits).replace("\u202f", "").replace("−", "-")


ON_SCREEN: Final[Mapping[str, DisplayUnits]] = {
    "metric": DisplayUnits("mm", 1.0, 3, "g", 1.0, 2, "g·mm", 1.0, 2),
    "inch": DisplayUnits("in", MM_PER["inch"], 4, "oz", G_PER_OZ, 3, "oz·in", G_MM_PER_OZ_IN, 4),
}
# a machinist weighs chips against the sheet: a digit more of what an ounce is too coarse for
ON_PAPER: Final[Mapping[str, DisplayUnits]] = {
    "metric": ON_SCREEN["metric"],
    "inch": replace(ON_SCREEN["inch"], mass_digits=4, unbalance_digits=5),
}
