"""A counterweight as a fan: mass, centre, product, what each size does to it, and a size solved for."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from autobalance.units import G_PER_MM3_PER_KG_M3

Size = Literal["outer_radius_mm", "thickness_mm", "fan_angle_rad"]


@dataclass(frozen=True)
class FanCounterweight:
    """A sector of an annulus about the crank axis.

    Attributes
    ----------
    outer_radius_mm, inner_radius_mm : float
        [mm].
    fan_angle_rad : float
        The whole angle, up to 2π [rad].
    thickness_mm : float
        Along the crank axis [mm].
    density_kg_m3 : float

    Examples
    --------
    >>> fan = FanCounterweight(60.0, 25.0, math.radians(120.0), 20.0, 7850.0)
    >>> round(fan.mass_g, 2), round(fan.centre_mm, 3), round(fan.product_g_mm, 1)
    (489.12, 37.134, 18162.8)
    """

    outer_radius_mm: float
    inner_radius_mm: float
    fan_angle_rad: float
    thickness_mm: float
    density_kg_m3: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.inner_radius_mm < self.outer_radius_mm:
            raise ValueError(
                f"a counterweight from radius {self.inner_radius_mm:g} to {self.outer_radius_mm:g} mm;"
                " the inner must be ≥ 0 and less than the outer"
            )
        if not 0.0 < self.fan_angle_rad <= 2.0 * math.pi:
            raise ValueError(
                f"fan angle of the counterweight is {math.degrees(self.fan_angle_rad):g}°;"
                " must be above 0 and at most 360°"
            )
        if not (self.thickness_mm > 0.0 and self.density_kg_m3 > 0.0):
            raise ValueError(
                f"a counterweight {self.thickness_mm:g} mm thick of {self.density_kg_m3:g} kg/m³;"
                " both must be > 0"
            )

    @property
    def mass_g(self) -> float:
        """ρ T A/2 (R² − r_i²) [g]."""
        area = 0.5 * self.fan_angle_rad * (self.outer_radius_mm**2 - self.inner_radius_mm**2)
        return self.density_kg_m3 * G_PER_MM3_PER_KG_M3 * self.thickness_mm * area

    @property
    def product_g_mm(self) -> float:
        """Unbalance ρ T ⅔ sin(A/2) (R³ − r_i³) [g·mm]."""
        cubes = self.outer_radius_mm**3 - self.inner_radius_mm**3
        moment = 2.0 / 3.0 * math.sin(0.5 * self.fan_angle_rad) * cubes
        return self.density_kg_m3 * G_PER_MM3_PER_KG_M3 * self.thickness_mm * moment

    @property
    def centre_mm(self) -> float:
        """Distance of its centre of mass from the crank axis [mm]."""
        return self.product_g_mm / self.mass_g

    @property
    def sensitivities(self) -> dict[Size, float]:
        """Relative change of the product over that of each size: radius above 3, thickness 1, angle below 1.

        References
        ----------
        Ruckle 2014, Sec. 3.1.1, which states the order radius, thickness, angle.
        """
        outer, inner, half = self.outer_radius_mm**3, self.inner_radius_mm**3, 0.5 * self.fan_angle_rad
        return {
            "outer_radius_mm": 3.0 * outer / (outer - inner),
            "thickness_mm": 1.0,
            "fan_angle_rad": half / math.tan(half),
        }

    def solved_for(self, size: Size, product_g_mm: float) -> FanCounterweight:
        """Return this counterweight with one size changed so that it has a product.

        Parameters
        ----------
        size : str
            Name of the size that may change.
        product_g_mm : float
            Wanted [g·mm].

        Raises
        ------
        ValueError
            If that size alone cannot reach it: the angle gives most at 180°.

        Examples
        --------
        >>> fan = FanCounterweight(60.0, 25.0, math.radians(120.0), 20.0, 7850.0)
        >>> round(fan.solved_for("thickness_mm", 2 * fan.product_g_mm).thickness_mm, 9)
        40.0
        """
        if not product_g_mm > 0.0:
            raise ValueError(f"product of the counterweight is {product_g_mm:g} g·mm; must be > 0")
        share = product_g_mm / self.product_g_mm
        if size == "thickness_mm":
            return replace(self, thickness_mm=self.thickness_mm * share)
        if size == "outer_radius_mm":
            inner = self.inner_radius_mm**3
            return replace(
                self, outer_radius_mm=(inner + share * (self.outer_radius_mm**3 - inner)) ** (1.0 / 3.0)
            )
        sine = share * math.sin(0.5 * self.fan_angle_rad)
        if sine > 1.0:
            most = self.product_g_mm / math.sin(0.5 * self.fan_angle_rad)
            raise ValueError(
                f"product of the counterweight is to be {product_g_mm:.1f} g·mm; a fan of 180° has the most,"
                f" {most:.1f} g·mm"
            )
        return replace(self, fan_angle_rad=2.0 * math.asin(sine))
