"""Places of labels in pictures, none over another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

Box = tuple[float, float, float, float]
"""Left, top, right, bottom [pixels]."""
RINGS = 40
PLACES_PER_RING = 16
"""Places that are tried around a mark: ``RINGS`` rings of this many."""


class Placed(NamedTuple):
    """A label: its mark, and the place of its middle."""

    mark: tuple[float, float]
    middle: tuple[float, float]


def placed(
    marks: Sequence[tuple[float, float]],
    sizes: Sequence[tuple[float, float]],
    picture: tuple[float, float],
    away: float = 0.0,
) -> list[Placed]:
    """Return places of labels: near their marks, inside the picture, none over another.

    Parameters
    ----------
    marks, sizes : sequences of (float, float)
        Column and row of each mark, width and height of each label [pixels].
    picture : (float, float)
        Width and height [pixels].
    away : float
        Smallest distance of a label's middle from its mark; 0: on it if there is room.
    """
    boxes: list[Box] = []
    places_of_labels = []
    for mark, (wide, high) in zip(marks, sizes, strict=True):
        best = mark
        for ring in range(RINGS):
            radius = away + 6.0 * ring
            turns = [
                2.0 * math.pi * k / PLACES_PER_RING - 0.25 * math.pi
                for k in range(PLACES_PER_RING if radius else 1)
            ]
            places = [(mark[0] + radius * math.cos(t), mark[1] + radius * math.sin(t)) for t in turns]
            free = [each for each in places if _is_free(_box(each, wide, high), boxes, picture)]
            if free:
                best = free[0]
                break
        boxes.append(_box(best, wide, high))
        places_of_labels.append(Placed(mark, best))
    return places_of_labels


def _box(middle: tuple[float, float], wide: float, high: float) -> Box:
    x, y = middle
    return x - 0.5 * wide, y - 0.5 * high, x + 0.5 * wide, y + 0.5 * high


def _is_free(box: Box, boxes: Sequence[Box], picture: tuple[float, float]) -> bool:
    left, top, right, bottom = box
    if left < 0.0 or top < 0.0 or right > picture[0] or bottom > picture[1]:
        return False
    return not any(left < r and l < right and top < b and t < bottom for l, t, r, b in boxes)  # noqa: E741
