"""Decimal commas in numbers that can be nothing else: read, with a warning.

A comma separates in TOML, so a file with one in a number is not TOML, or the number is a text. ``221,5`` is
then 221.5. ``15,200`` may be fifteen thousand, and stays refused.
"""

from __future__ import annotations

import re
import warnings
from typing import Final

NUMBER: Final = r"[+-]?(\d+),(\d+)"
"""A number with one comma: its digits before and after it."""
TYPED = re.compile(rf"{NUMBER}(?![.,\d])")
IN_TOML = re.compile(rf"(?<==)(\s*)({NUMBER})(?=\s*(?:#.*)?$|\s*}}|\s*,\s*[A-Za-z_][\w-]*\s*=)")
"""Such a number as a whole value, alone in its line or in a table in braces, never in a list."""
THOUSANDS: Final = 3
"""Digits of a group of thousands."""


class DecimalCommaWarning(UserWarning):
    """A number was read with its comma as the decimal point."""


def is_decimal(whole: str, fraction: str) -> bool:
    """Return whether the comma between digits can be nothing but a decimal point.

    Examples
    --------
    >>> is_decimal("221", "5"), is_decimal("15", "200"), is_decimal("0", "284"), is_decimal("1234", "567")
    (True, False, True, True)
    """
    return len(fraction) != THOUSANDS or whole.startswith("0") or len(whole) > THOUSANDS


def point_for_comma(text: str) -> str:
    """Return a typed number with its unit with a point for a decimal comma; other texts as they are.

    Examples
    --------
    >>> point_for_comma("221,5 g"), point_for_comma("15,200"), point_for_comma("8, 5"), point_for_comma("0.5")
    ('221.5 g', '15,200', '8, 5', '0.5')
    """
    found = TYPED.match(text.strip())
    if found is None or not is_decimal(found[1], found[2]):
        return text
    return text.replace(",", ".", 1)


def with_points(text: str) -> tuple[str, list[tuple[int, str]]]:
    """Return a TOML text with points for decimal commas, and each such number with its line."""
    told: list[tuple[int, str]] = []
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):

        def point(found: re.Match[str], number: int = number) -> str:
            if not is_decimal(found[3], found[4]):
                return found[0]
            told.append((number, found[2]))
            return found[1] + found[2].replace(",", ".")

        lines[number - 1] = IN_TOML.sub(point, line)
    return "\n".join(lines), told


def tell(where: str, typed: str) -> None:
    """Warn of a number that was read with its comma as the decimal point."""
    read = typed.strip().replace(",", ".", 1)
    words = f"{where}: {typed.strip()} is read as {read}; the comma is a decimal point"
    warnings.warn(words, DecimalCommaWarning, stacklevel=2)
