"""Numbers typed with their unit."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from autobalance.toml_files.typed_units import LENGTHS, NUMBER, length_mm, unbalance_g_mm
from autobalance.units import G_MM_PER, G_PER


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


def _rpm(text: str, _: str) -> float:
    number = re.search(NUMBER, text)
    assert number is not None  # by the pattern
    return float(number[0]) * (1000.0 if "krpm" in text else 1.0)


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
    "1/min": TypedUnit(rf"\s*{NUMBER}\s*(k?rpm|1/min|r/min)\s*", "9500 rpm", _rpm),
    "share": TypedUnit(rf"\s*{NUMBER}\s*%\s*", "50 %", _percent),
    "mm/s": TypedUnit(rf"\s*G\s*{NUMBER}\s*", "G 6.3", _first_number()),
}
"""Units of numbers that may be typed with them."""
