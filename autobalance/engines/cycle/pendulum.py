"""A pendulum absorber on the crank: the order that it takes, and the mass that an order of torque needs.

In a crank that turns evenly the mass moves in the field of the centrifugal force as a pendulum does under
gravity, φ″ = −(R/L) sin φ by the crank angle. Its frequency is an order of the speed, at any speed.
"""

from __future__ import annotations

import math
from typing import Literal

from autobalance.units import N_M_PER_G_MM2_S2
from autobalance.value_classes import dataclass

Path = Literal["circular", "epicycloidal"]


@dataclass(frozen=True)
class Pendulum:
    """A mass on a path about a pivot in the crank.

    Attributes
    ----------
    order : float
        It is tuned to, for small swings.
    distance_mm : float
        R, from the crank axis to the pivot (the centre of curvature of the path) [mm].
    path : "circular" or "epicycloidal"
        On the second the order is the same however far it swings.

    References
    ----------
    Hoem & Røsholm 2016, Sec. 3.1.1 (Borowski); Den Hartog 1956, *Mechanical Vibrations*, Sec. 5.9;
    Denman 1992, J. Sound Vib. 159, 251, for the path.

    Examples
    --------
    >>> Pendulum(2.0, 60.0).length_mm
    15.0
    """

    order: float
    distance_mm: float
    path: Path = "circular"

    def __post_init__(self) -> None:
        for name, value in (("order", self.order), ("distance_mm", self.distance_mm)):
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} of the pendulum is {value:g}; must be > 0")

    @property
    def length_mm(self) -> float:
        """L = R/n², from the pivot to the mass [mm]."""
        return self.distance_mm / self.order**2

    @property
    def widest_swing_rad(self) -> float:
        """Largest swing on the path: to its cusp, s = ρ/(n √(n² + 1)), or a quarter turn [rad]."""
        if self.path == "circular":
            return 0.5 * math.pi
        reach = (self.distance_mm + self.length_mm) / (self.order * math.sqrt(self.order**2 + 1.0))
        return reach / self.length_mm

    def order_at(self, swing_rad: float) -> float:
        """Return the order of a swing of ``swing_rad`` to each side (arc over L) about evenly turning pivot.

        Examples
        --------
        >>> round(Pendulum(2.0, 60.0).order_at(math.radians(60.0)), 4)
        1.8636
        >>> Pendulum(2.0, 60.0, "epicycloidal").order_at(math.radians(60.0))
        2.0
        """
        from scipy.special import ellipk

        if self.path == "epicycloidal":
            return self.order
        return self.order * 0.5 * math.pi / float(ellipk(math.sin(0.5 * swing_rad) ** 2))

    def torque_n_m(self, mass_g: float, swing_rad: float, speed_rad_s: float) -> float:
        """Return the torque m Ω² (R + L) R φ that it compares with its order at a small swing [N·m]."""
        arm = (self.distance_mm + self.length_mm) * self.distance_mm
        return mass_g * speed_rad_s**2 * arm * swing_rad * N_M_PER_G_MM2_S2

    def mass_g(self, torque_n_m: float, swing_rad: float, speed_rad_s: float) -> float:
        """Return the mass that takes a torque of its order at a swing [g]."""
        return torque_n_m / self.torque_n_m(1.0, swing_rad, speed_rad_s)

    def inertia_g_mm2(self, mass_g: float) -> float:
        """Return the mass's part of the crank's inertia, m (R + L)² [g·mm²]."""
        return mass_g * (self.distance_mm + self.length_mm) ** 2
