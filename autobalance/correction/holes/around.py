"""Surfaces around the axis of a hole: the wall left beside it, and its largest depth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.holes.surface import Axis, Surface
from autobalance.correction.holes.walls import HoleLimits, greatest_depth_mm, wall_left_mm
from autobalance.correction.holes.zones import Fillet, in_fillets
from autobalance.types import Array

LOOKED_AT_MM = 10.0
"""Distance searched beside a hole, beyond its width; farther if there is nothing."""
NEAR_ENTRY_MM = 0.05
OLD_SHARE = 0.04
"""Share of the drill's radius by which an old hole that it fits may reach farther out: wider, not round."""


@dataclass(frozen=True)
class OldHole:
    """Hole to be drilled deeper: its radius, and the distance of its tip beyond the entry.

    What lies more than ``wall_mm`` above its tip is beside the old hole alone.
    """

    radius_mm: float
    tip_mm: float
    wall_mm: float

    def is_own(self, local: Array) -> NDArray[np.bool_]:
        """Return whether triangles (k, 3, 3) around the axis are the old hole's own, or beside it alone."""
        highest = local[:, :, 2].max(axis=1) - self.tip_mm
        within = (np.hypot(local[:, :, 0], local[:, :, 1]) <= (1.0 + OLD_SHARE) * self.radius_mm).all(axis=1)
        own: NDArray[np.bool_] = (within & (highest <= self.radius_mm)) | (highest < -self.wall_mm)
        return own


@dataclass(frozen=True, eq=False)
class Around:
    """All surfaces of a crank about the axis of a hole; ``fillets`` are those of its web."""

    surface: Surface
    axis: Axis
    fillets: tuple[Fillet, ...]
    old: OldHole | None = None

    def wall_mm(self, radius_mm: float, depth_mm: float, half_point_rad: float) -> float | None:
        """Return the least distance from a hole to surfaces that it does not enter.

        None where its axis meets no surface at its entry that a drill can start on.
        """
        reach = 2.0 * radius_mm + LOOKED_AT_MM
        while True:
            others = self._others(reach)
            if others is None:
                return None
            wall = wall_left_mm(others, radius_mm, depth_mm, half_point_rad)
            if radius_mm + wall <= reach:
                return wall
            reach = radius_mm + wall

    def deepest_mm(self, radius_mm: float, room: HoleLimits) -> float | None:
        """Return the largest depth of a hole within limits, -inf without any; None as in ``wall_mm``."""
        others = self._others(max(2.0 * radius_mm + LOOKED_AT_MM, radius_mm + room.wall_mm))
        return None if others is None else greatest_depth_mm(others, radius_mm, room)

    def _others(self, reach_mm: float) -> Array | None:
        near = self.surface.around(self.axis, reach_mm)
        depth, rows = near.hits(self.axis)
        away, near_mm = np.abs(depth), NEAR_ENTRY_MM
        if self.old is not None:
            away, near_mm = np.abs(depth - self.old.tip_mm), near_mm + OLD_SHARE * self.old.radius_mm
        if not (away < near_mm).any():
            return None
        entered = int(rows[np.argmin(away)])
        if self.old is None:
            return near.others(self.axis, entered, in_fillets(near.corners, self.fillets))[0]
        others, _ = near.others(self.axis, entered)
        return None if others is None else others[~self.old.is_own(others)]


def most_mm(axis: Axis, least_radius_mm: float, radius_mm: float, half_point_rad: float) -> float:
    """Return the depth at which a radial hole leaves its zone, point included, or meets the crank axis.

    Endless for an axial hole that lies in the zone, -inf for one that does not.
    """
    out = math.hypot(*axis.entry_mm[:2]) - least_radius_mm
    if abs(axis.inward[2]) > 0.5:
        return math.inf if not least_radius_mm or out >= radius_mm else -math.inf
    return out - (radius_mm / math.tan(half_point_rad) if least_radius_mm else 0.0)
