"""How the sheet writes lengths, masses and unbalance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from autobalance.graphics.words import GRAMS_PER_OUNCE, MM_PER_INCH, number

UnitSystem = Literal["metric", "inch"]


@dataclass(frozen=True)
class Units:
    """Names of units, and with how many decimals each is written."""

    length: str
    mass: str
    unbalance: str
    per_mm: float
    per_g: float
    length_digits: int
    mass_digits: int
    unbalance_digits: int

    @property
    def diameter_digits(self) -> int:
        """Of a drill: hundredths of a millimetre, or thousandths of an inch as drills are sold."""
        return 2 if self.length == "mm" else 3

    def mm(self, value: float | None, digits: int | None = None) -> str:
        """Return a length."""
        return plain(
            None if value is None else value * self.per_mm, self.length_digits if digits is None else digits
        )

    def g(self, value: float | None) -> str:
        """Return a mass."""
        return plain(None if value is None else value * self.per_g, self.mass_digits)

    def g_mm(self, value: float | None) -> str:
        """Return an unbalance."""
        return plain(None if value is None else value * self.per_g * self.per_mm, self.unbalance_digits)


UNITS: dict[str, Units] = {
    "metric": Units("mm", "g", "g·mm", 1.0, 1.0, 3, 2, 2),
    "inch": Units("in", "oz", "oz·in", 1.0 / MM_PER_INCH, 1.0 / GRAMS_PER_OUNCE, 4, 4, 5),
}


def plain(value: float | None, digits: int) -> str:
    """Return a number in characters that the PDF's built-in fonts have, thousands not parted."""
    return number(value, digits).replace("\u202f", "").replace("−", "-")
