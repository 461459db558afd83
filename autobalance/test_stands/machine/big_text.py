"""A machine's vectors in letters that are read from three metres, and as reading.toml once they settle."""

from __future__ import annotations

import cmath
import json
import math
from collections.abc import Mapping
from typing import Any

from autobalance.report.reading_template import UMAR_G_MM, URR_PERCENT
from autobalance.units import wrapped_deg
from autobalance.wording import degrees

GLYPHS: Mapping[str, tuple[str, ...]] = {
    "0": ("███", "█ █", "█ █", "█ █", "███"),
    "1": (" █ ", "██ ", " █ ", " █ ", "███"),
    "2": ("███", "  █", "███", "█  ", "███"),
    "3": ("███", "  █", "███", "  █", "███"),
    "4": ("█ █", "█ █", "███", "  █", "  █"),
    "5": ("███", "█  ", "███", "  █", "███"),
    "6": ("███", "█  ", "███", "█ █", "███"),
    "7": ("███", "  █", "  █", "  █", "  █"),
    "8": ("███", "█ █", "███", "█ █", "███"),
    "9": ("███", "█ █", "███", "  █", "███"),
    ".": ("  ", "  ", "  ", "  ", "█ "),
    "°": ("██", "██", "  ", "  ", "  "),
    "A": (" █ ", "█ █", "███", "█ █", "█ █"),
    "B": ("██ ", "█ █", "██ ", "█ █", "██ "),
    " ": ("  ", "  ", "  ", "  ", "  "),
}


def big_text(text: str) -> str:
    """Return a text in letters five lines high, each dot two columns wide, without unknown characters.

    Examples
    --------
    >>> print(big_text("1").replace("█", "#"))
      ##
    ####
      ##
      ##
    ######
    """
    known = [GLYPHS[each] for each in text if each in GLYPHS]
    lines = [" ".join(glyph[row] for glyph in known) for row in range(5)]
    return "\n".join("".join(2 * dot for dot in line).rstrip() for line in lines)


def vectors_text(vectors: Mapping[str, complex]) -> str:
    """Return vectors in one line: amount and angle of each plane, in the machine's sense of angles."""
    parts = (
        f"{name or 'resultant'} {abs(each):.1f} g·mm" + _pointing(each, " at ")
        for name, each in vectors.items()
    )
    return "   ".join(parts)


def big_vectors(vectors: Mapping[str, complex]) -> str:
    """Return vectors in large letters, one plane below the other: g·mm and degrees."""
    blocks = (
        big_text(f"{name} {abs(each):.1f}{_pointing(each, '  ')}".strip()) for name, each in vectors.items()
    )
    return "\n\n".join(blocks)


def settled_toml(vectors: Mapping[str, complex], reading: Mapping[str, Any], speed_rpm: float | None) -> str:
    """Return settled vectors as the reading that ``recut`` takes."""
    usual = "usual of a hard-bearing machine in order"
    urr, umar = reading["urr_percent"], reading["umar_g_mm"]
    lines = [
        "# Settled vectors, as the machine wrote them.",
        *([] if speed_rpm is None else [f"speed_rpm = {speed_rpm!r}"]),
        f"urr_percent = {URR_PERCENT}   # {usual}" if urr is None else f"urr_percent = {urr!r}",
        f"umar_g_mm = {UMAR_G_MM}   # {usual}" if umar is None else f"umar_g_mm = {umar!r}",
        f"rotation = {json.dumps(reading['rotation'])}",
        f"zero_deg = {reading['zero_deg']!r}",
        f"reads = {json.dumps(reading['reads'])}",
    ]
    for name, each in vectors.items():
        lines += ["", "[[plane]]", *([f'at = "{name}"'] if name else [])]
        lines += [f"g_mm = {round(abs(each), 6)!r}", f"angle_deg = {round(_degrees(each), 6)!r}"]
    return "\n".join(lines) + "\n"


def _pointing(vector: complex, before: str) -> str:
    """Return the angle of a vector after some text; empty for a vector that is shown as 0.0."""
    return f"{before}{degrees(_degrees(vector), 0)}" if round(abs(vector), 1) else ""


def _degrees(vector: complex) -> float:
    return wrapped_deg(math.degrees(cmath.phase(vector)))
