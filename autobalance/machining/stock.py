"""The metal as it is at a moment, and what of it lies near a tool."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from autobalance.crank.anatomy import Anatomy
from autobalance.machining.setups import inverse
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid, union
from autobalance.types import Array

SIDES = 96
"""Sides of the circles that stand for round tools where it is looked what they come near; around them."""
DEEPER_MM = 30.0
"""Largest reach of a second look below the first without the whole crank."""
CIRCUMSCRIBED_RATIO = 1.0 / np.cos(np.pi / SIDES)


class Stock:
    """The crank in the rotor frame, less what was cut so far.

    The bodies that were cut are kept apart: only what lies near a tool is ever cut out of the whole crank.
    """

    def __init__(self, solid: Solid, anatomy: Anatomy) -> None:
        self.solid, self.anatomy = solid, anatomy
        self.removed: list[tuple[Solid, Array]] = []
        self._last: tuple[Array, Array, Array, Solid] | None = None

    def cut(self, body: Solid) -> None:
        """Take a body (rotor frame) from it."""
        if not body.is_empty:
            self.removed.append((body, body.bounds))

    def near(self, placement: Array, low: Array, high: Array) -> Solid:
        """Return the metal in a box between two corners (3,), in the axes that ``placement`` leads from."""
        box = Solid.box(low, high).moved(placement)
        metal_near = self._around(placement, low, high) & box
        first, last = box.bounds
        for body, bounds in self.removed:
            if not (np.any(bounds[0] > last) or np.any(first > bounds[1])):
                metal_near = metal_near - body
        return metal_near.moved(inverse(placement))

    def _around(self, placement: Array, low: Array, high: Array) -> Solid:
        """Return the uncut metal in a box at least as large; the last one is kept for another look."""
        if self._last is not None:
            known, first, last, metal = self._last
            if np.array_equal(known, placement) and (low >= first).all() and (high <= last).all():
                return metal
        first, last = low - np.array([1.0, 1.0, DEEPER_MM]), high + 1.0
        metal = self.solid & Solid.box(first, last).moved(placement)
        self._last = placement.copy(), first, last, metal
        return metal

    def left(self) -> Solid:
        """Return all that is left, rotor frame."""
        return self.solid - union([body for body, _ in self.removed]) if self.removed else self.solid

    @cached_property
    def _profile(self) -> tuple[Array, Array, Array]:
        """Smallest and largest z, and largest distance from the axis, of each triangle."""
        corners = self.solid.mesh.corners
        radius = np.hypot(corners[:, :, 0], corners[:, :, 1]).max(axis=1)
        return corners[:, :, 2].min(axis=1), corners[:, :, 2].max(axis=1), radius

    def reach_mm(self, low_mm: float, high_mm: float) -> float:
        """Return the largest radius of metal between two z; nothing was cut of it."""
        low, high, radius = self._profile
        return float(radius[(high >= low_mm) & (low <= high_mm)].max(initial=0.0))

    @property
    def greatest_radius_mm(self) -> float:
        """Largest radius of metal anywhere."""
        return float(self._profile[2].max())

    @property
    def ends_mm(self) -> tuple[float, float]:
        """Smallest and largest z."""
        return float(self._profile[0].min()), float(self._profile[1].max())

    def part_at(self, place: Array) -> str:
        """Return the name of the crank's part at a place (3,) in the rotor frame, for messages."""
        z = float(place[2])
        for web in self.anatomy.webs:
            if web.z_min_mm - 0.1 <= z <= web.z_max_mm + 0.1:
                return f"web {web.number}"
        return "the shaft"


def disc(radius_mm: float, x: float, y: float) -> Region:
    """Return a circle that a round tool lies in."""
    return Region.circle(radius_mm * CIRCUMSCRIBED_RATIO, SIDES, (x, y))


def strip(begin: Array, end: Array, radius_mm: float) -> Region:
    """Return the area under a round tool on a straight way between two places (2,)."""
    ends = disc(radius_mm, *begin.tolist()) + disc(radius_mm, *end.tolist())
    along = end - begin
    if not along.any():
        return ends
    across = radius_mm / float(np.hypot(*along)) * np.array([-along[1], along[0]])
    return ends + Region.of([np.array([begin - across, end - across, end + across, begin + across])])


def top_mm(metal: Solid, region: Region) -> float:
    """Return the height of the highest metal over a region; −inf without metal."""
    if metal.is_empty:
        return -np.inf
    low, high = metal.bounds[0, 2], metal.bounds[1, 2]
    inside = metal & Solid.prism(region, float(low) - 1.0, float(high) + 1.0)
    return -np.inf if inside.is_empty else float(inside.bounds[1, 2])
