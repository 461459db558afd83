"""The report of `torsion`: kg·mm², Hz, mrad, N·m, MPa; None where a thing does not apply."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np

from autobalance.declare import (
    ABSENT,
    MRAD,
    Absent,
    Count,
    Floats,
    Hertz,
    Mpa,
    Mrad,
    NotNegative,
    Ordinal,
    Positive,
    Rpm,
    record,
)
from autobalance.dynamics.torsion_chain import HolzerRow, TorsionMode
from autobalance.job.model.torsion import Formula, PendulumAbsorber
from autobalance.machine_models.throw_twist import ThrowTwist
from autobalance.machine_models.torsion_dampers import FittedDamper
from autobalance.machine_models.torsion_excited import ExcitedTrain
from autobalance.machine_models.torsion_from_job import CrankChain
from autobalance.machine_models.torsion_peaks import Peak
from autobalance.machine_models.torsion_strains import CriticalOrder, OrderResponse
from autobalance.machine_models.torsion_trains import NamedTrain
from autobalance.report.records.head import Head
from autobalance.types import Array

KG_MM2_PER_KG_M2 = 1e6
MM_PER_M = 1e3

Stations = Annotated[Sequence[Ordinal], "from 1"]


@record
class Gears:
    """A pair of gears between two stations."""

    stations: Stations
    ratio: float
    mesh_N_m_rad: Positive | None


@record
class CouplingFigures:
    """The mean torque of a coupling, and its stiffness there."""

    station: Ordinal
    mean_N_m: float
    N_m_rad: Positive


@record
class TrainFigures:
    """Inertias and springs, as they are and referred to station 1; formulas are those of a crank's throws."""

    stations: Sequence[str]
    inertias_kg_mm2: Floats
    stiffness_N_m_rad: Floats
    ker_wilson_N_m_rad: Floats | None
    carter_N_m_rad: Floats | None
    fem_N_m_rad: Floats | None
    links: Sequence[Stations]
    ratios: Floats
    referred_inertias_kg_mm2: Floats
    referred_stiffness_N_m_rad: Floats
    gears: Sequence[Gears]
    couplings: Sequence[CouplingFigures]

    @classmethod
    def of(cls, named: NamedTrain, chain: CrankChain | None, metal_n_m_rad: Array | None) -> Self:
        """Return the figures of a train; ``chain`` is the crank in it, whose own metal has these springs."""
        train = named.train
        return cls(
            stations=named.names,
            inertias_kg_mm2=KG_MM2_PER_KG_M2 * train.inertias_kg_m2,
            stiffness_N_m_rad=train.springs_n_m_rad,
            ker_wilson_N_m_rad=None if chain is None else chain.ker_wilson_n_m_rad,
            carter_N_m_rad=None if chain is None else chain.carter_n_m_rad,
            fem_N_m_rad=metal_n_m_rad,
            links=[[int(a) + 1, int(b) + 1] for a, b in train.links],
            ratios=train.ratios,
            referred_inertias_kg_mm2=KG_MM2_PER_KG_M2 * train.referred_inertias_kg_m2,
            referred_stiffness_N_m_rad=train.referred_springs_n_m_rad,
            gears=[
                Gears(stations=[g.first + 1, g.second + 1], ratio=g.ratio, mesh_N_m_rad=g.mesh_n_m_rad)
                for g in train.gears
            ],
            couplings=[
                CouplingFigures(station=each.station + 1, mean_N_m=each.mean_n_m, N_m_rad=each.n_m_rad)
                for each in named.couplings
            ],
        )


@record
class Damping:
    """Damping ratio of every mode, and whether the file gives dampers."""

    ratio: NotNegative
    dampers: bool


@record
class HolzerFigures:
    """A row of Holzer's table; None for what grew over all numbers, behind a spring of no stiffness."""

    inertia_kg_mm2: NotNegative
    angle_rad: float | None
    inertia_torque_N_m: float | None
    torque_N_m: float | None
    twist_rad: float | None

    @classmethod
    def of(cls, row: HolzerRow) -> Self:
        return cls(
            inertia_kg_mm2=KG_MM2_PER_KG_M2 * row.inertia_kg_m2,
            angle_rad=_finite(row.angle_rad),
            inertia_torque_N_m=_finite(row.inertia_torque_n_m),
            torque_N_m=_finite(row.torque_n_m),
            twist_rad=_finite(row.twist_rad),
        )


@record
class TorsionModeFigures:
    """A mode, with Holzer's table where the stations are a chain that hangs together."""

    frequency_rad_s: Hertz
    name: Sequence[str]
    shape: Floats
    twist_mrad: Annotated[Floats, "along each link for 1 mrad where the amplitude is greatest"]
    nodes: Count
    holzer: Sequence[HolzerFigures] | None

    @classmethod
    def of(cls, model: ExcitedTrain, mode: TorsionMode) -> Self:
        rows = model.holzer(mode)
        return cls(
            frequency_rad_s=mode.frequency_rad_s,
            name=model.named.names,
            shape=mode.shape,
            twist_mrad=model.named.train.twists(mode.shape),
            nodes=mode.nodes,
            holzer=None if rows is None else [HolzerFigures.of(row) for row in rows],
        )


@record
class CriticalFigures:
    """A speed at which an order meets a mode."""

    order: Positive
    frequency_rad_s: Hertz
    speed_rad_s: Rpm
    mode: Ordinal
    torque_N_m: NotNegative | None
    stress_pa: Mpa | None
    phase_sum: NotNegative | None

    @classmethod
    def of(cls, critical: CriticalOrder) -> Self:
        return cls(
            order=critical.order,
            frequency_rad_s=critical.frequency_rad_s,
            speed_rad_s=critical.speed_rad_s,
            mode=critical.mode + 1,
            torque_N_m=critical.torque_n_m,
            stress_pa=critical.stress_pa,
            phase_sum=critical.phase_sum,
        )


@record
class OrderPeak:
    """The greatest torque of one order in the range of speeds, along any shaft, found between points too."""

    order: Positive
    speed_rad_s: Rpm
    torque_N_m: NotNegative

    @classmethod
    def of(cls, peak: Peak) -> Self:
        return cls(order=float(peak.order), speed_rad_s=peak.speed_rad_s, torque_N_m=peak.torque_n_m)


@record
class ResponsePoint:
    """Amplitudes of stations, torque, twist and stress of links at a speed; None: not steady."""

    speed_rad_s: Rpm
    angle_rad: Sequence[Mrad | None]
    torque_N_m: Sequence[NotNegative | None]
    twist_rad: Sequence[Mrad | None]
    stress_pa: Sequence[Mpa | None]


@record
class OrderFigures:
    """The response to an order over the speeds."""

    order: Positive
    points: Sequence[ResponsePoint]

    @classmethod
    def of(cls, motion: OrderResponse) -> Self:
        rows = zip(
            motion.speeds_rad_s, motion.angles_rad, motion.torques_n_m, motion.twists_rad, motion.stresses_pa,
            strict=True,
        )  # fmt: skip
        return cls(
            order=float(motion.order),
            points=[
                ResponsePoint(
                    speed_rad_s=speed,
                    angle_rad=_finite_or_none(angles),
                    torque_N_m=_finite_or_none(torques),
                    twist_rad=_finite_or_none(twists),
                    stress_pa=stresses,
                )
                for speed, angles, torques, twists, stresses in rows
            ],
        )


@record
class PendulumFigures:
    """An absorber's length and inertia."""

    length_mm: Positive
    inertia_kg_mm2: Positive

    @classmethod
    def of(cls, absorber: PendulumAbsorber) -> Self:
        return cls(
            length_mm=MM_PER_M * absorber.length_m, inertia_kg_mm2=KG_MM2_PER_KG_M2 * absorber.inertia_kg_m2
        )


@record
class DamperRuleFigures:
    """A damper's mass ratio by the rule for one inertia on one spring."""

    mass_ratio: Positive
    mode_rad_s: Hertz
    frequency_ratio: float | None
    damping_ratio: NotNegative
    peak: NotNegative
    N_m_rad: Positive | None
    N_m_s_rad: NotNegative


@record
class DamperHeat:
    """The heat of a damper at a speed."""

    speed_rad_s: Rpm
    heat_W: NotNegative | None


@record
class ShaftStrain:
    """Greatest strain of the crank's own shafts in the range: torque, stress and twist at its speed."""

    order: Positive
    speed_rad_s: Rpm
    torque_N_m: NotNegative
    stress_pa: Mpa | None
    twist_rad: Mrad

    @classmethod
    def of(cls, peak: Peak) -> Self:
        return cls(
            order=float(peak.order),
            speed_rad_s=peak.speed_rad_s,
            torque_N_m=peak.torque_n_m,
            stress_pa=peak.stress_pa,
            twist_rad=peak.twist_rad,
        )


@record
class DamperFigures:
    """A damper as fitted, the rule beside it, and its heat.

    Twist, torque and stress are those of the crank's own shafts, of a chain's file those of all shafts but
    couplings. With and without the damper every mode has the same ``modal_damping_ratio``; a train without
    any other damping has no limit without it (None).
    """

    station: Ordinal
    kind: str
    inertia_kg_mm2: Positive
    tuned: bool
    search_ended_at: Annotated[str | None, "the bound of its search that the tuning ended at"]
    N_m_rad: Positive | None
    N_m_s_rad: NotNegative | None
    modal_damping_ratio: NotNegative
    greatest_twist_rad: Mrad | None
    greatest_twist_without_mrad: NotNegative | None
    greatest: ShaftStrain | None
    greatest_without: ShaftStrain | None
    rule: DamperRuleFigures
    heat_W: Sequence[DamperHeat]

    @classmethod
    def of(cls, fitted: FittedDamper, speeds_rad_s: Array, heats_w: Array) -> Self:
        """Return the figures of a damper, with its heat at speeds (k,)."""
        damper, rule = fitted.damper, fitted.rule
        inertia, frequency = damper.inertia_kg_m2, fitted.frequency_rad_s
        without, with_it = fitted.without, fitted.with_
        return cls(
            station=damper.station + 1,
            kind=damper.kind,
            inertia_kg_mm2=KG_MM2_PER_KG_M2 * inertia,
            tuned=fitted.tuned,
            search_ended_at=fitted.bound,
            N_m_rad=damper.n_m_rad,
            N_m_s_rad=damper.n_m_s_rad,
            modal_damping_ratio=fitted.modal_ratio,
            greatest_twist_rad=None if with_it is None else with_it.twist_rad,
            greatest_twist_without_mrad=None if without is None else MRAD.written(without.twist_rad),
            greatest=None if with_it is None else ShaftStrain.of(with_it),
            greatest_without=None if without is None else ShaftStrain.of(without),
            rule=DamperRuleFigures(
                mass_ratio=rule.mass_ratio,
                mode_rad_s=frequency,
                frequency_ratio=rule.frequency_ratio or None,
                damping_ratio=rule.damping_ratio,
                peak=rule.peak,
                N_m_rad=rule.n_m_rad(inertia, frequency) or None,
                N_m_s_rad=rule.n_m_s_rad(inertia, frequency),
            ),
            heat_W=[
                DamperHeat(speed_rad_s=speed, heat_W=_finite(float(heat)))
                for speed, heat in zip(speeds_rad_s, heats_w, strict=True)
            ],
        )


@record
class ThrowFigures:
    """The dimensions that the stiffness of a throw was computed from, and what came of them."""

    number: Ordinal
    journal_mm: Positive
    journal_bore_mm: NotNegative
    journal_length_mm: NotNegative
    crankpin_mm: Positive
    crankpin_bore_mm: NotNegative
    crankpin_length_mm: NotNegative
    crank_radius_mm: Positive
    web_thickness_mm: Positive
    web_breadth_mm: Positive
    formula: Formula
    ker_wilson_N_m_rad: Positive
    carter_N_m_rad: Positive
    fem_N_m_rad: Positive | None
    fem_error_N_m_rad: NotNegative | None
    fem_levels_N_m_rad: Floats | None
    fem_nodes: Count | None
    fem_note: Annotated[str | None, "why its own metal gives no stiffness"]

    @classmethod
    def of(cls, number: int, chain: CrankChain, formula: Formula, twist: ThrowTwist | None) -> Self:
        """Return the figures of a throw, numbered from 1."""
        shape = chain.shapes[number - 1]
        metal = None if twist is None else twist.stiffness
        return cls(
            number=number,
            journal_mm=shape.journal_mm,
            journal_bore_mm=shape.journal_bore_mm,
            journal_length_mm=shape.journal_length_mm,
            crankpin_mm=shape.pin_mm,
            crankpin_bore_mm=shape.pin_bore_mm,
            crankpin_length_mm=shape.pin_length_mm,
            crank_radius_mm=shape.crank_radius_mm,
            web_thickness_mm=shape.web_thickness_mm,
            web_breadth_mm=shape.web_breadth_mm,
            formula=formula,
            ker_wilson_N_m_rad=chain.throws_n_m_rad["ker_wilson"][number - 1],
            carter_N_m_rad=chain.throws_n_m_rad["carter"][number - 1],
            fem_N_m_rad=None if metal is None else metal.n_m_rad,
            fem_error_N_m_rad=None if metal is None else metal.error_n_m_rad,
            fem_levels_N_m_rad=None if metal is None else metal.levels_n_m_rad,
            fem_nodes=None if metal is None else metal.nodes,
            fem_note=None if twist is None else twist.reason,
        )


@record
class TorsionReport(Head):
    """Torsional vibration of a crank, or of a chain."""

    command: Literal["torsion"] = "torsion"
    job_set: Sequence[str] | Absent = ABSENT
    input: Annotated[Mapping[str, Any], "job or chain, defaults filled in"]
    model: TrainFigures
    damping: Damping
    excited: bool
    natural_frequencies_rad_s: Sequence[Hertz]
    modes: Sequence[TorsionModeFigures]
    critical: Sequence[CriticalFigures]
    peaks: Sequence[OrderPeak]
    response: Sequence[OrderFigures]
    pendulum: PendulumFigures | None
    dampers: Sequence[DamperFigures]
    fem_natural_frequencies_rad_s: Sequence[Hertz] | Absent | None = ABSENT
    throws: Annotated[Sequence[ThrowFigures], "of a job's crank"] | Absent = ABSENT
    warnings: Sequence[str] | Absent = ABSENT


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _finite_or_none(values: Array) -> list[float | None]:
    return [float(each) if np.isfinite(each) else None for each in values]
