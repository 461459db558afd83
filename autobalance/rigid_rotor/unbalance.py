"""Unbalance of a rotor that turns about z, as a resultant with its moment or as two vectors in two planes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.rigid_rotor.moments import Moments
from autobalance.types import Array
from autobalance.units import wrapped_deg


@dataclass(frozen=True, eq=False)
class Unbalance:
    """Resultant unbalance and moment unbalance about the plane z = 0.

    Attributes
    ----------
    resultant_g_mm : (2,) float
        U = ∫ (x, y) dm [g·mm].
    moment_g_mm2 : (2,) float
        P = ∫ z (x, y) dm, about z = 0 [g·mm²]. A couple only where the resultant is zero.
    of_moments : Moments or None
        The moments that it is of; None for sums and readings. Another axis needs the mass as well.
    """

    resultant_g_mm: Array
    moment_g_mm2: Array
    of_moments: Moments | None = None

    @classmethod
    def of(cls, moments: Moments) -> Unbalance:
        return cls(moments.first_g_mm[:2].copy(), moments.second_g_mm2[:2, 2].copy(), moments)

    @property
    def components(self) -> Array:
        """U and P side by side (4,) [g·mm, g·mm²]."""
        return np.concatenate([self.resultant_g_mm, self.moment_g_mm2])

    @classmethod
    def of_planes(cls, plane_unbalance_g_mm: Array, z_a_mm: float, z_b_mm: float) -> Unbalance:
        """Return the unbalance of two vectors (2, 2) [g·mm] that act at z_a and z_b."""
        a, b = plane_unbalance_g_mm
        return cls(a + b, z_a_mm * a + z_b_mm * b)

    def __add__(self, other: Unbalance) -> Unbalance:
        return Unbalance(
            self.resultant_g_mm + other.resultant_g_mm,
            self.moment_g_mm2 + other.moment_g_mm2,
        )

    def __sub__(self, other: Unbalance) -> Unbalance:
        return self + other.scaled(-1.0)

    def scaled(self, factor: float) -> Unbalance:
        return Unbalance(factor * self.resultant_g_mm, factor * self.moment_g_mm2)

    def moment_about_g_mm2(self, z_mm: float) -> Array:
        """Return the moment unbalance (2,) about the plane at ``z_mm`` [g·mm²]: P − z U."""
        return self.moment_g_mm2 - z_mm * self.resultant_g_mm

    def in_planes(self, z_a_mm: float, z_b_mm: float) -> Array:
        """Return the equivalent unbalance vectors in two planes (dynamic unbalance).

        U_A = (z_B U − P)/(z_B − z_A), U_B = (P − z_A U)/(z_B − z_A).

        Parameters
        ----------
        z_a_mm, z_b_mm : float
            Places of the planes on the axis; they must differ [mm].

        Returns
        -------
        (2, 2) float
            One row a plane, A first [g·mm].

        Raises
        ------
        ValueError
            If the planes coincide.

        References
        ----------
        ISO 21940-11:2016, 4.5: representations of the unbalance of a rigid rotor.

        Examples
        --------
        >>> Unbalance(np.array([10.0, 20.0]), np.array([0.0, 0.0])).in_planes(-30.0, 10.0).tolist()
        [[2.5, 5.0], [7.5, 15.0]]
        """
        span = z_b_mm - z_a_mm
        if span == 0.0:
            raise ValueError(f"both planes are at z = {z_a_mm:g} mm; they must differ")
        a = (z_b_mm * self.resultant_g_mm - self.moment_g_mm2) / span
        return np.stack([a, self.resultant_g_mm - a])

    @property
    def magnitude_g_mm(self) -> float:
        """Length of the resultant [g·mm]."""
        return math.hypot(*self.resultant_g_mm)

    @property
    def angle_rad(self) -> float:
        """Direction of the resultant, the heavy side, in [0, 2π) from x towards y [rad]."""
        angle = math.atan2(self.resultant_g_mm[1], self.resultant_g_mm[0])
        return angle % (2.0 * math.pi) % (2.0 * math.pi)  # twice: −1e-17 % 2π is 2π itself

    @property
    def angle_deg(self) -> float:
        """Direction of the resultant, the heavy side, in [0, 360)."""
        return wrapped_deg(math.degrees(self.angle_rad))
