"""Fatigue in a crank's fillets: stress concentration, and safety against changing stress."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, ClassVar, Self

import numpy as np

from autobalance.declare import UNWRITTEN, NotNegative, Positive, record
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Safety against fatigue of a place where bending and torsion change over a cycle.


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


# Stress concentration in a crank's fillets: the factors of IACS UR M53, and their ranges.
#
# Each is local stress over the nominal one of the web's section (bending, shear) or of the pin's (torsion):
# products of polynomials fitted to strain gauges on many cranks. ``s`` is the overlap, ``w`` the web's
# thickness, ``b`` its breadth, ``r`` the fillet, ``d_journal`` and ``d_pin`` the bores, ``t`` the
# recesses, all over the crankpin's diameter.
#
# References
# ----------
# IACS Unified Requirement M53, "Calculations for I.C. Engine Crankshafts", Rev. 3, Sec. 3 and 6.


LEAST_OVERLAP = -0.5
"""Crankpins farther out than this concentrate no less."""
RANGES = {
    "s": (-math.inf, 0.5),
    "w": (0.2, 0.8),
    "b": (1.1, 2.2),
    "r": (0.03, 0.13),
    "d_journal": (0.0, 0.8),
    "d_pin": (0.0, 0.8),
}
"""Range of the formulas; s may be far below 0, with the value that ``FilletShape`` then takes."""
MEANING = {
    "s": "overlap of journal and crankpin over the crankpin",
    "w": "web thickness over the crankpin",
    "b": "web breadth over the crankpin",
    "r": "fillet over the crankpin",
    "d_journal": "journal bore over the crankpin",
    "d_pin": "crankpin bore over the crankpin",
}
FORGED_FACTOR = 1.0
"""K of a crank forged without continuous grain flow: 1.05 with it, 0.93 of cast steel with rolled fillets."""
LEAST_FILLET_MM = 2.0
"""Smaller fillets than this have the fatigue strength of this one."""


@dataclass(frozen=True)
class FilletFactors:
    """Local over nominal stress; ``shear`` 0 where none is counted (crankpin fillets)."""

    schema_name: ClassVar[str] = "Factors"
    bending: Positive
    shear: NotNegative
    torsion: Positive


@dataclass(frozen=True)
class FilletShape:
    """Dimensions behind the factors of one web's fillets, all mm; recesses are undercuts into the web."""

    pin_mm: float
    pin_bore_mm: float
    journal_mm: float
    journal_bore_mm: float
    crank_radius_mm: float
    web_thickness_mm: float
    web_breadth_mm: float
    pin_fillet_mm: float
    journal_fillet_mm: float
    pin_recess_mm: float = 0.0
    journal_recess_mm: float = 0.0

    @property
    def overlap_mm(self) -> float:
        """Overlap of journal and crankpin, seen along the axis; negative where they do not meet [mm]."""
        return 0.5 * (self.pin_mm + self.journal_mm) - self.crank_radius_mm

    @property
    def s(self) -> float:
        """Overlap over the crankpin's diameter."""
        return self.overlap_mm / self.pin_mm

    @property
    def w(self) -> float:
        """Web's thickness over the crankpin's diameter; without overlap of what the recesses leave."""
        recesses = 0.0 if self.overlap_mm >= 0.0 else self.pin_recess_mm + self.journal_recess_mm
        return (self.web_thickness_mm - recesses) / self.pin_mm

    @property
    def b(self) -> float:
        """Web's breadth over the crankpin's diameter."""
        return self.web_breadth_mm / self.pin_mm

    def ratios(self, fillet_mm: float) -> dict[str, float]:
        """Return every ratio that the factors of a fillet depend on."""
        return {
            "s": self.s,
            "w": self.w,
            "b": self.b,
            "r": fillet_mm / self.pin_mm,
            "d_journal": self.journal_bore_mm / self.pin_mm,
            "d_pin": self.pin_bore_mm / self.pin_mm,
        }

    def outside(self, fillet_mm: float) -> tuple[str, ...]:
        """Return, in words, the ratios of a fillet that are outside of the range of the formulas."""
        beyond = []
        for name, value in self.ratios(fillet_mm).items():
            low, high = RANGES[name]
            if not low <= value <= high:
                reach = f"{low:g} to {high:g}" if low > -math.inf else f"at most {high:g}"
                beyond.append(f"{MEANING[name]} is {value:.3g}; the factors hold for {reach}")
        return tuple(beyond)

    @property
    def crankpin(self) -> FilletFactors:
        """Factors of the crankpin's fillet: α_B and α_T."""
        return FilletFactors(self._pin_bending, 0.0, self._torsion(self.pin_fillet_mm / self.pin_mm))

    @property
    def journal(self) -> FilletFactors:
        """Factors of the journal's fillet: β_B, β_Q and β_T."""
        torsion = self._torsion(self.journal_fillet_mm / self.journal_mm)
        return FilletFactors(self._journal_bending, self._journal_shear, torsion)

    @property
    def _recess(self) -> float:
        factor = 1.0 + (self.pin_recess_mm + self.journal_recess_mm) / self.pin_mm * (1.8 + 3.2 * self.s)
        return max(factor, 1.0)

    @property
    def _apart(self) -> float:
        """1 − s, the overlap not below what the formulas reach."""
        return 1.0 - max(self.s, LEAST_OVERLAP)

    @property
    def _pin_bending(self) -> float:
        w, b, apart = self.w, self.b, self._apart
        d_journal, d_pin = self.journal_bore_mm / self.pin_mm, self.pin_bore_mm / self.pin_mm
        overlap = (
            _polynomial(w, (-4.1883, 29.2004, -77.5925, 91.9454, -40.0416))
            + apart * _polynomial(w, (9.5440, -58.3480, 159.3415, -192.5846, 85.2916))
            + apart**2 * _polynomial(w, (-3.8399, 25.0444, -70.5571, 87.0328, -39.1832))
        )
        return (
            2.6914
            * overlap
            * (2.1790 * float(w**0.7171))
            * _polynomial(b, (0.6840, -0.0077, 0.1473))
            * (0.2081 * float((self.pin_fillet_mm / self.pin_mm) ** -0.5231))
            * _polynomial(d_journal, (0.9993, 0.27, -1.0211, 0.5306))
            * _polynomial(d_pin, (0.9978, 0.3145, -1.5241, 2.4147))
            * self._recess
        )

    @property
    def _journal_bending(self) -> float:
        w, b, apart = self.w, self.b, self._apart
        d_journal, d_pin = self.journal_bore_mm / self.pin_mm, self.pin_bore_mm / self.pin_mm
        overlap = (
            _polynomial(w, (-1.7625, 2.9821, -1.5276))
            + apart * _polynomial(w, (5.1169, -5.8089, 3.1391))
            + apart**2 * _polynomial(w, (-2.1567, 2.3297, -1.2952))
        )
        return (
            2.7146
            * overlap
            * (2.2422 * float(w**0.7548))
            * _polynomial(b, (0.5616, 0.1197, 0.1176))
            * (0.1908 * float((self.journal_fillet_mm / self.pin_mm) ** -0.5568))
            * _polynomial(d_journal, (1.0012, -0.6441, 1.2265))
            * _polynomial(d_pin, (1.0022, -0.1903, 0.0073))
            * self._recess
        )

    @property
    def _journal_shear(self) -> float:
        d_pin = self.pin_bore_mm / self.pin_mm
        return (
            3.0128
            * _polynomial(self._apart, (0.4368, 2.1630, -1.5212))
            * (self.w / (0.0637 + 0.9369 * self.w))
            * (self.b - 0.5)
            * (0.5331 * float((self.journal_fillet_mm / self.pin_mm) ** -0.2038))
            * _polynomial(d_pin, (0.9937, -1.1949, 1.7373))
            * self._recess
        )

    def _torsion(self, r: float) -> float:
        """Return α_T or β_T of a fillet over the diameter of its pin."""
        return (
            0.8
            * float(r ** (-0.3220 + 0.1015 * self._apart))
            * _polynomial(self.b, (7.8955, -10.654, 5.3482, -0.857))
            * float(self.w**-0.145)
        )


def _polynomial(x: float, coefficients: Sequence[float]) -> float:
    """Return c₀ + c₁ x + c₂ x² and so on."""
    return float(sum(each * x**power for power, each in enumerate(coefficients)))


MAX_OIL_BORE_RATIO = 0.2
"""Largest diameter of an oil bore over the crankpin's for which its factors were measured: IACS UR M53."""


def oil_bore_factors(bore_mm: float, pin_mm: float) -> FilletFactors:
    """Return the factors of the outlet of a radial oil bore in a crankpin, local over nominal stress.

    γ_B = 3 − 5.88 d + 34.6 d², γ_T = 4 − 6 d + 30 d² with d the bore's diameter over the crankpin's [1]_.

    References
    ----------
    .. [1] IACS UR M53, Sec. 3.4; d up to 0.2. A small hole in a plate has 3 (Kirsch) and 4.

    Examples
    --------
    >>> factors = oil_bore_factors(5.0, 50.0)
    >>> round(factors.bending, 3), round(factors.torsion, 3)
    (2.758, 3.7)
    """
    ratio = bore_mm / pin_mm
    return FilletFactors(_polynomial(ratio, (3.0, -5.88, 34.6)), 0.0, _polynomial(ratio, (4.0, -6.0, 30.0)))


def polar_modulus_mm3(diameter_mm: float, bore_mm: float) -> float:
    """Return the polar section modulus of a round bar, torque over shear stress, π/16 (D⁴ − d⁴)/D."""
    return math.pi / 16.0 * (diameter_mm**4 - bore_mm**4) / diameter_mm


def fatigue_strength_MPa(
    tensile_MPa: float, diameter_mm: float, fillet_mm: float, k: float = FORGED_FACTOR
) -> float:
    """Return the alternating stress that a crank without surface treatment bears in its fillets for ever.

    σ_DW = K (0.42 σ_B + 39.3) (0.264 + 1.073 D^−0.2 + (785 − σ_B)/4900 + 196/σ_B √(1/R)) [1]_, of von Mises'
    equivalent stress.

    Parameters
    ----------
    tensile_MPa : float
        Tensile strength σ_B, positive [MPa].
    diameter_mm : float
        Of the crankpin or journal, D [mm].
    fillet_mm : float
        R, taken as 2 mm where it is less [mm].
    k : float
        1 for free-form forgings, 1.05 with continuous grain flow, 0.93 for cast steel with rolled fillets.

    References
    ----------
    .. [1] IACS UR M53, Sec. 6.

    Examples
    --------
    >>> round(fatigue_strength_MPa(800.0, 200.0, 10.0), 1)
    266.6
    """
    if not (tensile_MPa > 0.0 and diameter_mm > 0.0 and fillet_mm > 0.0):
        raise ValueError("tensile strength, diameter and fillet must be > 0")
    radius = max(fillet_mm, LEAST_FILLET_MM)
    size = 0.264 + 1.073 * float(diameter_mm**-0.2) + (785.0 - tensile_MPa) / 4900.0
    return k * (0.42 * tensile_MPa + 39.3) * (size + 196.0 / tensile_MPa * math.sqrt(1.0 / radius))
