"""Outlets of the oil bores in a job's crankpins: what the cycle does to each, and how safe it is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Self

import numpy as np

from autobalance.balancing.measured import Crank
from autobalance.crank_dynamics.strength.fatigue import (
    LEAST_ACCEPTABILITY,
    MAX_OIL_BORE_RATIO,
    FilletFactors,
    fatigue_strength_MPa,
    oil_bore_equivalent_MPa,
    oil_bore_factors,
    polar_modulus_mm3,
)
from autobalance.crank_dynamics.strength.fillets_from_job import (
    FilletRow,
    LeastSafety,
    checked_strength,
    extremes,
)
from autobalance.crank_dynamics.strength.web_loads import crankpin_loads
from autobalance.crank_dynamics.torsion.from_job import sides_of_throws
from autobalance.crank_dynamics.torsion.vibration_torques import ThrowVibration
from autobalance.declare import Degrees, NotNegative, Ordinal, Pair, Positive, record
from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.errors import JobError
from autobalance.job import Job
from autobalance.types import Array
from autobalance.units import N_MM_PER_N_M
from autobalance.value_classes import dataclass

ANGLES = 360
"""Angles of the outlet that are tried if the job states no angle: to 4e-5 of the largest bending."""


@dataclass(frozen=True, eq=False)
class OilBoreOutlet:
    """The outlet of an oil bore in the middle of a crankpin, over the cycle.

    Attributes
    ----------
    throw : int
        Its number.
    angle_rad : float
        Direction of the outlet from the crankpin's axis, from the direction away from the crank axis.
    bending_MPa, torsion_MPa : (n,) float
        Nominal stresses of the crankpin there, without the hole; bending positive where it stretches.
    factors : FilletFactors
        Local over nominal stress.
    outside : tuple of str
        Which ratio is outside of the range of the factors.
    fatigue_MPa : float
        What it bears for ever.
    """

    throw: int
    angle_rad: float
    bending_MPa: Array
    torsion_MPa: Array
    factors: FilletFactors
    outside: tuple[str, ...]
    fatigue_MPa: float

    @property
    def alternating_MPa(self) -> tuple[float, float]:
        """Half of the range of the local stress by bending and by torsion [MPa]."""
        bending, torsion = (0.5 * float(np.ptp(each)) for each in (self.bending_MPa, self.torsion_MPa))
        return self.factors.bending * bending, self.factors.torsion * torsion

    @property
    def equivalent_MPa(self) -> float:
        """Equivalent alternating stress by IACS UR M53 [MPa]."""
        return oil_bore_equivalent_MPa(*self.alternating_MPa)


@record
class OilBoreNominal:
    """Smallest and largest nominal stress of a cycle at an oil bore's outlet, as if there were no hole."""

    bending_MPa: Pair
    torsion_MPa: Pair


@record
class OilBoreStress:
    """Local alternating stress at an oil bore's outlet, and its equivalent by IACS UR M53."""

    bending_alternating_MPa: NotNegative
    torsion_alternating_MPa: NotNegative
    equivalent_alternating_MPa: NotNegative


@record
class OilBoreCriterion:
    """Criterion of IACS UR M53: fatigue strength over the equivalent stress; null without any stress."""

    factor: Positive | None
    wanted: Positive
    met: bool


@record
class OilBoreRow:
    """The outlet of a crankpin's oil bore: what the cycle does to it, and how safe it is."""

    throw: Ordinal
    angle_rad: Degrees
    nominal: OilBoreNominal
    factors: FilletFactors
    outside_of_range: Sequence[str]
    stress: OilBoreStress
    fatigue_strength_MPa: Positive
    m53: OilBoreCriterion

    @classmethod
    def of(cls, outlet: OilBoreOutlet) -> Self:
        bending, torsion = outlet.alternating_MPa
        equivalent = outlet.equivalent_MPa
        factor = outlet.fatigue_MPa / equivalent if equivalent else None
        return cls(
            throw=outlet.throw,
            angle_rad=outlet.angle_rad,
            nominal=OilBoreNominal(
                bending_MPa=extremes(outlet.bending_MPa),
                torsion_MPa=extremes(outlet.torsion_MPa),
            ),
            factors=outlet.factors,
            outside_of_range=outlet.outside,
            stress=OilBoreStress(
                bending_alternating_MPa=bending,
                torsion_alternating_MPa=torsion,
                equivalent_alternating_MPa=equivalent,
            ),
            fatigue_strength_MPa=outlet.fatigue_MPa,
            m53=OilBoreCriterion(
                factor=factor, wanted=LEAST_ACCEPTABILITY, met=factor is None or factor >= LEAST_ACCEPTABILITY
            ),
        )


@record
class FilletState:
    """All fillets and oil bores of a crank, as it was or is."""

    fillets: Sequence[FilletRow]
    least: LeastSafety | None
    oil_bores: Sequence[OilBoreRow]

    @classmethod
    def of(cls, fillets: Sequence[FilletRow], outlets: Sequence[OilBoreOutlet]) -> Self:
        return cls(
            fillets=fillets,
            least=LeastSafety.of(fillets),
            oil_bores=[OilBoreRow.of(each) for each in outlets],
        )


def oil_bores(
    job: Job, crank: Crank, cycle: CycleAnalysis, vibration: Sequence[ThrowVibration] | None = None
) -> list[OilBoreOutlet]:
    """Return the outlet of each crankpin's oil bore, in the order of the axis; none if no bore is stated.

    Parameters
    ----------
    job : Job
        With ``[strength]``.
    crank : Crank
    cycle : CycleAnalysis
        Of that crank.
    vibration : sequence of ThrowVibration or None
        What torsional vibration adds, by throw; None: it is left out.

    Raises
    ------
    JobError
        If a bore is as wide as its crankpin.
    """
    strength = checked_strength(job)
    bore = strength.oil_bore
    if bore is None:
        return []
    loads = crankpin_loads(cycle, job, crank.anatomy, crank.source.solid, crank.density_g_mm3)
    outlets = []
    for (side, _), load in zip(sides_of_throws(crank), loads, strict=True):
        if bore.diameter_mm >= side.pin_mm:
            raise JobError(
                f"strength.oil_bore.diameter_mm is {bore.diameter_mm:g}; crankpin {load.throw} is "
                f"{side.pin_mm:.4g} mm thick, and it must be less"
            )
        modulus = 0.5 * polar_modulus_mm3(side.pin_mm, side.pin_bore_mm)
        along_across = -N_MM_PER_N_M * load.bending_n_m / modulus
        angle = _worst_rad(along_across) if bore.angle_rad is None else bore.angle_rad
        torque = load.torque_n_m + (0.0 if vibration is None else vibration[load.throw - 1].crankpin_n_m)
        ratio = bore.diameter_mm / side.pin_mm
        above = () if ratio <= MAX_OIL_BORE_RATIO else (_outside(load.throw, ratio),)
        outlets.append(
            OilBoreOutlet(
                throw=load.throw,
                angle_rad=angle,
                bending_MPa=along_across @ np.array([math.cos(angle), math.sin(angle)]),
                torsion_MPa=N_MM_PER_N_M * torque / (2.0 * modulus),
                factors=oil_bore_factors(bore.diameter_mm, side.pin_mm),
                outside=above,
                fatigue_MPa=fatigue_strength_MPa(strength.tensile_MPa, side.pin_mm, 0.5 * bore.diameter_mm),
            )
        )
    return outlets


def _outside(throw: int, ratio: float) -> str:
    return f"oil bore over crankpin {throw} = {ratio:.3g}, at most {MAX_OIL_BORE_RATIO:g}"


def _worst_rad(along_across_MPa: Array) -> float:
    """Return the angle, 0 to π, at which bending (n, 2) swings most; beyond π it is the same."""
    angles = np.arange(ANGLES) * math.pi / ANGLES
    ranges = np.ptp(along_across_MPa @ np.stack([np.cos(angles), np.sin(angles)]), axis=0)
    return float(angles[np.argmax(ranges)])
