"""The connecting rod as two masses, and a crank as a table of sections."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.declare import NotNegative, Positive
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.types import Array
from autobalance.units import G_PER_MM3_PER_KG_M3, STEEL_KG_M3
from autobalance.value_classes import dataclass

# The connecting rod as two masses: by the lever rule, by two scales, from a solid; and what that misses.


@dataclass(frozen=True)
class ConnectingRod:
    """A rigid connecting rod.

    Attributes
    ----------
    mass_g : float
        Of the whole rod [g].
    length_mm : float
        Between the centres of its eyes [mm].
    centre_from_big_end_mm : float
        Distance of the centre of mass from the big end's centre, along the rod [mm].
    inertia_g_mm2 : float or None
        Mass moment of inertia about an axis through the centre of mass, parallel to the eyes; None where it
        is not known: then the rod is taken for its two masses [g·mm²].

    Examples
    --------
    >>> rod = ConnectingRod(mass_g=1673.4, length_mm=152.0, centre_from_big_end_mm=37.36)
    >>> round(rod.big_end_g, 1), round(rod.small_end_g, 1)
    (1262.1, 411.3)
    """

    mass_g: float
    length_mm: float
    centre_from_big_end_mm: float
    inertia_g_mm2: float | None = None

    def __post_init__(self) -> None:
        for name, value, unit in (("mass", self.mass_g, "g"), ("length", self.length_mm, "mm")):
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} of the connecting rod is {value:g} {unit}; must be > 0")
        if not 0.0 <= self.centre_from_big_end_mm <= self.length_mm:
            raise ValueError(
                f"the rod's centre of mass lies {self.centre_from_big_end_mm:g} mm from its big end;"
                f" must be within its length, 0 to {self.length_mm:g} mm"
            )
        if self.inertia_g_mm2 is not None and not self.inertia_g_mm2 >= 0.0:
            raise ValueError(f"inertia of the connecting rod is {self.inertia_g_mm2:g} g·mm²; must be ≥ 0")

    @classmethod
    def from_two_scales(
        cls, big_end_g: float, small_end_g: float, length_mm: float, inertia_g_mm2: float | None = None
    ) -> ConnectingRod:
        """Return the rod that lies level on two scales, one under each eye.

        Examples
        --------
        >>> rod = ConnectingRod.from_two_scales(1262.4, 411.4, 152.0)
        >>> round(rod.mass_g, 1), round(rod.centre_from_big_end_mm, 2)
        (1673.8, 37.36)
        """
        for name, value in (("big end", big_end_g), ("small end", small_end_g)):
            if not 0.0 <= value < math.inf:
                raise ValueError(f"the {name} weighs {value:g} g; must be ≥ 0")
        mass = big_end_g + small_end_g
        centre = length_mm * small_end_g / mass if mass > 0.0 else 0.0
        return cls(mass, length_mm, centre, inertia_g_mm2)

    @classmethod
    def from_solid(cls, moments: Moments, big_end_mm: Array, small_end_mm: Array) -> ConnectingRod:
        """Return the rod of a solid's mass moments.

        Parameters
        ----------
        moments : Moments
            Of the rod, in any frame whose z axis is parallel to the eyes.
        big_end_mm, small_end_mm : (3,) float
            Centres of the eyes in that frame [mm].

        Examples
        --------
        >>> big, small = np.array([0.0, 0.0, 0.0]), np.array([100.0, 0.0, 0.0])
        >>> two_masses = Moments.point(300.0, big) + Moments.point(100.0, small)
        >>> ConnectingRod.from_solid(two_masses, big, small).small_end_g
        100.0
        """
        along = np.asarray(small_end_mm, dtype=np.float64)[:2] - np.asarray(big_end_mm, dtype=np.float64)[:2]
        length = math.hypot(*along)
        if length == 0.0:
            raise ValueError("both eyes of the connecting rod have one centre; their axes must be apart")
        centre = moments.centre_mm
        from_big_end = float((centre[:2] - np.asarray(big_end_mm)[:2]) @ along) / length
        inertia = moments.polar_inertia_g_mm2 - moments.mass_g * float(centre[:2] @ centre[:2])
        return cls(moments.mass_g, length, from_big_end, inertia)

    @property
    def small_end_g(self) -> float:
        """Weight of the small end on a scale, and the part that moves with the piston: m a/l [g]."""
        return self.mass_g * self.centre_from_big_end_mm / self.length_mm

    @property
    def big_end_g(self) -> float:
        """Weight of the big end on a scale, and the part that turns with the crankpin [g]."""
        return self.mass_g - self.small_end_g

    @property
    def two_mass_inertia_g_mm2(self) -> float:
        """Inertia m a b about the centre of mass of the two masses at the eyes [g·mm²].

        References
        ----------
        Hoem & Røsholm 2016, Sec. 4.1.1: its third condition, equal inertia, two masses cannot meet.
        """
        return self.mass_g * self.centre_from_big_end_mm * (self.length_mm - self.centre_from_big_end_mm)

    @property
    def couple_inertia_g_mm2(self) -> float:
        """I − m a b: times the rod's angular acceleration, the couple that the two masses miss [g·mm²]."""
        return 0.0 if self.inertia_g_mm2 is None else self.inertia_g_mm2 - self.two_mass_inertia_g_mm2


@dataclass(frozen=True)
class TwoMasses:
    """A rod as two masses at its eyes; no centre of mass where its length is not known."""

    mass_g: Positive
    big_end_g: NotNegative
    small_end_g: NotNegative
    centre_from_big_end_mm: float | None


@dataclass(frozen=True)
class CutRod:
    """A rod cut at its centre of mass: what the cut puts at the wrong end.

    Each half weighs what it weighs, but its centre is not at the eye: the sum is right and the centre of
    mass is not.

    Attributes
    ----------
    moved_g : float
        Mass that the cut puts at the small end instead of the big end [g].
    small_end_share : float
        Small piece ÷ whole rod; the lever rule gives the centre's distance from the big end ÷ length.
    warning : str
        The cut's error, in one line.
    """

    moved_g: float
    small_end_share: float
    warning: str


def cut_at_centre_of_mass(rod: ConnectingRod, big_half_g: float, small_half_g: float) -> CutRod:
    """Compare a rod cut at its centre of mass, two pieces [g], with the lever rule."""
    moved = small_half_g - rod.small_end_g
    side = "small" if moved >= 0.0 else "big"
    return CutRod(
        moved,
        small_half_g / (big_half_g + small_half_g),
        f"a rod cut at its centre of mass adds a false {abs(moved):.1f} g at the {side} end;"
        " use the lever rule (two scales)",
    )


def conrod_cut_in_two(big_end_g: float, small_end_g: float, big_half_g: float, small_half_g: float) -> CutRod:
    """Compare a rod cut at its centre of mass with the lever rule; for comparison only.

    Parameters
    ----------
    big_end_g, small_end_g : float
        On two scales [g].
    big_half_g, small_half_g : float
        What the two pieces of the cut rod weigh [g].

    References
    ----------
    Ruckle 2014, Sec. 3.1.3, cuts the rod (1015.9 and 657.5 g); Sec. 3.3.1 weighs it (1262.4 and 411.4 g).

    Examples
    --------
    >>> round(conrod_cut_in_two(1262.4, 411.4, 1015.9, 657.5).moved_g, 1)
    246.1
    """
    rod = ConnectingRod.from_two_scales(big_end_g, small_end_g, 1.0)
    return cut_at_centre_of_mass(rod, big_half_g, small_half_g)


# A crank as a table of sections: its sums, the two counterweights that would balance it, and its holes.


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
