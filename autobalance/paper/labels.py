"""Places of numbers without overlap: spread along a circle or a line, or left out."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.types import Array

Box = tuple[float, float, float, float]
"""Left, top, right, bottom [mm]."""


def spread(wanted: Sequence[float], apart: float) -> list[float]:
    """Return places on a line, nearest to those wanted (least squares), ``apart`` or more from each other.

    With the k-th place shifted by k times the distance, keeping their order becomes isotonic regression.

    Examples
    --------
    >>> spread([0.0, 0.0, 10.0], 2.0)
    [-1.0, 1.0, 10.0]
    """
    order = sorted(range(len(wanted)), key=lambda k: wanted[k])
    blocks: list[list[float]] = []  # mean, count
    for place, k in enumerate(order):
        blocks.append([wanted[k] - place * apart, 1.0])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            mean, count = blocks.pop()
            first = blocks[-1]
            first[0] = (first[0] * first[1] + mean * count) / (first[1] + count)
            first[1] += count
    levels = np.repeat([block[0] for block in blocks], [int(block[1]) for block in blocks])
    places = [0.0] * len(wanted)
    for place, k in enumerate(order):
        places[k] = float(levels[place]) + place * apart
    return places


def spread_between(wanted: Sequence[float], apart: float, low: float, high: float) -> list[float]:
    """Return places as ``spread`` does, all between two ends if there is room for them."""
    places = spread([min(max(each, low), high) for each in wanted], apart)
    order = sorted(range(len(places)), key=lambda k: places[k])
    for place, k in enumerate(order):
        places[k] = max(places[k], low + place * apart)
    for place, k in enumerate(reversed(order)):
        places[k] = min(places[k], high - place * apart)
    return places


def spread_on_circle(wanted_rad: Sequence[float], apart_rad: float) -> list[float]:
    """Return angles on a circle, ``apart`` or more all around if there is room for them.

    The circle is cut open in the widest gap; places beyond the gap are pushed back.
    """
    if not wanted_rad:
        return []
    turns = np.mod(np.asarray(wanted_rad), 2.0 * math.pi)
    ordered = np.sort(turns)
    gaps = np.diff(np.append(ordered, ordered[0] + 2.0 * math.pi))
    start = float(ordered[(int(np.argmax(gaps)) + 1) % len(ordered)])
    widest = float(gaps.max())
    along = np.mod(turns - start, 2.0 * math.pi)
    along[along > 2.0 * math.pi - 1e-9] = 0.0
    room = 0.5 * max(0.0, widest - apart_rad)
    last = 2.0 * math.pi - widest
    places = spread_between(along.tolist(), apart_rad, -room, last + room)
    return [start + each for each in places]


def rings_for(count: int, radius_mm: float, apart_mm: float) -> int:
    """Return the number of rings on which that many labels have room."""
    return max(1, math.ceil(count * apart_mm / (0.97 * 2.0 * math.pi * radius_mm)))


class Occupied:
    """Boxes of text on a drawing."""

    def __init__(self) -> None:
        self._boxes: list[Box] = []

    def take(self, box: Box) -> bool:
        """Occupy a box unless it overlaps another; return whether it was free."""
        free = not any(_overlap(box, other) for other in self._boxes)
        if free:
            self._boxes.append(box)
        return free

    def add(self, box: Box) -> None:
        """Occupy a box, even over others."""
        self._boxes.append(box)


def _overlap(one: Box, two: Box) -> bool:
    return one[0] < two[2] and two[0] < one[2] and one[1] < two[3] and two[1] < one[3]


def directions(angles_rad: Sequence[float]) -> Array:
    """Return unit vectors (n, 2) on the page, right and down, of rotor angles with crankpin 1 up."""
    turn = np.asarray(angles_rad, dtype=np.float64)
    return np.stack([-np.sin(turn), -np.cos(turn)], axis=1)
