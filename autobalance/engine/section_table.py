"""A crank as a table of sections: its sums, and the two counterweights that would balance it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.moments import Array, Moments
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.units import G_PER_MM3_PER_KG_M3


@dataclass(frozen=True)
class TableSection:
    """A piece of the crank: what it weighs and where its centre of mass is."""

    name: str
    mass_g: float
    x_mm: float
    y_mm: float
    z_mm: float

    @property
    def product_g_mm(self) -> tuple[float, float]:
        """Static products W X and W Y [g·mm]."""
        return self.mass_g * self.x_mm, self.mass_g * self.y_mm

    @property
    def couple_g_mm2(self) -> tuple[float, float]:
        """Dynamic products W X Z and W Y Z [g·mm²]."""
        wx, wy = self.product_g_mm
        return wx * self.z_mm, wy * self.z_mm

    @property
    def moments(self) -> Moments:
        """Mass moments of the section, taken for a point."""
        return Moments.point(self.mass_g, np.array([self.x_mm, self.y_mm, self.z_mm]))


def section_sums(sections: Sequence[TableSection]) -> Unbalance:
    """Return the static sums (resultant) and the dynamic sums (moment about z = 0) of a section table.

    References
    ----------
    Ruckle 2014, Eq. 5 to 8 and Table 2; its sums are not printed, and its dynamic sum is not zero.

    Examples
    --------
    >>> table = [TableSection("cheek", 2.0, 0.0, 5.0, 10.0)]
    >>> table += [TableSection("counterweight", 1.0, 0.0, -10.0, 30.0)]
    >>> sums = section_sums(table)
    >>> sums.resultant_g_mm.tolist(), sums.moment_g_mm2.tolist()
    ([0.0, 0.0], [0.0, -200.0])
    """
    total = Moments.zero()
    for section in sections:
        total = total + section.moments
    return Unbalance.of(total)


def balancing_products_g_mm(sections: Sequence[TableSection], first: str, second: str) -> tuple[Array, Array]:
    """Return the static products (2,) that two sections must have for no force and no couple.

    Parameters
    ----------
    sections : sequence of Section
        The whole crank with bob-weights.
    first, second : str
        Names of the two counterweights that may change; they stay where they are on the axis.

    Returns
    -------
    ((2,) float, (2,) float)
        W (X, Y) of either [g·mm].

    References
    ----------
    Ruckle 2014, Sec. 3.1.1, says that the counterweight near the datum must be the heavier; it need not:
    without a resultant the couple does not depend on the datum.

    Examples
    --------
    >>> table = [TableSection("pin", 1.0, 30.0, 0.0, 15.0)]
    >>> table += [TableSection("A", 1.0, 0.0, 0.0, 5.0), TableSection("B", 1.0, 0.0, 0.0, 25.0)]
    >>> [float(product[0]) for product in balancing_products_g_mm(table, "A", "B")]
    [-15.0, -15.0]
    """
    named = {section.name: section for section in sections}
    for name in (first, second):
        if name not in named:
            raise ValueError(f"no section is called '{name}'; there are: {', '.join(named)}")
    rest = section_sums([section for section in sections if section.name not in (first, second)])
    one, other = rest.scaled(-1.0).in_planes(named[first].z_mm, named[second].z_mm)
    return one, other


def cylinder_mass_g(diameter_mm: float, length_mm: float, density_kg_m3: float) -> float:
    """Return the mass of a plain cylinder: a drilled hole, the oil in a crankpin, a slug [g].

    For a slug of heavy metal in its bore take the difference of the densities.

    Examples
    --------
    >>> round(cylinder_mass_g(8.0, 37.0, 7850.0), 1)  # Hoem & Røsholm 2016, Table 5.2, Case 2
    14.6
    """
    if not (diameter_mm > 0.0 and length_mm >= 0.0):
        raise ValueError(
            f"a cylinder of {diameter_mm:g} by {length_mm:g} mm; diameter must be > 0, length ≥ 0"
        )
    return math.pi / 4.0 * diameter_mm**2 * length_mm * density_kg_m3 * G_PER_MM3_PER_KG_M3


def oil_section(
    name: str, diameter_mm: float, length_mm: float, centre_mm: Array, density_kg_m3: float = 870.0
) -> TableSection:
    """Return the oil that fills a drilled pin, as a row of the section table.

    ``centre_mm`` (3,) is the middle of the drilling; 870 kg/m³ is engine oil at room temperature.

    Examples
    --------
    >>> round(oil_section("oil", 10.0, 40.0, np.array([30.0, 0.0, 15.0])).mass_g, 3)
    2.733
    """
    x, y, z = (float(value) for value in centre_mm)
    return TableSection(name, cylinder_mass_g(diameter_mm, length_mm, density_kg_m3), x, y, z)


def final_hole_depth_mm(
    overbalance_g_mm: float, diameter_mm: float, rim_radius_mm: float, density_kg_m3: float
) -> float:
    """Return the depth of a radial hole from the rim that takes off an overbalance [mm].

    ρ π/4 d² (R t − t²/2) = U; without a point. A crank is left overbalanced by 1.5 to 2 kg·mm so that the
    last step takes metal off (Ruckle 2014, Sec. 3.1.1).

    Raises
    ------
    ValueError
        If a hole to the crank axis would not be enough.

    Examples
    --------
    >>> round(final_hole_depth_mm(1500.0, 20.0, 60.0, 7850.0), 2)
    11.18
    """
    area_density = cylinder_mass_g(diameter_mm, 1.0, density_kg_m3)
    under_root = rim_radius_mm**2 - 2.0 * overbalance_g_mm / area_density
    if overbalance_g_mm < 0.0 or under_root < 0.0:
        most = area_density * rim_radius_mm**2 / 2.0
        raise ValueError(
            f"a {diameter_mm:g} mm hole from a {rim_radius_mm:g} mm rim takes off 0 to {most:.0f} g·mm;"
            f" {overbalance_g_mm:.0f} g·mm was asked for"
        )
    return rim_radius_mm - math.sqrt(under_root)
