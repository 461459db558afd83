"""Oils, and the feeds that bring them to a bearing."""

from __future__ import annotations

import math

from autobalance.value_classes import dataclass

# Viscosity of an oil over the temperature.


KELVIN_AT_0_C = 273.15
WALTHER_SHIFT_MM2_S = 0.7
PA_S_PER_MM2_S_KG_M3 = 1e-6


@dataclass(frozen=True)
class WaltherOil:
    """An oil by Walther's law and a constant density.

    log₁₀ log₁₀(ν + 0.7) = A − B log₁₀ T, with ν in mm²/s and T in kelvin.
    """

    walther_a: float
    walther_b: float
    density_kg_m3: float = 860.0

    @classmethod
    def of_points(
        cls, points: tuple[tuple[float, float], tuple[float, float]], density_kg_m3: float = 860.0
    ) -> WaltherOil:
        """Return the oil that has two viscosities.

        Parameters
        ----------
        points : ((float, float), (float, float))
            Temperature and kinematic viscosity, twice [°C, mm²/s].
        density_kg_m3 : float
            Constant [kg/m³].

        Raises
        ------
        ValueError
            If a viscosity is not above 0.3 mm²/s, where Walther's law ends, a temperature not above
            absolute zero, both are one, or the viscosity does not fall with the temperature.

        References
        ----------
        .. [1] ASTM D341, without its terms for ν below 2 mm²/s.

        Examples
        --------
        >>> oil = WaltherOil.of_points(((40.0, 100.0), (100.0, 11.0)))
        >>> round(oil.kinematic_mm2_s(40.0), 9), round(oil.kinematic_mm2_s(100.0), 9)
        (100.0, 11.0)
        """
        (cold_C, thick), (hot_C, thin) = sorted(points)
        for celsius, viscosity in points:
            if not viscosity + WALTHER_SHIFT_MM2_S > 1.0:
                raise ValueError(f"viscosity {viscosity:g} mm²/s at {celsius:g} °C; must be > 0.3")
            if not celsius > -KELVIN_AT_0_C:
                raise ValueError(f"temperature {celsius:g} °C; must be above {-KELVIN_AT_0_C:g}")
        if not cold_C < hot_C:
            raise ValueError(f"both viscosities are at {cold_C:g} °C; expected two temperatures")
        if not thin < thick:
            raise ValueError(
                f"viscosity {thick:g} mm²/s at {cold_C:g} °C and {thin:g} at {hot_C:g} °C; "
                "it must fall with the temperature"
            )
        logs = [math.log10(celsius + KELVIN_AT_0_C) for celsius in (cold_C, hot_C)]
        doubles = [math.log10(math.log10(each + WALTHER_SHIFT_MM2_S)) for each in (thick, thin)]
        slope = (doubles[0] - doubles[1]) / (logs[1] - logs[0])
        return cls(doubles[0] + slope * logs[0], slope, density_kg_m3)

    def kinematic_mm2_s(self, celsius: float) -> float:
        """Return the kinematic viscosity at a temperature [mm²/s]."""
        double = self.walther_a - self.walther_b * math.log10(celsius + KELVIN_AT_0_C)
        return float(10.0 ** (10.0**double) - WALTHER_SHIFT_MM2_S)

    def viscosity_Pa_s(self, celsius: float) -> float:
        """Return the dynamic viscosity at a temperature [Pa·s]."""
        return self.kinematic_mm2_s(celsius) * self.density_kg_m3 * PA_S_PER_MM2_S_KG_M3


# Inlets of oil under pressure into a journal bearing: recesses, grooves and holes, and their restrictors.


SQUARE_OF_A_HOLE = 0.8472
"""Side of the square, over a hole's diameter, that feeds a film as the hole does: their outer radii are one.

The outer (conformal) radius of a square is 0.59017 of its side (Pólya & Szegő, Isoperimetric Inequalities in
Mathematical Physics, 1951).
"""


@dataclass(frozen=True)
class Capillary:
    """A capillary tube: laminar flow, proportional to the pressure drop; ``conductance`` [m³/(s Pa)]."""

    conductance: float

    @classmethod
    def of_tube(cls, diameter_m: float, length_m: float, viscosity_Pa_s: float) -> Capillary:
        """Return Hagen and Poiseuille's tube, π d⁴/(128 η l).

        Examples
        --------
        >>> round(Capillary.of_tube(1e-3, 0.1, 0.01).conductance * 1e12, 6)
        24.543693
        """
        return cls(math.pi * diameter_m**4 / (128.0 * viscosity_Pa_s * length_m))

    def flow(self, drop_Pa: float) -> tuple[float, float]:
        """Return the flow [m³/s] and its slope by the pressure drop."""
        return self.conductance * drop_Pa, self.conductance


@dataclass(frozen=True)
class Orifice:
    """A sharp orifice, C_d A √(2 Δp/ρ); ``factor`` is C_d A √(2/ρ) [m³/(s √Pa)]."""

    factor: float
    smooth_Pa: float = 1.0
    """Pressure drop below which the root is rounded, so that its slope stays finite at none."""

    @classmethod
    def of_hole(cls, diameter_m: float, discharge: float, density_kg_m3: float) -> Orifice:
        return cls(discharge * 0.25 * math.pi * diameter_m**2 * math.sqrt(2.0 / density_kg_m3))

    def flow(self, drop_Pa: float) -> tuple[float, float]:
        """Return the flow [m³/s] and its slope by the pressure drop."""
        size = math.hypot(drop_Pa, self.smooth_Pa)
        root = math.sqrt(size)
        return self.factor * drop_Pa / root, self.factor * (1.0 - 0.5 * (drop_Pa / size) ** 2) / root


@dataclass(frozen=True)
class GivenFlow:
    """A pump of constant flow [m³/s] at any pressure."""

    flow_m3_s: float

    def flow(self, drop_Pa: float) -> tuple[float, float]:
        """Return the flow [m³/s] and its slope, none."""
        return self.flow_m3_s, 0.0


Restrictor = Capillary | Orifice | GivenFlow


@dataclass(frozen=True)
class Feed:
    """A recess, groove or hole in the bush.

    ``angle_rad`` of its middle from the load's direction in the sense of turning, ``z_m`` from the middle of
    the bearing's length; pressures are above that at the bearing's ends. Without a restrictor its pressure is
    the supply's. ``depth_m`` below the bush's surface counts for friction alone, None: no friction there.
    """

    angle_rad: float
    width_rad: float
    z_m: float
    length_m: float
    pressure_Pa: float
    restrictor: Restrictor | None = None
    depth_m: float | None = None

    @property
    def is_ring(self) -> bool:
        """Whether it goes all around."""
        return self.width_rad >= 2.0 * math.pi * (1.0 - 1e-12)

    def covers(self, angle_rad: float, z_m: float) -> bool:
        """Return whether a place on the bush lies in it."""
        away = abs(math.remainder(angle_rad - self.angle_rad, 2.0 * math.pi))
        return (self.is_ring or away < 0.5 * self.width_rad) and abs(z_m - self.z_m) < 0.5 * self.length_m

    def overlaps(self, other: Feed) -> bool:
        """Return whether it shares a place with another, or touches it."""
        away = abs(math.remainder(self.angle_rad - other.angle_rad, 2.0 * math.pi))
        around = self.is_ring or other.is_ring or away <= 0.5 * (self.width_rad + other.width_rad)
        return around and abs(self.z_m - other.z_m) <= 0.5 * (self.length_m + other.length_m)
