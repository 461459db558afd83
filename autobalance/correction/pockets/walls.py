"""Metal left around a milled pocket, and its largest depth: distances to all voids."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.crank.anatomy import Face, Web
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid

SKIN_MM = 1e-3
"""Metal over or under a cheek that is its own roughness."""
LOOKED_AT_MM = 10.0
"""Distance next to and below a pocket within which air is sought, and farther if none is found."""
DEPTH_TOLERANCE_MM = 1e-3
"""Depths found here are short of the exact limit by at most this, never beyond it."""
BISECTIONS = 24
"""Halvings of a depth at most: they bring 16 m to the tolerance above."""


@dataclass(frozen=True, eq=False)
class Below:
    """Metal below a plane cheek: ``crank`` in the rotor frame, ``up`` ±1 along the axis.

    ``behind_mm`` is the thickness of the web under it; its roughness ``skin_mm`` is left out.
    """

    crank: Solid
    web: int
    z_mm: float
    up: float
    behind_mm: float
    skin_mm: float

    @classmethod
    def cheek(cls, crank: Solid, face: Face, web: Web) -> Below:
        """Return the metal below a face that looks along the axis."""
        up, z = math.copysign(1.0, float(face.normal[2])), float(face.centroid_mm[2])
        behind = z - web.z_min_mm if up > 0.0 else web.z_max_mm - z
        return cls(crank, web.number, z, up, behind, 2.0 * face.spread_mm + 2.0 * SKIN_MM)

    def wall_left_mm(self, pocket: Region, depth_mm: float) -> float:
        """Return the least distance from a pocket's sides and floor to any surface but the cheek."""
        body, reach = self._body(pocket, depth_mm), LOOKED_AT_MM
        while True:
            gap = body.gap_mm(self._air(body, reach), reach)
            if gap < reach:
                return gap
            reach *= 2.0

    def deepest_mm(self, pocket: Region, wall_mm: float, most_mm: float) -> float:
        """Return the largest depth of a pocket in its web, wall kept, up to ``most_mm``; 0 if none."""
        most_mm = min(most_mm, self.behind_mm - wall_mm)
        air = self._air(self._body(pocket, most_mm), wall_mm + SKIN_MM)

        def fits(depth_mm: float) -> bool:
            return self._body(pocket, depth_mm).gap_mm(air, wall_mm + SKIN_MM) >= wall_mm - SKIN_MM

        if fits(most_mm):
            return most_mm
        low, high = 0.0, most_mm
        for _ in range(BISECTIONS):
            if high - low <= DEPTH_TOLERANCE_MM:
                break
            middle = 0.5 * (low + high)
            low, high = (middle, high) if fits(middle) else (low, middle)
        return low

    def _body(self, pocket: Region, depth_mm: float) -> Solid:
        """Return the pocket from under the cheek's skin down to its floor."""
        ends = sorted(
            (self.z_mm - self.up * self.skin_mm, self.z_mm - self.up * max(depth_mm, 2.0 * self.skin_mm))
        )
        return Solid.prism(pocket, *ends)

    def _air(self, body: Solid, reach_mm: float) -> Solid:
        """Return all voids under the cheek, around a body."""
        low, high = body.bounds
        low, high = low - 2.0 * reach_mm, high + 2.0 * reach_mm
        top = self.z_mm - self.up * self.skin_mm
        if self.up > 0.0:
            high = np.array([high[0], high[1], top])
        else:
            low = np.array([low[0], low[1], top])
        return Solid.box(low, high) - self.crank
