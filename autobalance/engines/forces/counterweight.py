"""A counterweight as a sector of a ring: mass, centre, product, what each size does to it, a size solved."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalance.units import G_PER_MM3_PER_KG_M3, STEEL_KG_M3

SIZES = ("outer_radius", "thickness", "fan_angle")


@dataclass(frozen=True)
class Fan:
    """A counterweight as a sector of a ring; sensitivities are relative changes of its product."""

    outer_radius_mm: float
    inner_radius_mm: float
    fan_angle_deg: float
    thickness_mm: float
    mass_g: float
    centre_mm: float
    product_g_mm: float
    sensitivity_radius: float
    sensitivity_thickness: float
    sensitivity_angle: float


def fan_counterweight(
    outer_radius_mm: float,
    inner_radius_mm: float,
    fan_angle_deg: float,
    thickness_mm: float,
    density_kg_m3: float = STEEL_KG_M3,
) -> Fan:
    """Return a counterweight's mass, centre, product and sensitivities: ρ T ⅔ sin(A/2)(R³ − r_i³).

    Parameters
    ----------
    outer_radius_mm, inner_radius_mm, thickness_mm : float
        [mm]
    fan_angle_deg : float
        The whole angle.
    density_kg_m3 : float

    References
    ----------
    Ruckle 2014, Sec. 3.1.1; sensitivities 3R³/(R³ − r_i³), 1, (A/2)/tan(A/2), in the order it states.

    Examples
    --------
    >>> fan = fan_counterweight(60.0, 25.0, 120.0, 20.0)
    >>> round(fan.mass_g, 2), round(fan.centre_mm, 3), round(fan.product_g_mm, 1)
    (489.12, 37.134, 18162.8)
    """
    return _fan(outer_radius_mm, inner_radius_mm, math.radians(fan_angle_deg), thickness_mm, density_kg_m3)


def fan_counterweight_for(
    product_g_mm: float,
    change: str,
    outer_radius_mm: float,
    inner_radius_mm: float,
    fan_angle_deg: float,
    thickness_mm: float,
    density_kg_m3: float = STEEL_KG_M3,
) -> Fan:
    """Return a counterweight with one size changed so that it has a product.

    Parameters
    ----------
    product_g_mm : float
        Wanted [g·mm].
    change : str
        The size that may change: ``outer_radius``, ``thickness`` or ``fan_angle``.
    outer_radius_mm, inner_radius_mm, fan_angle_deg, thickness_mm, density_kg_m3 : float
        As for ``fan_counterweight``.

    Raises
    ------
    ValueError
        If that size alone cannot reach it (the angle gives most at 180°), or is not known.

    References
    ----------
    Ruckle 2014, Sec. 3.1.1.

    Examples
    --------
    >>> round(fan_counterweight_for(2 * 18162.84, "thickness", 60.0, 25.0, 120.0, 20.0).thickness_mm, 3)
    40.0
    """
    if change not in SIZES:
        raise ValueError(f"change is {change!r}; must be one of {', '.join(SIZES)}")
    angle = math.radians(fan_angle_deg)
    fan = _fan(outer_radius_mm, inner_radius_mm, angle, thickness_mm, density_kg_m3)
    if not product_g_mm > 0.0:
        raise ValueError(f"product of the counterweight is {product_g_mm:g} g·mm; must be > 0")
    share = product_g_mm / fan.product_g_mm
    if change == "thickness":
        return _fan(outer_radius_mm, inner_radius_mm, angle, thickness_mm * share, density_kg_m3)
    if change == "outer_radius":
        inner = inner_radius_mm**3
        outer_radius = (inner + share * (outer_radius_mm**3 - inner)) ** (1.0 / 3.0)
        return _fan(outer_radius, inner_radius_mm, angle, thickness_mm, density_kg_m3)
    sine = share * math.sin(0.5 * angle)
    if sine > 1.0:
        most = fan.product_g_mm / math.sin(0.5 * angle)
        raise ValueError(
            f"the product of the counterweight must be {product_g_mm:.1f} g·mm; a fan of 180° has the most,"
            f" {most:.1f} g·mm"
        )
    return _fan(outer_radius_mm, inner_radius_mm, 2.0 * math.asin(sine), thickness_mm, density_kg_m3)


def _fan(
    outer_radius_mm: float,
    inner_radius_mm: float,
    angle_rad: float,
    thickness_mm: float,
    density_kg_m3: float,
) -> Fan:
    if not 0.0 <= inner_radius_mm < outer_radius_mm:
        raise ValueError(
            f"a counterweight from radius {inner_radius_mm:g} to {outer_radius_mm:g} mm;"
            " the inner must be ≥ 0 and less than the outer"
        )
    if not 0.0 < angle_rad <= 2.0 * math.pi:
        raise ValueError(
            f"fan angle of the counterweight is {math.degrees(angle_rad):g}°;"
            " must be above 0 and at most 360°"
        )
    if not (thickness_mm > 0.0 and density_kg_m3 > 0.0):
        raise ValueError(
            f"a counterweight {thickness_mm:g} mm thick of {density_kg_m3:g} kg/m³; both must be > 0"
        )
    half = 0.5 * angle_rad
    cubes = outer_radius_mm**3 - inner_radius_mm**3
    g_per_mm2 = density_kg_m3 * G_PER_MM3_PER_KG_M3 * thickness_mm
    mass = g_per_mm2 * (half * (outer_radius_mm**2 - inner_radius_mm**2))
    product = g_per_mm2 * (2.0 / 3.0 * math.sin(half) * cubes)
    return Fan(
        outer_radius_mm,
        inner_radius_mm,
        math.degrees(angle_rad),
        thickness_mm,
        mass,
        product / mass,
        product,
        3.0 * outer_radius_mm**3 / cubes,
        1.0,
        half / math.tan(half),
    )
