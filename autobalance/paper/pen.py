"""A pen on paper: lines, letters."""

from __future__ import annotations

import functools
import io
import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from importlib import resources
from typing import Any, ClassVar

import numpy as np

from autobalance.solid.csg.region import Polygons
from autobalance.types import Array

# Fonts of the sheet: the PDF's own, and one in the package for names in other alphabets.


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


NUMERAL_GAP_MM = 0.6
"""Gap between the two numerals at a mark of a degree wheel."""


def numeral_width_mm(text: str, other: str) -> float:
    """Return the width of a numeral and another one behind it, "" for none [mm]."""
    own = width_mm(text, SMALLEST_PT, True)
    return own + (NUMERAL_GAP_MM + width_mm(other, SMALLEST_PT) if other else 0.0)


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


# Drawing on a page in mm, right and down from the upper left corner of a box.


INK, SOFT, RULE, ACCENT, METAL, GONE = "#17191c", "#5d636b", "#c9c9c4", "#1c5d8f", "#e4e6e8", "#b5400f"
ADDED_COLOUR = "#0b6e4f"
SLUG = "#cfe6dc"
"""Ground of a slug in its bore."""
POINT_SPACING_MM = 0.3
"""Along an arc of 5 mm radius a chord this long is 0.002 mm off."""
CORNER_RAD = math.radians(4.0)
HATCH_MM = 2.0
BADGE_MM = 2.2
"""Radius of the disc around a number."""
CENTRE_LINE = (5.0, 1.2, 1.0, 1.2)

ToPage = Callable[[Array], Array]


@lru_cache
def paint(colour: str) -> Any:
    """Return a colour of reportlab; to parse its name takes as long as to draw a line."""
    from reportlab.lib.colors import toColor

    return toColor(colour)


def thinned(places: Array) -> Array:
    """Return a closed outline (k, 2) [mm] without points that a printer cannot show; corners stay."""
    side = np.roll(places, -1, axis=0) - places
    before = np.roll(side, 1, axis=0)
    turn = np.arctan2(before[:, 0] * side[:, 1] - before[:, 1] * side[:, 0], np.sum(before * side, axis=1))
    walked = np.cumsum(np.hypot(*before.T)) // POINT_SPACING_MM
    kept = (np.abs(turn) > CORNER_RAD) | (walked != np.roll(walked, 1))
    return places[kept] if kept.sum() >= 3 else places


def badge_size(text: str) -> float:
    """Return the font size of a number in its disc."""
    return SMALLEST_PT


def badge_width_mm(text: str) -> float:
    """Return the width of the disc around a number, or around several."""
    if len(text) <= 2:
        return 2.0 * BADGE_MM
    return max(2.0 * BADGE_MM, width_mm(text, badge_size(text), True) + 2.2)


class Pen:
    """A pen on a canvas of reportlab, in a box ``height_mm`` high.

    ``text_ratio`` is the largest width of a text on the page compared with paper's.
    """

    text_ratio: ClassVar[float] = 1.0

    def __init__(self, canvas: Any, height_mm: float) -> None:
        self.canvas, self.height_mm = canvas, height_mm

    def y(self, down: float) -> float:
        """Return the canvas's coordinate [points] of a distance down from the top of the box [mm]."""
        return (self.height_mm - down) * POINTS_PER_MM

    def text(
        self, x: float, down: float, text: str, size: float = SMALLEST_PT, colour: str = INK, *,
        bold: bool = False, mono: bool = False, align: str = "left",
    ) -> None:  # fmt: skip
        """Write a text, its base line at ``down``."""
        if not text:
            return
        self.canvas.setFont(font_of(text, bold, mono), size)
        self.canvas.setFillColor(paint(colour))
        draw = {"left": "drawString", "right": "drawRightString", "centre": "drawCentredString"}[align]
        getattr(self.canvas, draw)(x * POINTS_PER_MM, self.y(down), text)

    def numeral(self, x: float, down: float, side: float, text: str, other: str) -> None:
        """Write a numeral in bold, and another one behind it in a soft colour.

        ``side`` is the share of their width, -0.5 to 0.5, by which their middle is right of ``x``.
        """
        left = x + (side - 0.5) * numeral_width_mm(text, other)
        self.text(left, down, text, SMALLEST_PT, INK, bold=True)
        behind = left + width_mm(text, SMALLEST_PT, True) + NUMERAL_GAP_MM
        self.text(behind, down, other, SMALLEST_PT, SOFT)

    def run(self, down: float, pieces: Sequence[tuple[float, str, float]], colour: str = INK) -> None:
        """Write texts (x, text, size) on one line as one run, for programs that read the text."""
        run = self.canvas.beginText()
        run.setFillColor(paint(colour))
        for x, text, size in pieces:
            run.setFont(font_of(text), size)
            run.setTextOrigin(x * POINTS_PER_MM, self.y(down))
            run.textOut(text)
        self.canvas.drawText(run)

    def _stroke(self, colour: str, width_mm: float, dash: Sequence[float] = ()) -> None:
        self.canvas.setStrokeColor(paint(colour))
        self.canvas.setLineWidth(width_mm * POINTS_PER_MM)
        self.canvas.setDash(*([[d * POINTS_PER_MM for d in dash], 0] if dash else [[], 0]))

    def line(
        self, x0: float, y0: float, x1: float, y1: float, colour: str = RULE, width_mm: float = 0.15,
        dash: Sequence[float] = (),
    ) -> None:  # fmt: skip
        self._stroke(colour, width_mm, dash)
        self.canvas.line(x0 * POINTS_PER_MM, self.y(y0), x1 * POINTS_PER_MM, self.y(y1))

    def circle(
        self, x: float, down: float, radius: float, colour: str = INK, width_mm: float = 0.2,
        fill: str | None = None, dash: Sequence[float] = (),
    ) -> None:  # fmt: skip
        self._stroke(colour, width_mm, dash)
        if fill:
            self.canvas.setFillColor(paint(fill))
        self.canvas.circle(
            x * POINTS_PER_MM, self.y(down), radius * POINTS_PER_MM, stroke=1, fill=1 if fill else 0
        )

    def box(
        self, x: float, down: float, wide: float, high: float, colour: str = INK, width_mm: float = 0.2
    ) -> None:
        """Draw a rectangle from its upper left corner."""
        self._stroke(colour, width_mm)
        self.canvas.rect(
            x * POINTS_PER_MM,
            self.y(down + high),
            wide * POINTS_PER_MM,
            high * POINTS_PER_MM,
            stroke=1,
            fill=0,
        )

    def picture(self, data: bytes, x: float, down: float, most_wide: float, most_high: float) -> float:
        """Draw a PNG or JPEG as large as fits from its upper left corner; return its width."""
        from reportlab.lib.utils import ImageReader

        image = ImageReader(io.BytesIO(data))
        wide, high = image.getSize()
        scale = min(most_wide / wide, most_high / high)
        place = x * POINTS_PER_MM, self.y(down + scale * high)
        size = scale * wide * POINTS_PER_MM, scale * high * POINTS_PER_MM
        self.canvas.drawImage(image, *place, *size, mask="auto")
        return float(scale * wide)

    def arrow(self, x0: float, y0: float, x1: float, y1: float) -> None:
        """Draw a dimension line with an arrow head at its end."""
        self.line(x0, y0, x1, y1, INK, 0.13)
        turn = math.atan2(y1 - y0, x1 - x0)
        for off in (-0.3, 0.3):
            back = turn + math.pi + off
            self.line(x1, y1, x1 + 1.8 * math.cos(back), y1 + 1.8 * math.sin(back), INK, 0.13)

    def badge(self, x: float, down: float, label: object) -> None:
        """Draw a number in a dark disc, several in a longer one."""
        text = str(label)
        size, wide = badge_size(text), badge_width_mm(text)
        if wide > 2.0 * BADGE_MM:
            self._stroke(INK, 0.2)
            self.canvas.setFillColor(paint(INK))
            corner = (x - 0.5 * wide) * POINTS_PER_MM, self.y(down + BADGE_MM)
            box = wide * POINTS_PER_MM, 2.0 * BADGE_MM * POINTS_PER_MM
            self.canvas.roundRect(*corner, *box, BADGE_MM * POINTS_PER_MM, stroke=1, fill=1)
        else:
            self.circle(x, down, BADGE_MM, INK, 0.2, INK)
        self.text(x, down + 0.125 * size, text, size, "#ffffff", bold=True, align="centre")

    def _path(self, polygons: Polygons, to_page: ToPage) -> Any:
        path = self.canvas.beginPath()
        for polygon in polygons:
            places = thinned(to_page(np.asarray(polygon)))
            path.moveTo(places[0, 0] * POINTS_PER_MM, self.y(places[0, 1]))
            for x, down in places[1:]:
                path.lineTo(x * POINTS_PER_MM, self.y(down))
            path.close()
        return path

    def shape(
        self, polygons: Polygons, to_page: ToPage, fill: str | None, stroke: str, width_mm: float = 0.25
    ) -> None:
        """Fill and stroke outlines with holes; ``to_page`` takes (k, 2) to (x, down)."""
        if not polygons:
            return
        path = self._path(polygons, to_page)
        self._stroke(stroke, width_mm)
        if fill:
            self.canvas.setFillColor(paint(fill))
        self.canvas.drawPath(path, stroke=1, fill=1 if fill else 0, fillMode=0)

    def hatch(self, polygons: Polygons, to_page: ToPage, comes: bool = False, filled: bool = False) -> None:
        """Draw removed metal hatched, added metal crossed, a bore with its slug filled and crossed."""
        if not polygons:
            return
        colour = ADDED_COLOUR if comes or filled else GONE
        if filled:
            self.shape(polygons, to_page, SLUG, ADDED_COLOUR, 0.3)
        places = np.concatenate([to_page(np.asarray(polygon)) for polygon in polygons])
        (left, top), (right, bottom) = places.min(axis=0), places.max(axis=0)
        high = bottom - top
        self.canvas.saveState()
        self._stroke(colour, 0.3, (1.2, 0.6) if comes else ())
        self.canvas.clipPath(self._path(polygons, to_page), stroke=1, fill=0, fillMode=0)
        self._stroke(colour, 0.15)
        p, low, up = POINTS_PER_MM, self.y(bottom), self.y(top)
        starts = np.arange(left - high, right, HATCH_MM)
        lines = [(start * p, low, (start + high) * p, up) for start in starts]
        lines += [(start * p, up, (start + high) * p, low) for start in starts] if comes or filled else []
        self.canvas.lines(lines)
        self.canvas.restoreState()
