"""Units of a key's numbers, and how a number is typed with one."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from autobalance.job.toml.typed_units import LENGTHS, NUMBER, length_mm, unbalance_g_mm
from autobalance.units import G_MM_PER, G_PER

UNIT_BY_ENDING = {
    "_kg_mm2": "kg·mm²",
    "_kg_m3": "kg/m³",
    "_J_kg_K": "J/(kg·K)",
    "_mm2_s": "mm²/s",
    "_N_m_s_rad": "N·m·s/rad",
    "_N_m_rad": "N·m/rad",
    "_N_um": "N/µm",
    "_k_N_mm": "N/mm",  # of a spring
    "_N_mm": "N·mm",
    "_N_m": "N·m",
    "_n_mm": "N/mm",
    "_n_s_m": "N·s/m",
    "_n_m": "N/m",
    "_m_s2": "m/s²",
    "_Pa_s": "Pa·s",
    "_per_K": "1/K",
    "_cm3": "cm³",
    "_g_mm": "g·mm",
    "_oz_in": "oz·in",
    "_percent": "%",
    "_kg_mm": "kg·mm",
    "_rpm": "1/min",
    "_deg": "°",
    "_bar": "bar",
    "_gpa": "GPa",
    "_MPa": "MPa",
    "_um": "µm",
    "_mm": "mm",
    "_kg": "kg",
    "_oz": "oz",
    "_lb": "lb",
    "_hz": "Hz",
    "_g": "g",
    "_J": "J",
    "_K": "K",
    "_C": "°C",
    "_N": "N",
    "_s": "s",
}
"""Unit of a key's numbers, by the ending of its name; the first that fits."""


def unit_of_name(name: str) -> str:
    """Return the unit that a key's name ends in; empty: none.

    Examples
    --------
    >>> unit_of_name("pm_g_mm"), unit_of_name("flywheel_kg_mm2"), unit_of_name("g"), unit_of_name("order")
    ('g·mm', 'kg·mm²', 'g', '')
    """
    whole = f"_{name}"
    return next((unit for ending, unit in UNIT_BY_ENDING.items() if whole.endswith(ending)), "")


@dataclass(frozen=True)
class TypedUnit:
    """A number typed as a text: its pattern, an example, and its conversion."""

    pattern: str
    example: str
    number: Callable[[str, str], float]

    def fits(self, text: str) -> bool:
        """Return whether a text is such a number."""
        return re.fullmatch(self.pattern, text) is not None


def _first_number(scale: float = 1.0) -> Callable[[str, str], float]:
    def number(text: str, _: str) -> float:
        match = re.search(NUMBER, text)
        assert match is not None  # by the pattern
        return float(match[0]) * scale

    return number


def _grams(text: str, _: str) -> float:
    match = re.fullmatch(rf"\s*({NUMBER})\s*({'|'.join(G_PER)})\s*", text)
    assert match is not None  # by the pattern
    return float(match[1]) * G_PER[match[2]]


def _percent(text: str, _: str) -> float:
    return float(text.rstrip().removesuffix("%")) / 100.0


_LENGTH = rf"\s*({NUMBER}|(\d+\s+)?\d+\s*/\s*\d+)\s*({'|'.join(LENGTHS)})\s*"
_BETWEEN = r"[·.\-*\s]*"
_UNBALANCES = "|".join(
    _BETWEEN.join(f"[{each.lower()}{each.upper()}]" for each in name.replace("·", "")) for name in G_MM_PER
)
TYPED_UNITS = {
    "mm": TypedUnit(_LENGTH, "3/8 in", length_mm),
    "g·mm": TypedUnit(rf"\s*{NUMBER}\s*({_UNBALANCES})\s*", "0.5 oz-in", unbalance_g_mm),
    "g": TypedUnit(rf"\s*{NUMBER}\s*({'|'.join(G_PER)})\s*", "7.8 oz", _grams),
    "1/min": TypedUnit(rf"\s*{NUMBER}\s*(rpm|1/min|r/min)\s*", "9500 rpm", _first_number()),
    "share": TypedUnit(rf"\s*{NUMBER}\s*%\s*", "50 %", _percent),
    "mm/s": TypedUnit(rf"\s*G\s*{NUMBER}\s*", "G 6.3", _first_number()),
}
"""Units of numbers that may be typed with them."""
