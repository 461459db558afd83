"""Safety against fatigue of a place where bending and torsion change over a cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalance.types import Array

ADDITIONAL_BENDING_MPA = 10.0
"""σ_add of trunk piston engines, for misalignment and for axial and bending vibration [MPa]: IACS UR M53."""
LEAST_ACCEPTABILITY = 1.15
"""Least acceptability factor Q of a fillet: IACS UR M53."""
SHEAR_SHARE = 1.0 / math.sqrt(3.0)
"""Strength in torsion over that in bending, of ductile metal (von Mises)."""


@dataclass(frozen=True)
class FatigueMetal:
    """Strengths of the crank's metal [MPa]; ``yield_MPa`` None: not known."""

    tensile_MPa: float
    fatigue_MPa: float
    yield_MPa: float | None = None


@dataclass(frozen=True)
class Fatigue:
    """Fatigue of a cycle of stress.

    Attributes
    ----------
    bending_mean_MPa, bending_alternating_MPa : float
        Middle and half of the range.
    torsion_mean_MPa, torsion_alternating_MPa : float
    equivalent_alternating_MPa : float
        √(σ_a² + 3 τ_a²) of the half ranges, whenever they are reached [1]_.
    greatest_MPa : float
        Greatest √(σ² + 3 τ²) at any angle.
    gough_pollard : float or None
        Least, over the cycle, of 1/√((σ_d/σ_f)² + (τ_d/τ_f)²): σ_d, τ_d how far each is from its middle,
        τ_f = σ_f/√3 [2]_. None without any stress.
    goodman : float or None
        Least, over the cycle, of 1/(√(σ_d² + 3 τ_d²)/σ_f + √(σ_m² + 3 τ_m²)/R_m); of a mean bending that
        presses nothing is counted [3]_.
    yielding : float or None
        Yield over the greatest stress.
    at : int
        Where in the cycle the two are least: number of the angle.

    References
    ----------
    .. [1] IACS UR M53, Sec. 5.2.
    .. [2] Gough and Pollard, Proc. Inst. Mech. Eng. 131 (1935) 3: the ellipse of ductile metals.
    .. [3] Goodman, Mechanics applied to engineering, 1899.
    """

    bending_mean_MPa: float
    bending_alternating_MPa: float
    torsion_mean_MPa: float
    torsion_alternating_MPa: float
    equivalent_alternating_MPa: float
    greatest_MPa: float
    gough_pollard: float | None
    goodman: float | None
    yielding: float | None
    at: int

    @property
    def m53_equivalent_MPa(self) -> float:
        """√((σ_a + σ_add)² + 3 τ_a²), the equivalent alternating stress of IACS UR M53 [MPa]."""
        bending = self.bending_alternating_MPa + ADDITIONAL_BENDING_MPA
        return math.hypot(bending, self.torsion_alternating_MPa / SHEAR_SHARE)

    @classmethod
    def of(cls, bending_MPa: Array, torsion_MPa: Array, metal: FatigueMetal) -> Fatigue:
        """Return the fatigue of local stresses (n,), (n,) [MPa] over a cycle."""
        mean_s, half_s = _range(bending_MPa)
        mean_t, half_t = _range(torsion_MPa)
        apart = np.hypot(bending_MPa - mean_s, (torsion_MPa - mean_t) / SHEAR_SHARE)
        at = int(np.argmax(apart))
        swing = float(apart[at]) / metal.fatigue_MPa
        steady = math.hypot(max(mean_s, 0.0), mean_t / SHEAR_SHARE) / metal.tensile_MPa
        greatest = float(np.hypot(bending_MPa, torsion_MPa / SHEAR_SHARE).max())
        return cls(
            bending_mean_MPa=mean_s,
            bending_alternating_MPa=half_s,
            torsion_mean_MPa=mean_t,
            torsion_alternating_MPa=half_t,
            equivalent_alternating_MPa=math.hypot(half_s, half_t / SHEAR_SHARE),
            greatest_MPa=greatest,
            gough_pollard=1.0 / swing if swing else None,
            goodman=1.0 / (swing + steady) if swing + steady else None,
            yielding=metal.yield_MPa / greatest if metal.yield_MPa and greatest else None,
            at=at,
        )


def oil_bore_equivalent_MPa(bending_MPa: float, torsion_MPa: float) -> float:
    """Return the equivalent alternating stress at an oil bore's outlet: its greatest principal stress [MPa].

    σ_v = σ/3 (1 + 2 √(1 + 9/4 (τ/σ)²)) of the local alternating stresses, whose peaks lie at different places
    of the edge; no σ_add is counted [1]_. A small hole in a plate has exactly this (Kirsch).

    References
    ----------
    .. [1] IACS UR M53, Sec. 5.2.

    Examples
    --------
    >>> oil_bore_equivalent_MPa(90.0, 0.0), oil_bore_equivalent_MPa(0.0, 90.0)
    (90.0, 90.0)
    """
    return (bending_MPa + 2.0 * math.hypot(bending_MPa, 1.5 * torsion_MPa)) / 3.0


def _range(values: Array) -> tuple[float, float]:
    """Return the middle and the half of a range."""
    low, high = float(values.min()), float(values.max())
    return 0.5 * (low + high), 0.5 * (high - low)
