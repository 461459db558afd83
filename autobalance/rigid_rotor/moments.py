"""Mass moments about a fixed origin: the currency of the program.

Moments add and subtract with the solids they belong to, so nothing here divides by a mass until
a centre is requested, and a body minus itself is simply zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalance.types import Array


@dataclass(frozen=True, eq=False)
class Moments:
    """Mass, first and second moments of a body about the origin of its frame.

    Attributes
    ----------
    mass_g : float
        ∫ dm [g].
    first_g_mm : (3,) float
        ∫ r dm [g·mm].
    second_g_mm2 : (3, 3) float
        ∫ r rᵀ dm, symmetric [g·mm²]. Its off-diagonals are +∫ x y dm, not products of inertia.
    """

    mass_g: float
    first_g_mm: Array
    second_g_mm2: Array

    @classmethod
    def zero(cls) -> Moments:
        return cls(0.0, np.zeros(3), np.zeros((3, 3)))

    @classmethod
    def point(cls, mass_g: float, position_mm: Array) -> Moments:
        """Return the moments of a point mass [g] at ``position_mm`` (3,) [mm]."""
        position = np.asarray(position_mm, dtype=np.float64)
        return cls(mass_g, mass_g * position, mass_g * np.outer(position, position))

    def __add__(self, other: Moments) -> Moments:
        return Moments(
            self.mass_g + other.mass_g,
            self.first_g_mm + other.first_g_mm,
            self.second_g_mm2 + other.second_g_mm2,
        )

    def __sub__(self, other: Moments) -> Moments:
        return self + other.scaled(-1.0)

    def scaled(self, factor: float) -> Moments:
        """Return the moments of the same body with its density multiplied by ``factor``."""
        return Moments(factor * self.mass_g, factor * self.first_g_mm, factor * self.second_g_mm2)

    def moved(self, placement: Array) -> Moments:
        """Return the moments after the body is moved by a rigid motion.

        Parameters
        ----------
        placement : (4, 4) float
            Homogeneous matrix from the old coordinates to the new, rotation and shift [mm].

        Returns
        -------
        Moments
            About the origin of the new coordinates.
        """
        turn, shift = placement[:3, :3], placement[:3, 3]
        first = turn @ self.first_g_mm
        cross = np.outer(first, shift)
        second = turn @ self.second_g_mm2 @ turn.T + cross + cross.T + self.mass_g * np.outer(shift, shift)
        return Moments(self.mass_g, first + self.mass_g * shift, second)

    @property
    def centre_mm(self) -> Array:
        """Centre of mass (3,) [mm]; raises ZeroDivisionError for a massless body."""
        if self.mass_g == 0.0:
            raise ZeroDivisionError("a body without mass has no centre of mass")
        return self.first_g_mm / self.mass_g

    @property
    def polar_inertia_g_mm2(self) -> float:
        """Mass moment of inertia about the z axis, ∫ (x² + y²) dm [g·mm²]."""
        return float(self.second_g_mm2[0, 0] + self.second_g_mm2[1, 1])

    @property
    def inertia_g_mm2(self) -> Array:
        """Inertia tensor (3, 3) about the origin, off-diagonals −∫ x y dm [g·mm²]."""
        inertia: Array = np.trace(self.second_g_mm2) * np.eye(3) - self.second_g_mm2
        return inertia
