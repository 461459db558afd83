"""Results of a cycle as records: cylinders, torque, speed, loads, factors, key figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Self

from autobalance.declare import (
    ABSENT,
    INLINE,
    JOULES,
    NEWTONS,
    Absent,
    Angle,
    Bar,
    Degrees,
    Floats,
    Joules,
    KgMm2,
    NewtonMetres,
    Newtons,
    NotNegative,
    Ordinal,
    Positive,
    Rpm,
    record,
)
from autobalance.engines.cycle.factors import KeyFigures
from autobalance.engines.cycle.load_figures import NumberedLoad, TorqueOrder
from autobalance.engines.cycle.model import Path
from autobalance.running_gear.whole_engine import DeadCentres

if TYPE_CHECKING:
    from autobalance.engines.cycle.cylinder import CylinderCycle


@record
class CylinderFigures:
    """Pressure, work and heat of one cylinder."""

    work_n_mm: Joules
    closed_work_n_mm: Joules
    pumping_work_n_mm: Joules
    imep_mpa: Bar
    peak_pressure_mpa: Bar
    peak_angle_rad: Degrees
    thermal_efficiency: float | None
    swept_cm3: Positive
    peak_temperature_K: float | None
    imep_scatter_mpa: Bar | None
    closed_work_by_cycle_n_mm: Annotated[tuple[float, ...] | None, JOULES]
    wall_heat_n_mm: Joules | None

    @classmethod
    def of(cls, cycle: CylinderCycle) -> Self:
        peak, at = cycle.peak
        work, closed, heat = cycle.work_n_mm, cycle.closed_work_n_mm, cycle.heat_n_mm
        return cls(
            work_n_mm=work,
            closed_work_n_mm=closed,
            pumping_work_n_mm=cycle.pumping_work_n_mm,
            imep_mpa=cycle.mean_pressure_mpa(),
            peak_pressure_mpa=peak,
            peak_angle_rad=at,
            thermal_efficiency=work / heat if heat else None,
            swept_cm3=cycle.chamber.swept_mm3 * 1e-3,
            peak_temperature_K=cycle.peak_temperature_k,
            imep_scatter_mpa=cycle.scatter_mpa(),
            closed_work_by_cycle_n_mm=cycle.closed_work_by_cycle_n_mm,
            wall_heat_n_mm=None if cycle.part is None else cycle.part.wall_heat_n_mm,
        )


@record
class FirstCylinder:
    """The first cylinder: stroke, dead centres, pressure, work and heat."""

    stroke_mm: Positive
    top_dead_centre_deg: Angle
    bottom_dead_centre_deg: Angle
    figures: Annotated[CylinderFigures, INLINE]


@record
class NumberedCylinder:
    """A cylinder with its number, stroke and dead centres."""

    places: Annotated[DeadCentres, INLINE]
    figures: Annotated[CylinderFigures, INLINE]


@record
class CycleTorque:
    """Torque at the shaft over a cycle, and its orders."""

    mean_n_m: NewtonMetres
    greatest_n_m: NewtonMetres
    least_n_m: NewtonMetres
    gas_mean_n_m: NewtonMetres
    inertia_mean_n_m: NewtonMetres
    friction_mean_n_m: NewtonMetres
    orders: Sequence[TorqueOrder]


@record
class RunUpPoint:
    """Time at which the unloaded engine passes a speed."""

    speed_rad_s: Rpm
    time_s: float


@record
class CycleSpeed:
    """Fluctuation of the speed, and the run-up; None where friction holds the engine."""

    mean_rad_s: Rpm | None
    fluctuation: float | None
    greatest_rad_s: Rpm | None
    least_rad_s: Rpm | None
    inertia_mean_g_mm2: KgMm2
    acceleration_rad_s2: float
    flywheel_needed_g_mm2: KgMm2 | None
    run_up: Sequence[RunUpPoint] | None


@record
class CycleLoads:
    """Largest and mean loads of pins and bearings."""

    crankpins: Sequence[NumberedLoad]
    big_ends: Sequence[NumberedLoad]
    wrist_pins: Sequence[NumberedLoad]
    piston_walls: Sequence[NumberedLoad]
    main_journals: Sequence[NumberedLoad]


@record
class FactorLoads:
    """Main-bearing loads and friction of an ideal crank of a balance factor."""

    factor: float
    greatest_main_n: Newtons
    mean_main_n: Newtons
    greatest_mains_n: Annotated[Floats, NEWTONS]
    friction_mean_n_m: NewtonMetres
    least_film_mm: float | Absent | None = ABSENT


@record
class SweepRow:
    """Loads, friction and torque of an ideal crank of a balance factor at a speed."""

    speed_rad_s: Rpm
    factor: float
    greatest_main_n: Newtons
    mean_main_n: Newtons
    friction_mean_n_m: NewtonMetres
    torque_mean_n_m: NewtonMetres
    least_film_mm: float | None


@record
class ThrowCounterweight:
    """The counterweight of a throw that leaves the least reaction to its rods."""

    throw: Ordinal
    unbalance_g_mm: float
    angle_rad: Degrees
    greatest_n: Newtons
    opposite_g_mm: float
    opposite_greatest_n: Newtons
    opposite_factor: float | None


@record
class FactorFigures:
    """Key figures of a balance factor."""

    factor: float
    figures: Annotated[KeyFigures, INLINE]


@record
class ShareFigures:
    """Key figures of a share of what the engine has."""

    share: float
    figures: Annotated[KeyFigures, INLINE]


@record
class KeyFigureTable:
    """Key figures by balance factor, inertia and reciprocating mass."""

    factor: Sequence[FactorFigures]
    inertia: Sequence[ShareFigures]
    reciprocating_mass: Sequence[ShareFigures]


@record
class CycleSummary:
    """Summary of a cycle at its speed."""

    strokes: int
    firing_rad: Sequence[Degrees]
    cylinder: FirstCylinder
    cylinders: Sequence[NumberedCylinder]
    torque: CycleTorque
    power_W: float
    speed: CycleSpeed
    loads: CycleLoads
    factors: Sequence[FactorLoads]
    counterweights: Sequence[ThrowCounterweight]
    key_figures: KeyFigureTable
    energy_error: float | None


@record
class PendulumFigures:
    """A pendulum absorber for a share of the torque of its order; no mass where that is not known."""

    order: Positive
    path: Path
    distance_mm: Positive
    length_mm: Positive
    swing_rad: Degrees
    order_at_swing: float
    torque_n_m: NewtonMetres | None
    reduction: NotNegative
    mass_g: float | None
    inertia_g_mm2: KgMm2 | None
