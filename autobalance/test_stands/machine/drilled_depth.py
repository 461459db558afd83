"""Drilling depth for the removal of an unbalance: closed forms on a flat entry. mm, g."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from scipy.optimize import brentq

from autobalance.declare import DEGREES, KG_M3, POSITIVE, Range
from autobalance.units import G_PER_MM3_PER_KG_M3, STEEL_KG_M3

POINT = Range("must be > 0 and ≤ 180", above=0.0, most=180.0)
HoleDirection = Literal["radial", "axial"]


@dataclass(frozen=True)
class DrillPlace:
    """A drill at a radius: into a flat rim towards the axis, or along the axis."""

    diameter_mm: Annotated[float, POSITIVE, "diameter of the drill"]
    radius_mm: Annotated[
        float, POSITIVE, "radius of the rim, taken as flat; axial: radius of the hole's centre"
    ]
    point_angle_rad: Annotated[float, DEGREES, POINT, "point angle of the drill"] = DEGREES.read(118.0)
    density_g_mm3: Annotated[float, KG_M3, POSITIVE, "density of the metal"] = (
        STEEL_KG_M3 * G_PER_MM3_PER_KG_M3
    )
    direction: Annotated[HoleDirection, "into the rim, or along the axis"] = "radial"

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
