"""What stands on the pages of a PDF: boxes of words, and how far down each page is filled."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

TOUCH = 0.3
"""By how much the boxes that fonts state may come into each other [points]: descents of a line above."""
HEAD, FOOT = 0.09, 0.06
"""Shares of a page's height for its head and foot."""


class PageText(NamedTuple):
    """The words of a page and their boxes (left, top, right, bottom) in points, its size."""

    words: list[str]
    boxes: NDArray[np.float64]
    size: tuple[float, float]


def page_texts(path: Path) -> list[PageText]:
    """Return the words of each page as poppler finds them."""
    done = subprocess.run(["pdftotext", "-bbox", path, "-"], capture_output=True, check=True).stdout
    root = ElementTree.fromstring(re.sub(rb'\sxmlns="[^"]+"', b"", done, count=1))
    found = []
    for page in root.findall(".//page"):
        words = page.findall("word")
        keys = ("xMin", "yMin", "xMax", "yMax")
        boxes = np.array([[float(word.get(key, 0)) for key in keys] for word in words]).reshape(-1, 4)
        size = float(page.get("width", 0)), float(page.get("height", 0))
        found.append(PageText([str(word.text) for word in words], boxes, size))
    return found


def overlapping(page: PageText) -> list[tuple[str, str]]:
    """Return the pairs of words that lie over each other."""
    box = page.boxes
    wider = np.minimum(box[:, None, 2], box[None, :, 2]) - np.maximum(box[:, None, 0], box[None, :, 0])
    higher = np.minimum(box[:, None, 3], box[None, :, 3]) - np.maximum(box[:, None, 1], box[None, :, 1])
    over = np.argwhere(np.triu((wider > TOUCH) & (higher > TOUCH), 1))
    return [(page.words[i], page.words[j]) for i, j in over]


def filled(page: PageText) -> float:
    """Return how far down the room between head and foot a page has text, as a share."""
    high = page.size[1]
    top, bottom = HEAD * high, (1.0 - FOOT) * high
    inside = page.boxes[(page.boxes[:, 1] > top) & (page.boxes[:, 3] < bottom)]
    return float((inside[:, 3].max() - top) / (bottom - top)) if len(inside) else 0.0


def faults(path: Path) -> list[str]:
    """Return what is wrong with the pages: text over text, a page under a third full but the last."""
    pages = page_texts(path)
    said = []
    for number, page in enumerate(pages, 1):
        if over := overlapping(page):
            said.append(f"page {number}: text over text: {over[:3]}")
        if number < len(pages) and filled(page) < 1.0 / 3.0:
            said.append(f"page {number} of {len(pages)}: {100.0 * filled(page):.0f} % full")
    return said
