"""``ab.bench``: a rotor under speed control in its bearings, measured torques beside the simulated ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.errors import JobError
from autobalance.report.plots import Plots
from autobalance.runtime import Progress
from autobalance.test_stands.bench.answer import (
    BenchComparison,
    BenchReading,
    BenchReport,
    BenchRotor,
    BenchRun,
    BenchWindage,
    DrilledHole,
    WrittenRotor,
)
from autobalance.units import G_PER_KG, KG_M2_PER_G_MM2, RAD_S_PER_RPM
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from collections.abc import Callable

    from autobalance.engines.cycle.windage import TorqueRange
    from autobalance.test_stands.bench.engine_verb import EngineBenchResult
    from autobalance.test_stands.bench.heat import HeatRun
    from autobalance.test_stands.bench.input import Bench, SpeedReading
    from autobalance.test_stands.bench.speed_control import LoopMargin, SpeedTrace

SAME_SPEED = 1e-9
COVERAGE = 2.0
"""Coverage of what is reported as ±: some 95 %."""
SERIES = ("time_s", "speed_rpm", "wanted_rpm", "torque_N_m", "friction_N_m")


@dataclass(frozen=True, eq=False, repr=False)
class BenchResult(VerbResult):
    """Runs, readings and their comparison; ``traces`` by speed of the schedule, windage by any speed."""

    content: BenchReport
    traces: tuple[SpeedTrace, ...] = ()
    solids: Mapping[str, bytes] = field(default_factory=dict)
    heat: HeatRun | None = None
    windage_at: Callable[[float], TorqueRange] | None = None

    def text(self, units: str = "metric") -> str:
        """Return the bench as lines for people; always SI."""
        from autobalance.test_stands.bench.show import bench_text

        return bench_text(self.content)

    def plots(self) -> Plots:
        """Return speed and torque over time, windage by speed, and the bearings' temperature in a course."""
        from autobalance.test_stands.bench.show import bench_plots

        return Plots(bench_plots(self.content, self.traces, self.heat, self.windage_at))

    def series(self) -> bytes:
        """Return all runs over time as CSV, one after the other; the time runs on."""
        repeats = self.content.input["schedule"]["repeats"]
        lines, start = [",".join(SERIES)], 0.0
        for trace in [each for each in self.traces for _ in range(repeats)]:
            columns = (
                start + trace.time_s,
                trace.speed / RAD_S_PER_RPM,
                trace.wanted / RAD_S_PER_RPM,
                trace.torque_N_m,
                trace.friction_N_m,
            )
            lines += [",".join(map(repr, row)) for row in np.stack(columns, axis=1).tolist()]
            start += float(trace.time_s[-1])
        return ("\n".join(lines) + "\n").encode()

    def files(self) -> Mapping[str, bytes]:
        """Return the runs, a course of temperatures, and the rotor's solids and drawing where requested."""
        runs = {"bench.csv": self.series()} if self.traces else {}
        return {**runs, **({} if self.heat is None else {"heat.csv": self.heat.csv()}), **self.solids}


@documented
def bench(
    bench_file: str | Path | Mapping[str, Any], *, solids: bool = False, progress: Progress | None = None
) -> BenchResult | EngineBenchResult:
    """Simulate a rotor bench and reduce what was measured on it; or put crank variants into an engine.

    Parameters
    ----------
    bench_file : path or dict
        Bench file: rotor, bearings, control, schedule, readings; or an engine and its crank variants. Or the
        file's structure.
    solids : bool
        Make the rotor as STL, STEP (with the extra) and drawing, and measure what was written.

    Returns
    -------
    BenchResult or EngineBenchResult

    Raises
    ------
    JobError
        If a key is wrong, or the speed control is unstable.

    Examples
    --------
    >>> found = bench({"rotor": {"inertia_kg_mm2": 2847.335, "weight_N": 25.01},
    ...     "bearing": {"kind": "dry", "diameter_mm": 20.0, "mu": 0.7773, "small_angle": True},
    ...     "schedule": {"speeds_rpm": [3000.0]}})
    >>> round(found.report["runs"][0]["mean_torque_N_m"], 4)
    0.1944
    """
    from autobalance.test_stands.bench.input import read_bench, refuse_runs_without_bearings
    from autobalance.toml_files.keys import named_in

    raw = bench_file if isinstance(bench_file, Mapping) else _tables(Path(bench_file))
    if "engine" in raw or "variant" in raw:
        from autobalance.test_stands.bench.engine_verb import engine_bench

        return engine_bench(bench_file, *([] if progress is None else [progress]))
    case = read_bench(bench_file)
    with named_in(bench_file):
        refuse_runs_without_bearings(raw)
        return _result(case, solids)


def _tables(path: Path) -> Mapping[str, Any]:
    from autobalance.toml_files.document import text_of, toml_of

    return toml_of(text_of(path, "bench file"), path.name)


def _result(case: Bench, solids: bool) -> BenchResult:
    from autobalance.test_stands.bench.rotor import bench_friction, missing_unbalance_g_mm
    from autobalance.test_stands.bench.speed_control import loop_margin, ramp_and_hold

    inertia = case.polar_g_mm2 * KG_M2_PER_G_MM2
    margin = _stable(loop_margin(case.control, inertia))
    unbalance = missing_unbalance_g_mm(case.holes, case.density_g_mm3)
    traces: list[SpeedTrace] = []
    runs: list[BenchRun] = []
    if case.bearings is not None:
        friction = bench_friction(case.bearings, case.weight_N, unbalance)
        for speed_rpm, speed in zip(case.speeds_rpm, case.speeds_rad_s, strict=True):
            try:
                trace = ramp_and_hold(inertia, friction, case.control, speed, case.ramp_s, case.hold_s)
            except ValueError as error:
                raise JobError(f"control: {error}") from None
            traces.append(trace)
            runs.append(_run(case, speed_rpm, trace, unbalance, friction))
    readings = [_reading(case, each) for each in case.readings]
    heat = None
    if case.heat is not None and case.bearings is not None:
        from autobalance.test_stands.bench.heat import heat_run

        heat = heat_run(case.heat, case.bearings, case.weight_N, unbalance)
    files: Mapping[str, bytes] = {}
    written: Sequence[WrittenRotor] = ()
    if solids and case.shape is not None:
        from autobalance.test_stands.bench.files import rotor_files

        files, written = rotor_files(case.shape, case.holes, case.polar_g_mm2)
    windage_at = _windage_at(case)
    report = BenchReport(
        input=case.values,
        rotor=_rotor(case, unbalance, written),
        loop=margin,
        runs=[replace(run, repeat=repeat) for run in runs for repeat in range(1, case.repeats + 1)],
        readings=readings,
        comparison=_comparison(case, runs, readings),
        heat=None if heat is None else heat.answer,
        windage=_windage(case, runs, windage_at),
    )
    return BenchResult(report, tuple(traces), files, heat, windage_at)


def _windage_at(case: Bench) -> Callable[[float], TorqueRange] | None:
    """Return the windage of disc and shaft by speed [rad/s]; None if it is not asked."""
    if case.air is None or case.shape is None:
        return None
    from autobalance.test_stands.bench.rotor import rotor_windage

    return partial(rotor_windage, case.shape, case.air)


def _windage(
    case: Bench, runs: Sequence[BenchRun], windage_at: Callable[[float], TorqueRange] | None
) -> list[BenchWindage] | None:
    """Return the windage at each speed of the schedule, beside the friction there."""
    if windage_at is None:
        return None
    frictions = [run.friction_N_m for run in runs] or [0.0] * len(case.speeds_rpm)
    rows = []
    for speed_rpm, speed, friction in zip(case.speeds_rpm, case.speeds_rad_s, frictions, strict=True):
        found = windage_at(speed)
        rows.append(
            BenchWindage(
                speed_rpm=speed_rpm,
                least_N_m=found.low_N_m,
                greatest_N_m=found.high_N_m,
                least_of_friction=found.low_N_m / friction if friction > 0.0 else None,
                greatest_of_friction=found.high_N_m / friction if friction > 0.0 else None,
            )
        )
    return rows


def _stable(margin: LoopMargin) -> LoopMargin:
    if margin.stable:
        return margin
    raise JobError(
        "control: the speed loop is unstable, its phase margin is "
        f"{math.degrees(margin.phase_margin_rad):.1f}°; "
        "must be > 0: more kp_N_m_s for ki_N_m, lower gains, or a shorter delay_s"
    )


def _rotor(case: Bench, unbalance_g_mm: float, written: Sequence[WrittenRotor]) -> BenchRotor:
    holes = [(each.mass_g(case.density_g_mm3), each.radius_mm) for each in case.holes]
    return BenchRotor(
        mass_kg=case.mass_g / G_PER_KG,
        weight_N=case.weight_N,
        inertia_g_mm2=case.polar_g_mm2,
        disc_thickness_mm=None if case.shape is None else case.shape.thickness_mm,
        shaft_each_side_mm=None if case.shape is None else case.shape.shaft_each_side_mm,
        holes=[DrilledHole(mass_g=mass, unbalance_g_mm=mass * radius) for mass, radius in holes],
        unbalance_g_mm=unbalance_g_mm,
        written=written,
    )


def _run(
    case: Bench,
    speed_rpm: float,
    trace: SpeedTrace,
    unbalance_g_mm: float,
    friction: Callable[[float], float],
) -> BenchRun:
    from autobalance.test_stands.bench.rotor import unbalance_force_N

    speed = speed_rpm * RAD_S_PER_RPM
    ramp, end = case.ramp_s, case.ramp_s + case.hold_s
    mean = trace.mean_torque_N_m(ramp, end)
    settled = trace.time_s >= ramp + 0.5 * case.hold_s
    return BenchRun(
        speed_rpm=speed_rpm,
        repeat=1,
        unbalance_force_N=unbalance_force_N(unbalance_g_mm, speed),
        friction_N_m=friction(speed),
        ramp_inertia_N_m=case.polar_g_mm2 * KG_M2_PER_G_MM2 * speed / ramp,
        ramp_torque_N_m=trace.mean_torque_N_m(0.5 * ramp, ramp),
        mean_torque_N_m=mean,
        power_W=mean * speed,
        greatest_torque_N_m=float(np.abs(trace.torque_N_m).max()),
        overshoot_rpm=max(0.0, float(trace.speed.max()) - speed) / RAD_S_PER_RPM,
        speed_error=float(np.abs(trace.wanted - trace.speed)[settled].max()) / speed,
    )


def _reading(case: Bench, reading: SpeedReading) -> BenchReading:
    plain = BenchReading(
        case=reading.case,
        speed_rpm=reading.speed_rpm,
        dropped=reading.dropped,
        dropped_for_temperature=reading.cold,
        mean_V=None,
        zero_V=None,
        torque_N_m=0.0 if reading.torque_N_m is None else reading.torque_N_m,
        scatter_N_m=None,
        uncertainty_N_m=None,
    )
    if reading.torque_N_m is not None:
        return plain
    zero, zero_error = _zero(case, reading.case)
    mean, scale = float(np.mean(reading.kept)), case.N_m_per_V
    spread = _spread(reading.kept)
    parts = (
        0.0 if spread is None else spread / math.sqrt(len(reading.kept)) * scale,
        zero_error * scale,
        case.N_m_per_V_pm / math.sqrt(3.0) * (mean - zero),
    )
    known = spread is not None or any(parts)
    return replace(
        plain,
        mean_V=mean,
        zero_V=zero,
        torque_N_m=(mean - zero) * scale,
        scatter_N_m=None if spread is None else spread * scale,
        uncertainty_N_m=COVERAGE * math.hypot(*parts) if known else None,
    )


def _spread(volts: Sequence[float]) -> float | None:
    """Return the standard deviation of runs; None of one alone."""
    return float(np.std(volts, ddof=1)) if len(volts) > 1 else None


def _zero(stand: Bench, case: int | str) -> tuple[float, float]:
    """Return the reading without torque, and its standard uncertainty [V]."""
    allowed = stand.zero_pm_V / math.sqrt(3.0)
    if stand.zero_V is not None:
        return stand.zero_V, allowed
    volts = [v for each in stand.readings if each.case == case and each.speed_rpm == 0.0 for v in each.kept]
    if not volts:
        raise JobError(f'reduction.zero is "rest", but case {case!r} has no volts at speed_rpm = 0')
    scatter = (_spread(volts) or 0.0) / math.sqrt(len(volts))
    return float(np.mean(volts)), math.hypot(allowed, scatter)


def _comparison(
    case: Bench, runs: Sequence[BenchRun], readings: Sequence[BenchReading]
) -> list[BenchComparison]:
    """Set each measured torque beside the simulated one; a run that there is none of is None."""
    comparisons = []
    for reading, values in zip(case.readings, readings, strict=True):
        if reading.speed_rpm == 0.0:
            continue
        simulated = reading.simulated_N_m
        if simulated is None:
            same = [
                run.mean_torque_N_m
                for run in runs
                if math.isclose(run.speed_rpm, reading.speed_rpm, rel_tol=SAME_SPEED)
            ]
            simulated = same[0] if same else None
        test = values.torque_N_m
        least = None if simulated is None else min(test, simulated)
        comparisons.append(
            BenchComparison(
                case=reading.case,
                speed_rpm=reading.speed_rpm,
                test_N_m=test,
                simulated_N_m=simulated,
                difference_percent=100.0 * abs(test - simulated) / least
                if simulated is not None and least is not None and least > 0.0
                else None,
                uncertainty_N_m=values.uncertainty_N_m,
                within_uncertainty=None
                if simulated is None or values.uncertainty_N_m is None
                else abs(test - simulated) <= values.uncertainty_N_m,
            )
        )
    return comparisons
