"""Safety against fatigue of a place where bending and torsion change over a cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Self

import numpy as np

from autobalance.declare import UNWRITTEN, NotNegative, Positive, record
from autobalance.types import Array

ADDITIONAL_BENDING_MPA = 10.0
"""σ_add of trunk piston engines, for misalignment and for axial and bending vibration [MPa]: IACS UR M53."""
LEAST_ACCEPTABILITY = 1.15
"""Smallest acceptability factor Q of a fillet: IACS UR M53."""
SHEAR_SHARE = 1.0 / math.sqrt(3.0)
"""Strength in torsion over that in bending, of ductile metal (von Mises)."""


@dataclass(frozen=True)
class FatigueMetal:
    """Strengths of the crank's metal [MPa]; ``yield_MPa`` None: not known."""

    tensile_MPa: float
    fatigue_MPa: float
    yield_MPa: float | None = None


@record
class FilletStress:
    """Local stress of a cycle: middle and half of its range, von Mises' equivalents.

    Attributes
    ----------
    equivalent_alternating_MPa : float
        √(σ_a² + 3 τ_a²) of the half ranges, whenever they are reached [1]_.
    greatest_MPa : float
        Largest √(σ² + 3 τ²) at any angle.

    References
    ----------
    .. [1] IACS UR M53, Sec. 5.2.
    """

    bending_mean_MPa: float
    bending_alternating_MPa: NotNegative
    torsion_mean_MPa: float
    torsion_alternating_MPa: NotNegative
    equivalent_alternating_MPa: NotNegative
    greatest_MPa: NotNegative


@record
class FilletSafety:
    """Safeties, smallest over the cycle; None without stress, or where the yield strength is not known.

    Attributes
    ----------
    gough_pollard : float or None
        1/√((σ_d/σ_f)² + (τ_d/τ_f)²): σ_d, τ_d how far each is from its middle, τ_f = σ_f/√3 [1]_.
    goodman : float or None
        1/(√(σ_d² + 3 τ_d²)/σ_f + √(σ_m² + 3 τ_m²)/R_m); of a mean bending that presses nothing is
        counted [2]_.
    iacs : float or None
        Fatigue strength over the equivalent alternating stress.
    yielding : float or None
        Yield over the largest stress.

    References
    ----------
    .. [1] Gough and Pollard, Proc. Inst. Mech. Eng. 131 (1935) 3: the ellipse of ductile metals.
    .. [2] Goodman, Mechanics applied to engineering, 1899.
    """

    gough_pollard: float | None
    goodman: float | None
    iacs: float | None
    yielding: float | None


@record
class Acceptability:
    """Criterion of IACS UR M53: fatigue strength over √((σ_a + σ_add)² + 3 τ_a²), at least ``wanted``."""

    additional_bending_MPa: NotNegative
    equivalent_MPa: Positive
    factor: Positive
    wanted: Positive
    met: bool

    @classmethod
    def of(cls, stress: FilletStress, fatigue_MPa: float) -> Self:
        bending = stress.bending_alternating_MPa + ADDITIONAL_BENDING_MPA
        equivalent = math.hypot(bending, stress.torsion_alternating_MPa / SHEAR_SHARE)
        factor = fatigue_MPa / equivalent
        return cls(
            additional_bending_MPa=ADDITIONAL_BENDING_MPA,
            equivalent_MPa=equivalent,
            factor=factor,
            wanted=LEAST_ACCEPTABILITY,
            met=factor >= LEAST_ACCEPTABILITY,
        )


@record
class Fatigue:
    """Fatigue of a cycle of stress; ``at`` is the number of the angle where two of the safeties are least."""

    stress: FilletStress
    fatigue_strength_MPa: Positive
    safety: FilletSafety
    m53: Acceptability
    at: Annotated[int, UNWRITTEN] = 0

    @classmethod
    def of(cls, bending_MPa: Array, torsion_MPa: Array, metal: FatigueMetal) -> Self:
        """Return the fatigue of local stresses (n,), (n,) [MPa] over a cycle."""
        mean_s, half_s = _range(bending_MPa)
        mean_t, half_t = _range(torsion_MPa)
        apart = np.hypot(bending_MPa - mean_s, (torsion_MPa - mean_t) / SHEAR_SHARE)
        at = int(np.argmax(apart))
        swing = float(apart[at]) / metal.fatigue_MPa
        steady = math.hypot(max(mean_s, 0.0), mean_t / SHEAR_SHARE) / metal.tensile_MPa
        greatest = float(np.hypot(bending_MPa, torsion_MPa / SHEAR_SHARE).max())
        equivalent = math.hypot(half_s, half_t / SHEAR_SHARE)
        stress = FilletStress(
            bending_mean_MPa=mean_s,
            bending_alternating_MPa=half_s,
            torsion_mean_MPa=mean_t,
            torsion_alternating_MPa=half_t,
            equivalent_alternating_MPa=equivalent,
            greatest_MPa=greatest,
        )
        safety = FilletSafety(
            gough_pollard=1.0 / swing if swing else None,
            goodman=1.0 / (swing + steady) if swing + steady else None,
            iacs=metal.fatigue_MPa / equivalent if equivalent else None,
            yielding=metal.yield_MPa / greatest if metal.yield_MPa and greatest else None,
        )
        return cls(
            stress=stress,
            fatigue_strength_MPa=metal.fatigue_MPa,
            safety=safety,
            m53=Acceptability.of(stress, metal.fatigue_MPa),
            at=at,
        )


def oil_bore_equivalent_MPa(bending_MPa: float, torsion_MPa: float) -> float:
    """Return the equivalent alternating stress at an oil bore's outlet: its largest principal stress [MPa].

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
