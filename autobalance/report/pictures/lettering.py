"""Labels and lines drawn into pictures."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources

import numpy as np

from autobalance.report.pictures.labels import placed
from autobalance.report.pictures.zbuffer import Image
from autobalance.types import Array

INK, PAPER, LEADER = (20, 20, 20), (255, 255, 255), (90, 90, 90)
SIZE, PAD = 15, 3


def draw_labels(image: Image, labels: Sequence[tuple[str, int, int]]) -> Image:
    """Return an image with texts at pixels (column, row), on a light ground, none over another.

    A line joins a text and its pixel where they are apart.
    """
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    canvas = Pillow.fromarray(image)
    pen, font = ImageDraw.Draw(canvas), ImageFont.load_default(SIZE)
    if not all(text.isascii() for text, _, _ in labels):  # Pillow's font has no µ
        with resources.as_file(resources.files("autobalance.report") / "assets" / "DejaVuSans.ttf") as path:
            font = ImageFont.truetype(str(path), SIZE)
    boxes = [pen.textbbox((0, 0), text, font, anchor="lt") for text, _, _ in labels]
    sizes = [(right + 2.0 * PAD, bottom + 2.0 * PAD) for _, _, right, bottom in boxes]
    marks = [(float(column), float(row)) for _, column, row in labels]
    places = placed(marks, sizes, canvas.size)
    for label in places:
        if label.mark != label.middle:
            pen.line((*label.mark, *label.middle), fill=LEADER, width=1)
    for (text, _, _), label, (wide, high) in zip(labels, places, sizes, strict=True):
        x, y = label.middle
        pen.rectangle((x - 0.5 * wide, y - 0.5 * high, x + 0.5 * wide, y + 0.5 * high), fill=PAPER)
        pen.text((x, y), text, INK, font, anchor="mm")
    return np.array(canvas, dtype=np.uint8)


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
