"""Letters and lines drawn into pictures, for labels where there is no graphics library."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalance.report.pictures.zbuffer import Image
from autobalance.types import Array

GLYPHS = {
    " ": "0000000000", "-": "0808080808", ".": "0060600000",
    "0": "3E5149453E", "1": "00427F4000", "2": "4261514946", "3": "2141454B31", "4": "1814127F10",
    "5": "2745454539", "6": "3C4A494930", "7": "0171090503", "8": "3649494936", "9": "064949291E",
    "a": "2054545478", "b": "7F48444438", "c": "3844444420", "d": "384444487F", "e": "3854545418",
    "f": "087E090102", "g": "0C5252523E", "h": "7F08040478", "i": "00447D4000", "j": "2040443D00",
    "k": "7F10284400", "l": "00417F4000", "m": "7C04180478", "n": "7C08040478", "o": "3844444438",
    "p": "7C14141408", "q": "081414187C", "r": "7C08040408", "s": "4854545420", "t": "043F444020",
    "u": "3C4040207C", "v": "1C2040201C", "w": "3C4030403C", "x": "4428102844", "y": "0C5050503C",
    "z": "4464544C44",
}  # fmt: skip
"""Five columns of seven dots, as two hexadecimal digits each; the lowest bit is the top dot."""
ENLARGED = 2
"""Pixels to a dot."""
INK, PAPER = (20, 20, 20), (255, 255, 255)


def text_dots(text: str) -> NDArray[np.bool_]:
    """Return the dots (7, k) of a text; characters without a glyph are left blank."""
    columns: list[int] = []
    for letter in text.lower():
        glyph = GLYPHS.get(letter, GLYPHS[" "])
        columns += [int(glyph[2 * k : 2 * k + 2], 16) for k in range(5)] + [0]
    bits = np.array(columns[:-1], dtype=np.int64)
    dots: NDArray[np.bool_] = (bits[None, :] >> np.arange(7)[:, None]) & 1 == 1
    return dots


def draw_text(image: Image, text: str, column: int, row: int) -> None:
    """Write a text into an image on a light ground, centred on a pixel but wholly inside the image."""
    dots = np.kron(text_dots(text), np.ones((ENLARGED, ENLARGED), dtype=bool))
    box = np.pad(dots, ENLARGED)
    height, width = box.shape
    top = min(max(row - height // 2, 0), image.shape[0] - height)
    left = min(max(column - width // 2, 0), image.shape[1] - width)
    if top < 0 or left < 0:
        return
    area = image[top : top + height, left : left + width]
    area[:] = (0.3 * area + 0.7 * np.array(PAPER)).astype(np.uint8)
    area[box] = INK


def draw_line(image: Image, start: Array, end: Array, colour: tuple[int, int, int]) -> None:
    """Draw a dash-dotted line between two pixels (column, row), two pixels wide."""
    count = int(np.ceil(2.0 * np.hypot(*(end - start)))) + 1
    share = np.linspace(0.0, 1.0, count)
    points = start + share[:, None] * (end - start)
    run = share * np.hypot(*(end - start)) % 36.0
    points = points[(run < 20.0) | ((run > 26.0) & (run < 30.0))]
    for aside in (0, 1):
        column, row = (points + 0.5).astype(np.int64).T
        row = row + aside
        inside = (row >= 0) & (row < image.shape[0]) & (column >= 0) & (column < image.shape[1])
        image[row[inside], column[inside]] = colour
