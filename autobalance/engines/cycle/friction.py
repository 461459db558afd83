"""Friction of the main bearings by Coulomb, and of everything else as a mean pressure."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalance.types import Array
from autobalance.value_classes import dataclass


@dataclass(frozen=True)
class Friction:
    """Friction of main journals, pistons and auxiliaries.

    Attributes
    ----------
    main_mu : float
        Coefficient of friction of the dry main journals.
    chen_flynn : tuple of four float
        A, B, C, D of the friction mean pressure A + B p_max + C c_m + D c_m² in bar (rings, skirts,
        auxiliaries). The peak pressure p_max is in bar and the mean piston speed c_m in m/s.

    References
    ----------
    Chen and Flynn 1965, SAE 650733.
    """

    main_mu: float = 0.0
    chen_flynn: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def main_lever_mm(self, diameters_mm: Sequence[float]) -> Array:
        """Return the lever of each main's friction torque over its load, d/2 μ/√(1 + μ²) (m,) [mm].

        References
        ----------
        Hoem & Røsholm 2016, Eqs 4.9 and 4.10: the load attacks at the attitude angle atan μ.
        """
        share = self.main_mu / math.sqrt(1.0 + self.main_mu**2)
        return 0.5 * np.asarray(diameters_mm, dtype=np.float64) * share

    def mean_pressure_bar(self, peak_bar: float, piston_speed_m_s: float) -> float:
        """Return the friction mean pressure of one cylinder [bar].

        Examples
        --------
        >>> Friction(0.0, (0.4, 0.005, 0.09, 0.0009)).mean_pressure_bar(60.0, 10.0)
        1.69
        """
        constant, by_peak, by_speed, by_square = self.chen_flynn
        return constant + by_peak * peak_bar + by_speed * piston_speed_m_s + by_square * piston_speed_m_s**2


NO_FRICTION = Friction()
