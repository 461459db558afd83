"""The units in which text and paper show lengths, masses and unbalance; files stay metric."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

from autobalance.units import G_MM_PER, G_MM_PER_OZ_IN, G_PER, G_PER_KG, G_PER_OZ, MM_PER
from autobalance.wording import degrees, number

UnitSystem = Literal["metric", "inch"]
KG_MM2_PER_LB_IN2 = G_PER["lb"] / G_PER_KG * MM_PER["inch"] ** 2


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

    @property
    def is_metric(self) -> bool:
        """Whether lengths are in mm."""
        return self.length == "mm"

    def of_mass(self, value_g: float) -> str:
        """Return a mass with its unit; ounces with grams, which most scales show."""
        shown = f"{fixed(value_g / self.g_per_mass, self.mass_digits)} {self.mass}"
        return shown if self.is_metric else f"{shown} ({fixed(value_g, 2)} g)"

    def of_bob_weight(self, value_g: float) -> str:
        """Return a bob-weight with its unit: grams first, in which its parts are weighed everywhere."""
        shown = f"{fixed(value_g, 2)} g"
        return (
            shown
            if self.is_metric
            else f"{shown} ({fixed(value_g / self.g_per_mass, self.mass_digits)} {self.mass})"
        )

    def of_unbalance(self, value_g_mm: float) -> str:
        """Return an unbalance with its unit; ounce-inches with gram-inches, which machines show."""
        shown = f"{fixed(value_g_mm / self.g_mm_per_unbalance, self.unbalance_digits)} {self.unbalance}"
        return shown if self.is_metric else f"{shown} ({fixed(value_g_mm / G_MM_PER['g·in'], 2)} g·in)"

    def heavy_at(self, size_g_mm: float, angle_deg: float, digits: int = 1) -> str:
        """Return where an unbalance points, as a cell holds it; a dash where none of it is shown.

        Examples
        --------
        >>> ON_SCREEN["metric"].heavy_at(0.004, 90.0), ON_SCREEN["metric"].heavy_at(0.006, 90.0)
        ('–', '90.0°')
        """
        return self.pointing(size_g_mm, angle_deg, digits, "") or number(None)

    def pointing(self, size_g_mm: float, angle_deg: float, digits: int = 1, before: str = " at ") -> str:
        """Return the angle of an unbalance after some text; nothing where none of it is shown."""
        shown = round(size_g_mm / self.g_mm_per_unbalance, self.unbalance_digits)
        return f"{before}{degrees(angle_deg, digits)}" if shown else ""

    def of_vector(self, size_g_mm: float, angle_deg: float, doubt: str = "") -> str:
        """Return an unbalance with its unit, its doubt, and where it points if any of it is shown."""
        return f"{self.of_unbalance(size_g_mm)}{doubt}{self.pointing(size_g_mm, angle_deg)}"

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


def both_g_mm(value_g_mm: float | None, u: DisplayUnits) -> str:
    """Return an unbalance as a cell holds it, that in ounce-inches with gram-inches in brackets."""
    shown = u.g_mm(value_g_mm)
    return (
        shown if u.is_metric or value_g_mm is None else f"{shown} ({plain(value_g_mm / G_MM_PER['g·in'], 2)})"
    )


def both_g(value_g: float, u: DisplayUnits) -> str:
    """Return a bob-weight as a cell holds it: grams first, in brackets ounces where those are chosen."""
    return plain(value_g, 2) if u.is_metric else f"{plain(value_g, 2)} ({u.g(value_g)})"


def in_units(text: str, u: DisplayUnits) -> str:
    """Return a text of the report, which is metric, with the lengths, masses and unbalances in it converted.

    Examples
    --------
    >>> in_units("add 720.1 g·mm at z 25.4 mm", ON_SCREEN["inch"])
    'add 1.0000 oz·in (28.35 g·in) at z 1.0000 in'
    """
    if u.is_metric:
        return text
    of = {"g·mm": u.of_unbalance, "mm": u.of_length, "g": u.of_mass}
    return QUANTITY.sub(
        lambda match: of[match[2]](float(match[1].replace("−", "-").replace("\u202f", ""))), text
    )


QUANTITY = re.compile(
    r"(?<![\w.])([-−]?\d[\d\u202f]*(?:\.\d+)?(?:e[+-]?\d+)?)[ \u00a0](g·mm|mm|g)(?![\w·²³/])"
)
"""A number with its unit, in prose."""


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
