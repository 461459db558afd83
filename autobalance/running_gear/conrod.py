"""The connecting rod as two masses: by the lever rule, by two scales, from a solid; and what that misses."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.declare import NotNegative, Positive
from autobalance.rigid_rotor.moments import Moments
from autobalance.types import Array


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
