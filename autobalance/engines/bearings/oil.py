"""Viscosity of an oil over the temperature."""

from __future__ import annotations

import math
from dataclasses import dataclass

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
