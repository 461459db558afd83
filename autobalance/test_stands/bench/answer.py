"""The two reports of `bench`: a rotor in its bearings, and crank variants in one engine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import KG_MM2, OMITTED, NotNegative, Ordinal, Positive, record
from autobalance.report.records.answers import Head
from autobalance.test_stands.bench.engine_input import VariantFigures
from autobalance.test_stands.bench.heat import HeatOfBench
from autobalance.test_stands.bench.speed_control import LoopMargin


@record
class DrilledHole:
    """A hole in the disc."""

    mass_g: float
    unbalance_g_mm: float


@record
class WrittenRotor:
    """A written solid of the rotor, measured."""

    file: str
    mass_kg: Positive
    inertia_g_mm2: Annotated[Positive, KG_MM2]
    inertia_difference_percent: float
    unbalance_g_mm: NotNegative


@record
class BenchRotor:
    """The rotor on the bench."""

    mass_kg: Positive
    weight_N: Positive
    inertia_g_mm2: Annotated[Positive, KG_MM2]
    disc_thickness_mm: Positive | None
    shaft_each_side_mm: Positive | None
    holes: Sequence[DrilledHole]
    unbalance_g_mm: NotNegative
    written: Sequence[WrittenRotor]


@record
class BenchRun:
    """A simulated run."""

    speed_rpm: NotNegative
    repeat: Ordinal
    unbalance_force_N: NotNegative
    friction_N_m: float
    ramp_inertia_N_m: float
    ramp_torque_N_m: float
    mean_torque_N_m: float
    power_W: float
    greatest_torque_N_m: NotNegative
    overshoot_rpm: NotNegative
    speed_error: NotNegative


@record
class BenchReading:
    """Measured values at a speed."""

    case: int | str
    speed_rpm: NotNegative
    dropped: Sequence[int]
    dropped_for_temperature: Sequence[int]
    mean_V: float | None
    zero_V: float | None
    torque_N_m: float
    scatter_N_m: NotNegative | None
    uncertainty_N_m: NotNegative | None


@record
class BenchComparison:
    """A measured torque beside the simulated one; None if there is no run of that speed."""

    case: int | str
    speed_rpm: Positive
    test_N_m: float
    simulated_N_m: float | None
    difference_percent: NotNegative | None
    uncertainty_N_m: NotNegative | None
    within_uncertainty: bool | None


@record
class BenchWindage:
    """Windage of the disc and its shaft at a speed: an order of size with its range.

    Shares are those of the friction at that speed; null without bearings.
    """

    speed_rpm: NotNegative
    least_N_m: NotNegative
    greatest_N_m: NotNegative
    least_of_friction: NotNegative | None
    greatest_of_friction: NotNegative | None


@record
class BenchReport(Head):
    """A rotor under speed control in its bearings, measured torques beside the simulated ones."""

    command: Literal["bench"] = "bench"
    input: Mapping[str, Any]
    rotor: BenchRotor
    loop: LoopMargin
    runs: Sequence[BenchRun]
    readings: Sequence[BenchReading]
    comparison: Sequence[BenchComparison]
    heat: Annotated[HeatOfBench | None, OMITTED] = None
    windage: Annotated[Sequence[BenchWindage] | None, OMITTED] = None


# --- crank variants in one engine ---------------------------------------------------------------------------


@record
class VariantRunUp:
    """Run-up of a variant without load; None where friction holds it."""

    from_rpm: Positive
    to_rpm: Positive
    time_s: NotNegative | None
    turns: NotNegative | None
    gas_work_J: float | None
    friction_work_J: float | None
    kinetic_J: float | None


@record
class BenchVariant:
    """A variant of the crank in the engine."""

    name: str
    crank: str | None
    factor: float | None
    balance_factor: float | None
    inertia_g_mm2: Annotated[Positive, KG_MM2]
    points: Sequence[VariantFigures]
    run_up: VariantRunUp | None


@record
class BesideFirst:
    """Difference of a variant from the first one at a speed, in percent."""

    name: str
    speed_rpm: Positive
    acceleration_percent: float | None
    greatest_main_percent: float | None
    mean_main_percent: float | None
    torque_mean_percent: float | None
    friction_mean_percent: float | None


@record
class EngineBenchReport(Head):
    """Crank variants side by side in one engine."""

    command: Literal["bench"] = "bench"
    input: Mapping[str, Any]
    variants: Sequence[BenchVariant]
    beside: Sequence[BesideFirst]
    warnings: Sequence[str]
