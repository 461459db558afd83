"""A plain disc on a shaft that has the inertia of a crank, for a test bench."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalance.engine.section_table import cylinder_mass_g
from autobalance.units import G_PER_MM3_PER_KG_M3


@dataclass(frozen=True)
class SubstituteRotor:
    """A disc in the middle of a shaft of one material.

    Attributes
    ----------
    disc_mm, shaft_mm : float
        Diameters d₁ and d₂ [mm].
    length_mm : float
        Of the whole L₁ [mm].
    thickness_mm : float
        Of the disc t [mm].
    density_kg_m3 : float

    References
    ----------
    Hoem & Røsholm 2016, App. E, Eq. 7.7 to 7.9; Table 7.2 gives d₁ = 98 mm with the thickness of a disc of
    100 mm, so that the built rotor lacks 7.7 % of the inertia.
    """

    disc_mm: float
    shaft_mm: float
    length_mm: float
    thickness_mm: float
    density_kg_m3: float

    @classmethod
    def of_inertia(
        cls,
        polar_inertia_g_mm2: float,
        disc_mm: float,
        shaft_mm: float,
        length_mm: float,
        density_kg_m3: float,
    ) -> SubstituteRotor:
        """Return the rotor of a polar inertia: t = (32 J/(π ρ) − d₂⁴ L₁)/(d₁⁴ − d₂⁴).

        Examples
        --------
        >>> round(SubstituteRotor.of_inertia(2847.335e3, 98.0, 20.0, 188.0, 7850.0).thickness_mm, 3)
        39.799
        """
        if not 0.0 < shaft_mm < disc_mm:
            raise ValueError(
                f"a disc of {disc_mm:g} mm on a shaft of {shaft_mm:g} mm; the disc must be the larger"
            )
        fourth = 32.0 * polar_inertia_g_mm2 / (density_kg_m3 * G_PER_MM3_PER_KG_M3 * math.pi)
        thickness = (fourth - shaft_mm**4 * length_mm) / (disc_mm**4 - shaft_mm**4)
        if not 0.0 < thickness <= length_mm:
            raise ValueError(
                f"the disc would have to be {thickness:.3f} mm thick; must be above 0 and at most the length,"
                f" {length_mm:g} mm"
            )
        return cls(disc_mm, shaft_mm, length_mm, thickness, density_kg_m3)

    @property
    def shaft_end_mm(self) -> float:
        """Length of the shaft on either side of the disc, L₂ [mm]."""
        return 0.5 * (self.length_mm - self.thickness_mm)

    @property
    def mass_g(self) -> float:
        """Of disc and shaft [g]."""
        disc = cylinder_mass_g(self.disc_mm, self.thickness_mm, self.density_kg_m3)
        return disc + cylinder_mass_g(self.shaft_mm, 2.0 * self.shaft_end_mm, self.density_kg_m3)

    @property
    def polar_inertia_g_mm2(self) -> float:
        """About its axis: ρ π/32 (d₁⁴ t + d₂⁴ (L₁ − t)) [g·mm²]."""
        disc = cylinder_mass_g(self.disc_mm, self.thickness_mm, self.density_kg_m3) * self.disc_mm**2
        shaft = cylinder_mass_g(self.shaft_mm, 2.0 * self.shaft_end_mm, self.density_kg_m3) * self.shaft_mm**2
        return (disc + shaft) / 8.0
