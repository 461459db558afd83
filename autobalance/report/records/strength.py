"""The report of `strength`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Self

import numpy as np

from autobalance.declare import (
    ABSENT,
    Absent,
    Degrees,
    NotNegative,
    Ordinal,
    Pair,
    Positive,
    record,
)
from autobalance.engine.fatigue import ADDITIONAL_BENDING_MPA, LEAST_ACCEPTABILITY
from autobalance.engine.fillet_factors import FilletShape, polar_modulus_mm3
from autobalance.machine_models.fillets_from_job import N_MM_PER_N_M, Costs, Fillet, Place, Side
from autobalance.machine_models.oil_bores import OilBoreOutlet
from autobalance.machine_models.throw_stress import FilletByElements, ThrowByElements
from autobalance.machine_models.vibration_torques import ThrowVibration
from autobalance.report.records.head import Head, JobEcho
from autobalance.types import Array


@record
class NominalStress:
    """Least and greatest nominal stress of a cycle: of the web's section, of the pin's in torsion."""

    bending_MPa: Pair
    shear_MPa: Pair
    torsion_MPa: Pair

    @classmethod
    def of(cls, fillet: Fillet) -> Self:
        return cls(
            bending_MPa=_ends(fillet.bending_MPa),
            shear_MPa=_ends(fillet.shear_MPa),
            torsion_MPa=_ends(fillet.torsion_MPa),
        )


@record
class Factors:
    """Local over nominal stress; of shear 0 where none is counted."""

    bending: Positive
    shear: NotNegative
    torsion: Positive


@record
class FilletStress:
    """Local stress of a cycle: middle and half of its range, von Mises' equivalents."""

    bending_mean_MPa: float
    bending_alternating_MPa: NotNegative
    torsion_mean_MPa: float
    torsion_alternating_MPa: NotNegative
    equivalent_alternating_MPa: NotNegative
    greatest_MPa: NotNegative


@record
class FilletSafety:
    """Safeties, least over the cycle; null without stress, or where the yield strength is not known."""

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
    def of(cls, fillet: Fillet) -> Self:
        equivalent = fillet.fatigue.m53_equivalent_MPa
        factor = fillet.fatigue_MPa / equivalent
        return cls(
            additional_bending_MPa=ADDITIONAL_BENDING_MPA,
            equivalent_MPa=equivalent,
            factor=factor,
            wanted=LEAST_ACCEPTABILITY,
            met=factor >= LEAST_ACCEPTABILITY,
        )


@record
class FilletRow:
    """One fillet: what the cycle does to it, and how safe it is."""

    throw: Ordinal
    web: Ordinal
    place: Place
    nominal: NominalStress
    factors: Factors
    outside_of_range: Sequence[str]
    cost_of_cuts: Positive
    stress: FilletStress
    fatigue_strength_MPa: Positive
    safety: FilletSafety
    m53: Acceptability
    at_rad: Degrees

    @classmethod
    def of(cls, fillet: Fillet) -> Self:
        fatigue = fillet.fatigue
        swing = fatigue.equivalent_alternating_MPa
        return cls(
            throw=fillet.throw,
            web=fillet.web,
            place=fillet.place,
            nominal=NominalStress.of(fillet),
            factors=Factors(
                bending=fillet.factors.bending,
                shear=fillet.factors.shear,
                torsion=fillet.factors.torsion,
            ),
            outside_of_range=fillet.outside,
            cost_of_cuts=fillet.cost,
            stress=FilletStress(
                bending_mean_MPa=fatigue.bending_mean_MPa,
                bending_alternating_MPa=fatigue.bending_alternating_MPa,
                torsion_mean_MPa=fatigue.torsion_mean_MPa,
                torsion_alternating_MPa=fatigue.torsion_alternating_MPa,
                equivalent_alternating_MPa=swing,
                greatest_MPa=fatigue.greatest_MPa,
            ),
            fatigue_strength_MPa=fillet.fatigue_MPa,
            safety=FilletSafety(
                gough_pollard=fatigue.gough_pollard,
                goodman=fatigue.goodman,
                iacs=fillet.fatigue_MPa / swing if swing else None,
                yielding=fatigue.yielding,
            ),
            m53=Acceptability.of(fillet),
            at_rad=fillet.at_rad,
        )


@record
class OilBoreNominal:
    """Least and greatest nominal stress of a cycle at an oil bore's outlet, as if there were no hole."""

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
    factors: Factors
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
                bending_MPa=_ends(outlet.bending_MPa), torsion_MPa=_ends(outlet.torsion_MPa)
            ),
            factors=Factors(
                bending=outlet.factors.bending, shear=outlet.factors.shear, torsion=outlet.factors.torsion
            ),
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
class LeastSafety:
    """The fillet of the least safety, by Gough and Pollard."""

    throw: Ordinal
    web: Ordinal
    place: Place
    gough_pollard: float
    goodman: float

    @classmethod
    def of(cls, fillets: Sequence[Fillet]) -> Self | None:
        """Return the least of some fillets; None where nothing stresses them."""
        known = [each for each in fillets if each.fatigue.gough_pollard is not None]
        if not known:
            return None
        least = min(known, key=lambda each: each.fatigue.gough_pollard or 0.0)
        assert least.fatigue.gough_pollard is not None
        assert least.fatigue.goodman is not None
        return cls(
            throw=least.throw,
            web=least.web,
            place=least.place,
            gough_pollard=least.fatigue.gough_pollard,
            goodman=least.fatigue.goodman,
        )


@record
class FilletState:
    """All fillets and oil bores of a crank, as it was or is."""

    fillets: Sequence[FilletRow]
    least: LeastSafety | None
    oil_bores: Sequence[OilBoreRow]

    @classmethod
    def of(cls, fillets: Sequence[Fillet], outlets: Sequence[OilBoreOutlet]) -> Self:
        return cls(
            fillets=[FilletRow.of(each) for each in fillets],
            least=LeastSafety.of(fillets),
            oil_bores=[OilBoreRow.of(each) for each in outlets],
        )


@record
class FilletElements:
    """A fillet by finite elements: its factors, over those of the formulas, and how sure they are."""

    web: Ordinal
    place: Place
    bending_factor: Positive
    torsion_factor: Positive
    bending_over_formula: Positive
    torsion_over_formula: Positive
    error: NotNegative
    solid_has_fillet: bool
    cost_of_cuts: Positive | None

    @classmethod
    def of(cls, fillet: FilletByElements, shape: FilletShape, costs: Costs | None) -> Self:
        diameter, bore, factors = shape.pin_mm, shape.pin_bore_mm, shape.crankpin
        if fillet.place == "journal":
            diameter, bore, factors = shape.journal_mm, shape.journal_bore_mm, shape.journal
        bending = fillet.bending_MPa * shape.web_breadth_mm * shape.web_thickness_mm**2 / 6.0 / N_MM_PER_N_M
        torsion = fillet.torsion_MPa * polar_modulus_mm3(diameter, bore) / N_MM_PER_N_M
        return cls(
            web=fillet.web,
            place=fillet.place,
            bending_factor=bending,
            torsion_factor=torsion,
            bending_over_formula=bending / factors.bending,
            torsion_over_formula=torsion / factors.torsion,
            error=fillet.error,
            solid_has_fillet=fillet.is_there,
            cost_of_cuts=None if costs is None else costs[fillet.web, fillet.place],
        )


@record
class ThrowElements:
    """One throw by finite elements; of each cut, its greatest stress, bent, over the fillets' greatest."""

    throw: Ordinal
    nodes: Ordinal
    fillets: Sequence[FilletElements]
    cuts_over_fillets: Sequence[float]

    @classmethod
    def of(cls, throw: int, elements: ThrowByElements, sides: Sequence[Side], costs: Costs | None) -> Self:
        greatest = max(each.bending_MPa for each in elements.fillets)
        inside = [each for each in elements.in_boxes_MPa if each is not None]
        shapes = {side.loads.web: side.shape for side in sides}
        return cls(
            throw=throw,
            nodes=elements.nodes,
            fillets=[FilletElements.of(each, shapes[each.web], costs) for each in elements.fillets],
            cuts_over_fillets=[each / greatest for each in inside],
        )


@record
class TorsionalVibration:
    """Whether torsional vibration is counted, and the greatest torque that it adds in a journal."""

    counted: bool
    greatest_added_N_m: NotNegative | None

    @classmethod
    def of(cls, throws: Sequence[ThrowVibration] | None) -> Self:
        if throws is None:
            return cls(counted=False, greatest_added_N_m=None)
        greatest = max(
            float(np.abs(side).max()) for each in throws for side in (each.before_n_m, each.after_n_m)
        )
        return cls(counted=True, greatest_added_N_m=greatest)


@record
class StrengthReport(Head):
    """Stress and safety of the fillets of crankpins and main journals over the cycle."""

    command: Literal["strength"] = "strength"
    job_set: Sequence[str] | Absent = ABSENT
    input: JobEcho
    report: str | None
    speed_rpm: Positive
    torsional_vibration: TorsionalVibration
    fillets: Sequence[FilletRow]
    least: LeastSafety | None
    oil_bores: Sequence[OilBoreRow]
    before: FilletState | None
    fem: ThrowElements | None
    warnings: Sequence[str]


def _ends(values: Array) -> tuple[float, float]:
    return float(values.min()), float(values.max())
