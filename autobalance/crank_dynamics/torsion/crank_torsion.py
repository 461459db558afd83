"""A crank as a torsional chain: the stiffness of its throws by two published formulas, inertias by station.

Stations are the first main journal (with a damper), every throw, the last main journal (with a flywheel). A
throw is elastic from the middle of the journal before it to the middle of the journal after it, and its
inertia is in its middle: between two stations lie two half throws.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from autobalance.declare import Named, NotNegative, Positive
from autobalance.types import Array

MIN_EQUIVALENT_LENGTH = 1e-12
"""Smallest Le [1/mm³]: that of a solid shaft of 1 m diameter and 1 mm length."""


@dataclass(frozen=True)
class ThrowShape:
    """Dimensions of a throw for its stiffness, all mm; bores 0 where solid.

    ``journal_length_mm`` is that of one whole main journal between webs: half of each of its neighbours';
    ``pin_length_mm`` that of the crankpin between webs. ``web_breadth_mm`` is across the throw.
    """

    journal_mm: Positive
    journal_bore_mm: NotNegative
    journal_length_mm: NotNegative
    pin_mm: Annotated[Positive, Named("crankpin_mm")]
    pin_bore_mm: Annotated[NotNegative, Named("crankpin_bore_mm")]
    pin_length_mm: Annotated[NotNegative, Named("crankpin_length_mm")]
    crank_radius_mm: Positive
    web_thickness_mm: Positive
    web_breadth_mm: Positive

    @property
    def _journal4(self) -> float:
        return self.journal_mm**4 - self.journal_bore_mm**4

    @property
    def _pin4(self) -> float:
        return self.pin_mm**4 - self.pin_bore_mm**4

    @property
    def _web4(self) -> float:
        return self.web_thickness_mm * self.web_breadth_mm**3

    def ker_wilson_per_mm3(self) -> float:
        """Return Ker Wilson's equivalent length over D⁴ of a shaft as stiff as the throw [1/mm³].

        Examples
        --------
        >>> throw = ThrowShape(60, 0, 40, 50, 0, 30, 45, 20, 90)
        >>> round(math.pi * 80e3 / (32 * throw.ker_wilson_per_mm3()) / 1e3)
        541065
        """
        return (
            (self.journal_length_mm + 0.4 * self.journal_mm) / self._journal4
            + (self.pin_length_mm + 0.4 * self.pin_mm) / self._pin4
            + (self.crank_radius_mm - 0.2 * (self.journal_mm + self.pin_mm)) / self._web4
        )

    def carter_per_mm3(self) -> float:
        """Return Carter's equivalent length over D⁴ of a shaft as stiff as the throw [1/mm³]."""
        return (
            (self.journal_length_mm + 0.8 * self.web_thickness_mm) / self._journal4
            + 0.75 * self.pin_length_mm / self._pin4
            + 1.5 * self.crank_radius_mm / self._web4
        )


def throw_stiffness_n_m_rad(length_per_mm3: float, shear_modulus_mpa: float) -> float:
    """Return k = π G/(32 Le) of a throw [N·m/rad].

    Parameters
    ----------
    length_per_mm3 : float
        Le, the equivalent length over the fourth power of its diameter [1/mm³].
    shear_modulus_mpa : float
        G [MPa].

    References
    ----------
    W. Ker Wilson, Practical Solution of Torsional Vibration Problems, vol. 1; B. C. Carter, Engineering 126
    (1928) 36. Both are fits to measured crankshafts, right to some 10 to 20 %.

    Raises
    ------
    ValueError
        If the length is not positive: the webs are so broad that the formula does not hold.
    """
    if not length_per_mm3 > MIN_EQUIVALENT_LENGTH:
        raise ValueError("the formula gives a throw without torsional flexibility")
    return math.pi * shear_modulus_mpa / (32.0 * length_per_mm3) * 1e-3


def springs_between(throws_n_m_rad: Sequence[float]) -> Array:
    """Return the springs (throws + 1,) between first main, throws and last main."""
    half = 0.5 / np.asarray(throws_n_m_rad)
    ends = np.concatenate([[0.0], half, [0.0]])
    return np.asarray(1.0 / (ends[:-1] + ends[1:]))
