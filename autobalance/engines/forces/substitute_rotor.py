"""A plain disc on a shaft that has the inertia of a crank, for a test bench."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalance.running_gear.section_table import cylinder_mass_g
from autobalance.units import G_MM2_PER_KG_MM2, G_PER_MM3_PER_KG_M3, STEEL_KG_M3


@dataclass(frozen=True)
class Rotor:
    """A disc in the middle of a shaft of one material."""

    disc_mm: float
    shaft_mm: float
    length_mm: float
    thickness_mm: float
    shaft_each_side_mm: float
    mass_g: float
    polar_inertia_kg_mm2: float


def substitute_rotor(
    polar_inertia_kg_mm2: float,
    disc_mm: float,
    shaft_mm: float,
    length_mm: float,
    density_kg_m3: float = STEEL_KG_M3,
) -> Rotor:
    """Return a disc on a shaft that has a crank's polar inertia: t = (32 J/(π ρ) − d₂⁴ L₁)/(d₁⁴ − d₂⁴).

    Parameters
    ----------
    polar_inertia_kg_mm2 : float
        Wanted [kg·mm²].
    disc_mm, shaft_mm, length_mm : float
        Diameters d₁ and d₂, and whole length L₁ [mm].
    density_kg_m3 : float

    Raises
    ------
    ValueError
        If there is no such disc.

    References
    ----------
    Hoem & Røsholm 2016, App. E, Eq. 7.7 to 7.9; Table 7.2's thickness belongs to a disc of 100 mm: as printed
    J is 7.7 % low.

    Examples
    --------
    >>> round(substitute_rotor(2847.335, 98.0, 20.0, 188.0).thickness_mm, 3)
    39.799
    """
    if not 0.0 < shaft_mm < disc_mm:
        raise ValueError(
            f"a disc of {disc_mm:g} mm on a shaft of {shaft_mm:g} mm; the disc must be the larger"
        )
    inertia = polar_inertia_kg_mm2 * G_MM2_PER_KG_MM2
    fourth = 32.0 * inertia / (density_kg_m3 * G_PER_MM3_PER_KG_M3 * math.pi)
    thickness = (fourth - shaft_mm**4 * length_mm) / (disc_mm**4 - shaft_mm**4)
    if not 0.0 < thickness <= length_mm:
        raise ValueError(
            f"the disc would have to be {thickness:.3f} mm thick; must be above 0 and at most the length,"
            f" {length_mm:g} mm"
        )
    return disc_rotor(disc_mm, shaft_mm, length_mm, thickness, density_kg_m3)


def disc_rotor(
    disc_mm: float, shaft_mm: float, length_mm: float, thickness_mm: float, density_kg_m3: float = STEEL_KG_M3
) -> Rotor:
    """Return mass and polar inertia of a disc in the middle of a shaft: J = ρ π/32 (d₁⁴ t + d₂⁴ (L₁ − t)).

    Parameters
    ----------
    disc_mm, shaft_mm, length_mm, thickness_mm : float
        Diameters d₁ and d₂, whole length L₁, thickness of the disc t [mm].
    density_kg_m3 : float

    References
    ----------
    Hoem & Røsholm 2016, App. E, Table 7.2.

    Examples
    --------
    >>> round(disc_rotor(98.0, 20.0, 188.0, 39.799).polar_inertia_kg_mm2, 1)
    2847.4
    """
    each_side = 0.5 * (length_mm - thickness_mm)
    disc = cylinder_mass_g(disc_mm, thickness_mm, density_kg_m3)
    shaft = cylinder_mass_g(shaft_mm, 2.0 * each_side, density_kg_m3)
    inertia = (disc * disc_mm**2 + shaft * shaft_mm**2) / 8.0
    return Rotor(
        disc_mm, shaft_mm, length_mm, thickness_mm, each_side, disc + shaft, inertia / G_MM2_PER_KG_MM2
    )
