"""A crank as a table of sections: its sums, the two counterweights that would balance it, and its holes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.units import G_PER_MM3_PER_KG_M3, STEEL_KG_M3


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


def section_sums(
    mass_g: Sequence[float], x_mm: Sequence[float], y_mm: Sequence[float], z_mm: Sequence[float]
) -> SectionSums:
    """Return static sums Σ W (X, Y) and dynamic sums Σ W (X, Y) Z of a section table.

    Parameters
    ----------
    mass_g, x_mm, y_mm, z_mm : list of float
        One entry a section, its centre of mass [g, mm].

    References
    ----------
    Ruckle 2014, Eq. 5 to 8; Table 2 prints no sums: its dynamic one is +1354 kg·mm².

    Examples
    --------
    >>> section_sums([2.0, 1.0], [0.0, 0.0], [5.0, -10.0], [10.0, 30.0]).dynamic_g_mm2
    (0.0, -200.0)
    """
    total = _unbalance(mass_g, x_mm, y_mm, z_mm)
    (static_x, static_y), (dynamic_x, dynamic_y) = total.resultant_g_mm.tolist(), total.moment_g_mm2.tolist()
    return SectionSums(math.fsum(mass_g), (static_x, static_y), (dynamic_x, dynamic_y))


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
    Ruckle 2014, Sec. 3.1.1, requires that the counterweight near the datum is the heavier. This is not
    needed: without a resultant the couple does not depend on the datum.

    Examples
    --------
    >>> balancing_counterweights([1, 1, 1], [30, 0, 0], [0, 0, 0], [15, 5, 25], 2, 3).first_g_mm
    (-15.0, 0.0)
    """
    for name, place in (("first", first), ("second", second)):
        if not 1 <= place <= len(mass_g):
            raise ValueError(f"{name} is {place}; the table has sections 1 to {len(mass_g)}")
    other_g = [0.0 if place in (first, second) else mass for place, mass in enumerate(mass_g, 1)]
    rest = _unbalance(other_g, x_mm, y_mm, z_mm)
    one, other = rest.scaled(-1.0).in_planes(z_mm[first - 1], z_mm[second - 1])
    return TwoProducts((float(one[0]), float(one[1]) + 0.0), (float(other[0]), float(other[1]) + 0.0))


def _unbalance(
    mass_g: Sequence[float], x_mm: Sequence[float], y_mm: Sequence[float], z_mm: Sequence[float]
) -> Unbalance:
    """Return the unbalance of point masses."""
    if len({len(mass_g), len(x_mm), len(y_mm), len(z_mm)}) != 1:
        raise ValueError("mass_g, x_mm, y_mm and z_mm must be of one length, an entry each section")
    total = Moments.zero()
    for mass, *centre in zip(mass_g, x_mm, y_mm, z_mm, strict=True):
        total = total + Moments.point(float(mass), np.array(centre, dtype=np.float64))
    return Unbalance.of(total)


def cylinder_mass_g(diameter_mm: float, length_mm: float, density_kg_m3: float = STEEL_KG_M3) -> float:
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
    if not (diameter_mm > 0.0 and length_mm >= 0.0):
        raise ValueError(
            f"a cylinder of {diameter_mm:g} by {length_mm:g} mm; diameter must be > 0, length ≥ 0"
        )
    return math.pi / 4.0 * diameter_mm**2 * length_mm * density_kg_m3 * G_PER_MM3_PER_KG_M3


def final_hole_depth_mm(
    overbalance_g_mm: float, diameter_mm: float, rim_radius_mm: float, density_kg_m3: float = STEEL_KG_M3
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
    Ruckle 2014, Sec. 3.1.1: 1.5 to 2 kg·mm are left on purpose, so that the last step takes metal off.

    Examples
    --------
    >>> round(final_hole_depth_mm(1500.0, 20.0, 60.0), 2)
    11.18
    """
    area_density = cylinder_mass_g(diameter_mm, 1.0, density_kg_m3)
    under_root = rim_radius_mm**2 - 2.0 * overbalance_g_mm / area_density
    if overbalance_g_mm < 0.0 or under_root < 0.0:
        most = area_density * rim_radius_mm**2 / 2.0
        raise ValueError(
            f"a {diameter_mm:g} mm hole from a {rim_radius_mm:g} mm rim removes 0 to {most:.0f} g·mm;"
            f" {overbalance_g_mm:.0f} g·mm was requested"
        )
    return rim_radius_mm - math.sqrt(under_root)
