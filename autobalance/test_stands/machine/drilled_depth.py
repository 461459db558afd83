"""Drilling depth for the removal of an unbalance: closed forms on a flat entry. mm, g."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from scipy.optimize import brentq

HoleDirection = Literal["radial", "axial"]


@dataclass(frozen=True)
class DrillPlace:
    """A drill at a radius: into a flat rim towards the axis, or along the axis."""

    diameter_mm: float
    radius_mm: float
    point_angle_rad: float
    density_g_mm3: float
    direction: HoleDirection

    @property
    def point_mm(self) -> float:
        """Height of the drill's point."""
        return 0.5 * self.diameter_mm / math.tan(0.5 * self.point_angle_rad)

    def unbalance_g_mm(self, depth_mm: float) -> float:
        """Return the unbalance that a hole removes; the depth is of the full diameter, less the point."""
        area = 0.25 * math.pi * self.diameter_mm**2
        full, point = area * depth_mm, area * self.point_mm / 3.0
        if self.direction == "axial":
            return self.density_g_mm3 * (full + point) * self.radius_mm
        at_full = self.radius_mm - 0.5 * depth_mm
        at_point = self.radius_mm - depth_mm - 0.25 * self.point_mm
        return self.density_g_mm3 * (full * at_full + point * at_point)

    def depth_mm(self, unbalance_g_mm: float) -> float | None:
        """Return the depth that removes an unbalance; None without such a depth.

        The point alone may remove more; a radial hole removes most when its point reaches the axis.
        """
        deepest = self.radius_mm - self.point_mm if self.direction == "radial" else math.inf
        if self.direction == "axial":
            per_mm = self.density_g_mm3 * 0.25 * math.pi * self.diameter_mm**2 * self.radius_mm
            depth = unbalance_g_mm / per_mm - self.point_mm / 3.0
            return depth if depth >= 0.0 else None
        if deepest <= 0.0 or not self.unbalance_g_mm(0.0) <= unbalance_g_mm <= self.unbalance_g_mm(deepest):
            return None
        return float(brentq(lambda d: self.unbalance_g_mm(d) - unbalance_g_mm, 0.0, deepest, xtol=1e-12))
