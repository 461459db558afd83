"""Fonts of the sheet: the PDF's own, and one in the package for names in other alphabets."""

from __future__ import annotations

import functools
from importlib import resources

FALLBACK = "DejaVuSans"
"""Font in the package for Latin, Greek and Cyrillic names; the PDF embeds the letters used."""
POINTS_PER_MM = 72.0 / 25.4
ELLIPSIS = "..."
SMALLEST_PT = 9.0
"""Smallest type: a sheet is read at a machine, at arm's length."""


def builtin(text: str) -> bool:
    """Return whether the PDF's built-in fonts have every character."""
    try:
        text.encode("cp1252")
    except UnicodeEncodeError:
        return False
    return True


@functools.cache
def _letters() -> frozenset[str]:
    """Register the package's font with reportlab; return the characters that it has."""
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont

    with resources.as_file(resources.files("autobalance.report") / "assets" / "DejaVuSans.ttf") as path:
        font = TTFont(FALLBACK, str(path))
    pdfmetrics.registerFont(font)
    return frozenset(map(chr, font.face.charToGlyph))


def safe(text: object) -> str:
    """Return a name in characters of the sheet's fonts; others become question marks."""
    name = "".join(letter if letter.isprintable() else "?" for letter in str(text))
    if builtin(name):
        return name
    return "".join(letter if letter in _letters() else "?" for letter in name)


def font_of(text: str, bold: bool = False, mono: bool = False) -> str:
    """Return the font for a text of ``safe`` characters."""
    if not builtin(text):
        return FALLBACK
    return "Courier" if mono else "Helvetica-Bold" if bold else "Helvetica"


def width_mm(text: str, size: float, bold: bool = False) -> float:
    """Return the width of a text [mm]."""
    from reportlab.pdfbase.pdfmetrics import stringWidth

    return float(stringWidth(text, font_of(text, bold), size)) / POINTS_PER_MM


def lines_of(text: str, size: float, room_mm: float) -> list[str]:
    """Return a text in lines that fit a width; a longer word is broken."""
    lines: list[str] = []
    for word in text.split(" "):
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and width_mm(longer, size) <= room_mm:
            lines[-1] = longer
        else:
            lines += _broken(word, size, room_mm)
    return lines


def _broken(word: str, size: float, room_mm: float) -> list[str]:
    parts = [""]
    for letter in word:
        if parts[-1] and width_mm(parts[-1] + letter, size) > room_mm:
            parts.append("")
        parts[-1] += letter
    return parts


def fitted(text: str, size: float, room_mm: float, least: float = SMALLEST_PT) -> float:
    """Return the font size at which a text fits, not below ``least``."""
    wide = width_mm(text, size)
    return size if wide <= room_mm else max(least, size * room_mm / wide)


def shortened(text: str, size: float, room_mm: float) -> str:
    """Return a text that fits, an ellipsis in its middle where it is too long."""
    if width_mm(text, size) <= room_mm:
        return text
    for kept in range(len(text) - 1, 0, -1):
        tail = kept // 2
        short = text[: kept - tail] + ELLIPSIS + text[len(text) - tail :]
        if width_mm(short, size) <= room_mm:
            return short
    return ELLIPSIS
