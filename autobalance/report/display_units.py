"""The units in which text, pages and paper show lengths, masses and unbalance; files stay metric."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextvars import ContextVar
from dataclasses import replace
from typing import Final, Literal

from autobalance.declare import Floats
from autobalance.quantities import Quantity, rendered
from autobalance.units import G_MM_PER, G_MM_PER_OZ_IN, G_PER, G_PER_KG, G_PER_OZ, MM_PER
from autobalance.value_classes import dataclass
from autobalance.wording import angle_deg, degrees, number

# The units in which text and paper show lengths, masses and unbalance; files stay metric.


UnitSystem = Literal["metric", "inch"]
KG_MM2_PER_LB_IN2 = G_PER["lb"] / G_PER_KG * MM_PER["inch"] ** 2


@dataclass(frozen=True)
class DisplayUnits:
    """Names, sizes and decimals of the units in which values are shown."""

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

    def of_size(self, value_mm: float) -> str:
        """Return a depth or diameter with its unit, without zeros at its end: as a machine is set to it."""
        shown = fixed(value_mm / self.mm_per_length, self.length_digits)
        return f"{shown.rstrip('0').rstrip('.')} {self.length}"

    def of_place(self, value_mm: float) -> str:
        """Return a place on the crank with its unit, a decimal less than a size."""
        return f"{fixed(value_mm / self.mm_per_length, self.length_digits - 1)} {self.length}"

    @property
    def is_metric(self) -> bool:
        return self.length == "mm"

    def of_mass(self, value_g: float) -> str:
        """Return a mass with its unit."""
        return f"{fixed(value_g / self.g_per_mass, self.mass_digits)} {self.mass}"

    def of_bob_weight(self, value_g: float) -> str:
        """Return a bob-weight in grams, in which its parts are weighed everywhere."""
        return f"{fixed(value_g, 2)} g"

    def of_unbalance(self, value_g_mm: float) -> str:
        """Return an unbalance with its unit."""
        return f"{fixed(value_g_mm / self.g_mm_per_unbalance, self.unbalance_digits)} {self.unbalance}"

    def heavy_at(self, size_g_mm: float, angle_deg: float, digits: int = 1) -> str:
        """Return the angle of an unbalance for a cell; a dash where the unbalance shows as zero.

        Examples
        --------
        >>> ON_SCREEN["metric"].heavy_at(0.004, 90.0), ON_SCREEN["metric"].heavy_at(0.006, 90.0)
        ('–', '90.0°')
        """
        return self.pointing(size_g_mm, angle_deg, digits, "") or number(None)

    def pointing(self, size_g_mm: float, angle_deg: float, digits: int = 1, before: str = " at ") -> str:
        """Return the angle of an unbalance after some text; empty where the unbalance shows as zero."""
        shown = round(size_g_mm / self.g_mm_per_unbalance, self.unbalance_digits)
        return f"{before}{degrees(angle_deg, digits)}" if shown else ""

    def of_vector(self, size_g_mm: float, angle_deg: float, doubt: str = "") -> str:
        """Return an unbalance with unit and uncertainty, and its angle unless it shows as zero."""
        return f"{self.of_unbalance(size_g_mm)}{doubt}{self.pointing(size_g_mm, angle_deg)}"

    def of_quantity(self, quantity: Quantity) -> str:
        """Return a quantity of a text with its unit."""
        if self.is_metric:
            return quantity.metric
        pattern, values = quantity.pattern, quantity.values
        if quantity.unit == "mm":
            return f"{_filled(pattern, values, self.mm_per_length, self.length_digits)} {self.length}"
        if quantity.unit == "g":
            return f"{_filled(pattern, values, self.g_per_mass, self.mass_digits)} {self.mass}"
        values = tuple(each * MM_PER["m"] for each in values) if quantity.unit == "g·m" else values
        shown = _filled(pattern, values, self.g_mm_per_unbalance, self.unbalance_digits)
        return f"{shown} {self.unbalance}"

    def of_volume(self, value_mm3: float) -> str:
        """Return a volume with its unit."""
        return (
            f"{fixed(value_mm3, 1)} mm³"
            if self.is_metric
            else f"{fixed(value_mm3 / MM_PER['inch'] ** 3, 3)} in³"
        )

    def of_area(self, value_mm2: float) -> str:
        """Return an area with its unit."""
        return (
            f"{fixed(value_mm2, 0)} mm²"
            if self.is_metric
            else f"{fixed(value_mm2 / MM_PER['inch'] ** 2, 2)} in²"
        )

    def of_inertia(self, value_kg_mm2: float, digits: int = 3, sign: str = "") -> str:
        """Return an inertia with its unit."""
        per, name = (1.0, "kg·mm²") if self.is_metric else (KG_MM2_PER_LB_IN2, "lb·in²")
        return f"{round(value_kg_mm2 / per, digits) + 0.0:{sign}.{digits}f} {name}"

    @property
    def diameter_digits(self) -> int:
        """Decimals of a drill's diameter: 2 in mm, 3 in inches, as drills are sold."""
        return 2 if self.length == "mm" else 3

    def mm(self, value: float | None, digits: int | None = None) -> str:
        """Return a length for a cell of a table: no unit, a dash for None."""
        shown = None if value is None else value / self.mm_per_length
        return plain(shown, self.length_digits if digits is None else digits)

    def g(self, value: float | None) -> str:
        """Return a mass for a cell of a table: no unit, a dash for None."""
        return plain(None if value is None else value / self.g_per_mass, self.mass_digits)

    def g_mm(self, value: float | None) -> str:
        """Return an unbalance for a cell of a table: no unit, a dash for None."""
        return plain(None if value is None else value / self.g_mm_per_unbalance, self.unbalance_digits)


def both_g_mm(value_g_mm: float | None, u: DisplayUnits) -> str:
    """Return an unbalance for a cell, ounce-inches with gram-inches in brackets."""
    shown = u.g_mm(value_g_mm)
    return (
        shown if u.is_metric or value_g_mm is None else f"{shown} ({plain(value_g_mm / G_MM_PER['g·in'], 2)})"
    )


def both_g(value_g: float, u: DisplayUnits) -> str:
    """Return a bob-weight for a cell: grams, with ounces in brackets where ounces are chosen."""
    return plain(value_g, 2) if u.is_metric else f"{plain(value_g, 2)} ({u.g(value_g)})"


def in_units(text: str, u: DisplayUnits) -> str:
    """Return a text with its quantities in some units; a plain string, which has no quantities, unchanged.

    Examples
    --------
    >>> from autobalance.quantities import g_mm, mm, said
    >>> in_units(said("add {} at z {}", g_mm(720.0779, ".1f"), mm(25.4, ".1f")), ON_SCREEN["inch"])
    'add 1.0000 oz·in at z 1.0000 in'
    """
    return text if u.is_metric else rendered(text, u.of_quantity)


def _filled(pattern: str, values: Sequence[float], per: float, digits: int) -> str:
    return pattern.format(*(fixed(each / per, digits) for each in values))


def fixed(value: float, digits: int) -> str:
    """Return a number with a fixed number of decimals, and no sign before a zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def plain(value: float | None, digits: int) -> str:
    """Return a number in characters of the PDF's built-in fonts, without separators of thousands."""
    return number(value, digits).replace("\u202f", "").replace("−", "-")


ON_SCREEN: Final[Mapping[str, DisplayUnits]] = {
    "metric": DisplayUnits("mm", 1.0, 3, "g", 1.0, 2, "g·mm", 1.0, 2),
    "inch": DisplayUnits("in", MM_PER["inch"], 4, "oz", G_PER_OZ, 3, "oz·in", G_MM_PER_OZ_IN, 4),
}
# A machinist weighs chips against the sheet: a digit more where an ounce is too coarse.
ON_PAPER: Final[Mapping[str, DisplayUnits]] = {
    "metric": ON_SCREEN["metric"],
    "inch": replace(ON_SCREEN["inch"], mass_digits=4, unbalance_digits=5),
}


# Values of a report in the units of the page that is being written.


PAGE_UNITS: ContextVar[DisplayUnits] = ContextVar("PAGE_UNITS", default=ON_SCREEN["metric"])
"""The units of the page that is being written."""
PAGE_ZERO_DEG: ContextVar[float] = ContextVar("PAGE_ZERO_DEG", default=0.0)
"""The zero of its angles, counter-clockwise from crankpin 1: that of the sheet [°]."""


def unbalance(value_g_mm: float | None, digits: int = 2) -> str:
    """Return an unbalance in the page's units, without their name."""
    value, digits = shown(value_g_mm, "_g_mm", digits)
    return number(value, digits)


def heavy_at(vector_g_mm: Floats, digits: int = 0) -> str:
    """Return the angle of an unbalance; a dash where the unbalance shows as zero."""
    return pointing(vector_g_mm, digits, "") or number(None)


def pointing(vector_g_mm: Floats, digits: int = 0, before: str = " at ") -> str:
    """Return the angle of an unbalance after some text; empty where the unbalance shows as zero."""
    angle = (angle_deg(vector_g_mm) - PAGE_ZERO_DEG.get()) % 360.0
    return PAGE_UNITS.get().pointing(math.hypot(*vector_g_mm), angle, digits, before)


def length(value_mm: float | None, digits: int = 3) -> str:
    """Return a length in the page's units, without their name."""
    value, digits = shown(value_mm, "_mm", digits)
    return number(value, digits)


def mass(value_g: float | None, digits: int = 2) -> str:
    """Return a mass in the page's units, without their name."""
    value, digits = shown(value_g, "_g", digits)
    return number(value, digits)


def inertia_unit() -> str:
    return "kg·mm²" if PAGE_UNITS.get().is_metric else "lb·in²"


def shown(value: float | None, path: str, digits: int) -> tuple[float | None, int]:
    """Return a value in the page's units, chosen by the end of its key, and its decimals."""
    u = PAGE_UNITS.get()
    if u.is_metric or value is None:
        return value, digits
    ends = {
        "_kg_mm2": (KG_MM2_PER_LB_IN2, 4),
        "_g_mm": (u.g_mm_per_unbalance, u.unbalance_digits),
        "_mm": (u.mm_per_length, u.length_digits),
        "_g": (u.g_per_mass, u.mass_digits),
    }
    for end, (per, own) in ends.items():
        if path.endswith(end) or f"{end}." in path.rpartition(".")[0] + ".":
            return value / per, own
    return value, digits
