"""Sizes and tables: holes, slugs, oil, section tables, counterweights, stroking, substitute rotors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from autobalance.engine import section_table as tables
from autobalance.engine.counterweight import FanCounterweight, Size
from autobalance.engine.forces import centrifugal_force_n
from autobalance.engine.substitute_rotor import SubstituteRotor
from autobalance.units import RAD_S_PER_RPM

KG_MM2 = 1000.0


@dataclass(frozen=True)
class Hole:
    """A drilled hole: what it lacks, where, and how it pulls."""

    mass_g: float
    unbalance_g_mm: float
    force_N: float | None


@dataclass(frozen=True)
class SectionSums:
    """Static and dynamic sums of a section table."""

    mass_g: float
    static_g_mm: tuple[float, float]
    dynamic_g_mm2: tuple[float, float]


@dataclass(frozen=True)
class TwoProducts:
    """Static products W (X, Y) of two counterweights that leave no force and no couple."""

    first_g_mm: tuple[float, float]
    second_g_mm: tuple[float, float]


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


@dataclass(frozen=True)
class Rotor:
    """A disc on a shaft with a wanted polar inertia."""

    disc_mm: float
    shaft_mm: float
    length_mm: float
    thickness_mm: float
    shaft_each_side_mm: float
    mass_g: float
    polar_inertia_kg_mm2: float


def cylinder_mass_g(diameter_mm: float, length_mm: float, density_kg_m3: float = 7850.0) -> float:
    """Return the mass of a plain cylinder, ρ π/4 d² t: a hole, a slug, the oil in a pin [g].

    Parameters
    ----------
    diameter_mm, length_mm : float
        [mm]
    density_kg_m3 : float
        For a slug in its bore: the difference of the densities; oil 870.

    References
    ----------
    Hoem & Røsholm 2016, Table 5.2; Ruckle 2014, Sec. 3.1.1.

    Examples
    --------
    >>> round(cylinder_mass_g(8.0, 37.0), 1)
    14.6
    """
    return tables.cylinder_mass_g(diameter_mm, length_mm, density_kg_m3)


def drilled_hole(
    diameter_mm: float,
    depth_mm: float,
    radius_mm: float,
    speed_rpm: float | None = None,
    density_kg_m3: float = 7850.0,
) -> Hole:
    """Return the unbalance of a flat-bottomed hole at a radius, and its force at a speed.

    Parameters
    ----------
    diameter_mm, depth_mm, radius_mm : float
        Of the hole; radius of its centre of mass [mm].
    speed_rpm : float or None
        [1/min]
    density_kg_m3 : float
        Of what is missing.

    References
    ----------
    Hoem & Røsholm 2016, Table 5.2, which calculates with r 29.3, t 37 mm and prints 29.6, 36.704.

    Examples
    --------
    >>> hole = drilled_hole(8.0, 37.0, 29.3, 9000.0)
    >>> round(hole.mass_g, 1), round(hole.force_N, 2)
    (14.6, 379.97)
    """
    mass = cylinder_mass_g(diameter_mm, depth_mm, density_kg_m3)
    unbalance = mass * radius_mm
    force = None if speed_rpm is None else centrifugal_force_n(unbalance, speed_rpm * RAD_S_PER_RPM)
    return Hole(mass, unbalance, force)


def final_hole_depth_mm(
    overbalance_g_mm: float, diameter_mm: float, rim_radius_mm: float, density_kg_m3: float = 7850.0
) -> float:
    """Return the depth of a radial hole from the rim that takes off an overbalance [mm].

    ρ π/4 d² (R t − t²/2) = U, without a point.

    Parameters
    ----------
    overbalance_g_mm, diameter_mm, rim_radius_mm, density_kg_m3 : float
        [g·mm, mm, mm, kg/m³]

    Raises
    ------
    ValueError
        If a hole to the crank axis would not be enough.

    References
    ----------
    Ruckle 2014, Sec. 3.1.1: 1.5 to 2 kg·mm are left on purpose.

    Examples
    --------
    >>> round(final_hole_depth_mm(1500.0, 20.0, 60.0), 2)
    11.18
    """
    return tables.final_hole_depth_mm(overbalance_g_mm, diameter_mm, rim_radius_mm, density_kg_m3)


def section_sums(
    mass_g: Sequence[float], x_mm: Sequence[float], y_mm: Sequence[float], z_mm: Sequence[float]
) -> SectionSums:
    """Return static sums Σ W (X, Y) and dynamic sums Σ W (X, Y) Z of a section table.

    Parameters
    ----------
    mass_g, x_mm, y_mm, z_mm : list of float
        One entry a section [g, mm].

    References
    ----------
    Ruckle 2014, Eq. 5 to 8; Table 2 prints no sums: its dynamic one is +1354 kg·mm².

    Examples
    --------
    >>> section_sums([2.0, 1.0], [0.0, 0.0], [5.0, -10.0], [10.0, 30.0]).dynamic_g_mm2
    (0.0, -200.0)
    """
    found = tables.section_sums(_sections(mass_g, x_mm, y_mm, z_mm))
    static, dynamic = found.resultant_g_mm.tolist(), found.moment_g_mm2.tolist()
    return SectionSums(math.fsum(mass_g), (static[0], static[1]), (dynamic[0], dynamic[1]))


def balancing_counterweights(
    mass_g: Sequence[float],
    x_mm: Sequence[float],
    y_mm: Sequence[float],
    z_mm: Sequence[float],
    first: int,
    second: int,
) -> TwoProducts:
    """Return the static products that two sections must have for no force and no couple.

    Parameters
    ----------
    mass_g, x_mm, y_mm, z_mm : list of float
        The whole crank with bob-weights, one entry a section [g, mm].
    first, second : int
        Places of the two counterweights in the lists, from 1; they stay where they are on the axis.

    References
    ----------
    Ruckle 2014, Sec. 3.1.1; "the one near the datum is heavier" is no rule.

    Examples
    --------
    >>> balancing_counterweights([1, 1, 1], [30, 0, 0], [0, 0, 0], [15, 5, 25], 2, 3).first_g_mm
    (-15.0, 0.0)
    """
    rows = _sections(mass_g, x_mm, y_mm, z_mm)
    for name, place in (("first", first), ("second", second)):
        if not 1 <= place <= len(rows):
            raise ValueError(f"{name} is {place}; the table has sections 1 to {len(rows)}")
    one, other = tables.balancing_products_g_mm(rows, str(first), str(second))
    return TwoProducts((float(one[0]), float(one[1]) + 0.0), (float(other[0]), float(other[1]) + 0.0))


def fan_counterweight(
    outer_radius_mm: float,
    inner_radius_mm: float,
    fan_angle_deg: float,
    thickness_mm: float,
    density_kg_m3: float = 7850.0,
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
    Ruckle 2014, Sec. 3.1.1; sensitivities 3R³/(R³ − r_i³), 1, (A/2)/tan(A/2).

    Examples
    --------
    >>> round(fan_counterweight(60.0, 25.0, 120.0, 20.0).product_g_mm, 1)
    18162.8
    """
    angle = math.radians(fan_angle_deg)
    return _fan(FanCounterweight(outer_radius_mm, inner_radius_mm, angle, thickness_mm, density_kg_m3))


def fan_counterweight_for(
    product_g_mm: float,
    change: str,
    outer_radius_mm: float,
    inner_radius_mm: float,
    fan_angle_deg: float,
    thickness_mm: float,
    density_kg_m3: float = 7850.0,
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
        If that size alone cannot reach it, or is not known.

    References
    ----------
    Ruckle 2014, Sec. 3.1.1.

    Examples
    --------
    >>> round(fan_counterweight_for(2 * 18162.84, "thickness", 60.0, 25.0, 120.0, 20.0).thickness_mm, 3)
    40.0
    """
    sizes: dict[str, Size] = {
        "outer_radius": "outer_radius_mm",
        "thickness": "thickness_mm",
        "fan_angle": "fan_angle_rad",
    }
    if change not in sizes:
        raise ValueError(f"change is {change!r}; must be one of {', '.join(sizes)}")
    fan = FanCounterweight(
        outer_radius_mm, inner_radius_mm, math.radians(fan_angle_deg), thickness_mm, density_kg_m3
    )
    return _fan(fan.solved_for(sizes[change], product_g_mm))


def substitute_rotor(
    polar_inertia_kg_mm2: float,
    disc_mm: float,
    shaft_mm: float,
    length_mm: float,
    density_kg_m3: float = 7850.0,
) -> Rotor:
    """Return a disc on a shaft that has a crank's polar inertia: t = (32 J/(π ρ) − d₂⁴ L₁)/(d₁⁴ − d₂⁴).

    Parameters
    ----------
    polar_inertia_kg_mm2 : float
        Wanted [kg·mm²].
    disc_mm, shaft_mm, length_mm : float
        Diameters and whole length [mm].
    density_kg_m3 : float

    Raises
    ------
    ValueError
        If there is no such disc.

    References
    ----------
    Hoem & Røsholm 2016, App. E; Table 7.2's thickness belongs to a disc of 100 mm: as printed J is 7.7 % low.

    Examples
    --------
    >>> round(substitute_rotor(2847.335, 98.0, 20.0, 188.0).thickness_mm, 3)
    39.799
    """
    found = SubstituteRotor.of_inertia(
        polar_inertia_kg_mm2 * KG_MM2, disc_mm, shaft_mm, length_mm, density_kg_m3
    )
    return _rotor(found)


def disc_rotor(
    disc_mm: float, shaft_mm: float, length_mm: float, thickness_mm: float, density_kg_m3: float = 7850.0
) -> Rotor:
    """Return mass and polar inertia of a disc in the middle of a shaft.

    Parameters
    ----------
    disc_mm, shaft_mm, length_mm, thickness_mm : float
        [mm]
    density_kg_m3 : float

    References
    ----------
    Hoem & Røsholm 2016, App. E, Table 7.2.

    Examples
    --------
    >>> round(disc_rotor(98.0, 20.0, 188.0, 39.799).polar_inertia_kg_mm2, 1)
    2847.4
    """
    return _rotor(SubstituteRotor(disc_mm, shaft_mm, length_mm, thickness_mm, density_kg_m3))


def _rotor(found: SubstituteRotor) -> Rotor:
    return Rotor(
        found.disc_mm,
        found.shaft_mm,
        found.length_mm,
        found.thickness_mm,
        found.shaft_end_mm,
        found.mass_g,
        found.polar_inertia_g_mm2 / KG_MM2,
    )


def _fan(fan: FanCounterweight) -> Fan:
    sensitivities = fan.sensitivities
    return Fan(
        fan.outer_radius_mm,
        fan.inner_radius_mm,
        math.degrees(fan.fan_angle_rad),
        fan.thickness_mm,
        fan.mass_g,
        fan.centre_mm,
        fan.product_g_mm,
        sensitivities["outer_radius_mm"],
        sensitivities["thickness_mm"],
        sensitivities["fan_angle_rad"],
    )


def _sections(
    mass_g: Sequence[float], x_mm: Sequence[float], y_mm: Sequence[float], z_mm: Sequence[float]
) -> list[tables.TableSection]:
    lengths = {len(mass_g), len(x_mm), len(y_mm), len(z_mm)}
    if len(lengths) != 1:
        raise ValueError("mass_g, x_mm, y_mm and z_mm must be of one length, an entry each section")
    rows = zip(mass_g, x_mm, y_mm, z_mm, strict=True)
    return [
        replace(tables.TableSection("", float(w), float(x), float(y), float(z)), name=str(place))
        for place, (w, x, y, z) in enumerate(rows, 1)
    ]
