"""The room above a piston: its volume and surface over the crank angle, exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.types import Array


@dataclass(frozen=True)
class Chamber:
    """The room between piston and head.

    Attributes
    ----------
    slider_crank : SliderCrank
    bore_mm : float
        Diameter of the cylinder [mm].
    compression_ratio : float or None
        Largest over smallest volume; None where it is not known: then the volume counts from top dead centre.

    Examples
    --------
    >>> chamber = Chamber(SliderCrank(26.9, 104.0), 76.8, 13.0)
    >>> round(chamber.swept_mm3 / 1e3, 1), round(chamber.clearance_mm3 / 1e3, 2)
    (249.2, 20.77)
    """

    slider_crank: SliderCrank
    bore_mm: float
    compression_ratio: float | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.bore_mm < math.inf:
            raise ValueError(f"bore is {self.bore_mm:g} mm; must be > 0")
        if self.compression_ratio is not None and not 1.0 < self.compression_ratio < math.inf:
            raise ValueError(f"compression ratio is {self.compression_ratio:g}; must be > 1")

    @property
    def piston_area_mm2(self) -> float:
        """π/4 bore² [mm²]."""
        return math.pi / 4.0 * self.bore_mm**2

    @property
    def swept_mm3(self) -> float:
        """Largest less smallest volume [mm³]."""
        return self.piston_area_mm2 * self.slider_crank.stroke_mm

    @property
    def clearance_mm3(self) -> float:
        """Smallest volume, zero where the compression ratio is not known [mm³]."""
        return 0.0 if self.compression_ratio is None else self.swept_mm3 / (self.compression_ratio - 1.0)

    @property
    def top_rad(self) -> float:
        """Crank angle from the cylinder's direction at which the piston is farthest [rad]."""
        return self.slider_crank.dead_centres_rad[0]

    @property
    def bottom_after_top_rad(self) -> float:
        """Angle from top to bottom dead centre; π except for an offset [rad]."""
        top, bottom = self.slider_crank.dead_centres_rad
        return bottom - top

    def volume_mm3(self, after_top_rad: Array) -> Array:
        """Return V = π/4 bore² (s/(ε − 1) + x_max − x) at angles after top dead centre [mm³]."""
        return self.volume_and_slope(after_top_rad)[0]

    def volume_and_slope(self, after_top_rad: Array) -> tuple[Array, Array]:
        """Return the volume [mm³] and its derivative by the crank angle [mm³/rad], each (...)."""
        motion = self.slider_crank.motion(np.asarray(after_top_rad, dtype=np.float64) + self.top_rad)
        area = self.piston_area_mm2
        return self.clearance_mm3 + area * (self._farthest_mm - motion.x_mm), -area * motion.dx_mm

    @property
    def _farthest_mm(self) -> float:
        return self.slider_crank.farthest_mm

    def surface_mm2(self, volume_mm3: Array) -> Array:
        """Return the wall that the gas touches: head, piston crown and liner, all flat [mm²]."""
        result: Array = 2.0 * self.piston_area_mm2 + 4.0 / self.bore_mm * volume_mm3
        return result
