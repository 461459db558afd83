"""A rotor bench as lines to read, and as plots."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.declare import RPM
from autobalance.report import plots
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.units import G_MM2_PER_KG_MM2, RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.engines.cycle.windage import TorqueRange
    from autobalance.test_stands.bench.answer import (
        BenchComparison,
        BenchReading,
        BenchReport,
        BenchRun,
        BenchVariant,
        BenchWindage,
        EngineBenchReport,
        VariantRunUp,
        WrittenRotor,
    )
    from autobalance.test_stands.bench.engine_input import VariantCurves, VariantFigures
    from autobalance.test_stands.bench.heat import HeatOfBench, HeatRun
    from autobalance.test_stands.bench.speed_control import SpeedTrace


# A rotor bench as lines to read.


def bench_text(report: BenchReport) -> str:
    rotor, loop = report.rotor, report.loop
    margin = math.degrees(loop.phase_margin_rad)
    head = f"Rotor of {rotor.mass_kg:.4f} kg, {rotor.inertia_g_mm2 / G_MM2_PER_KG_MM2:.3f} kg·mm²"
    if rotor.disc_thickness_mm is not None:
        head += (
            f": disc {rotor.disc_thickness_mm:.3f} mm thick, shaft {rotor.shaft_each_side_mm:.3f} mm "
            "on each side"
        )
    if rotor.holes:
        head += f"; {len(rotor.holes)} hole(s) leave {rotor.unbalance_g_mm:.2f} g·mm"
    parts = [
        head,
        f"Speed loop: phase margin {margin:.1f}° at {loop.crossover_rad_s:.3g} rad/s",
        _runs(report.runs) if report.runs else "Nothing was run: there is no [bearing].",
    ]
    if rotor.written:
        parts.insert(1, _written(rotor.written))
    if report.readings:
        parts.append(_readings(report.readings))
    if report.comparison:
        parts.append(_comparison(report.comparison))
    if report.windage is not None:
        parts.append(_windage(report.windage))
    if report.heat is not None:
        parts.append(_heat(report.heat))
    return "\n\n".join(parts)


def _written(solids: Sequence[WrittenRotor]) -> str:
    rows: list[Sequence[str]] = [("Measured on the written files", "mass", "inertia", "off", "unbalance")]
    rows += [
        (
            f"  {each.file}",
            f"{each.mass_kg:.5f} kg",
            f"{each.inertia_g_mm2 / G_MM2_PER_KG_MM2:.3f} kg·mm²",
            f"{each.inertia_difference_percent:+.4f} %",
            f"{each.unbalance_g_mm:.2f} g·mm",
        )
        for each in solids
    ]
    return table(rows)


def _runs(runs: Sequence[BenchRun]) -> str:
    rows: list[Sequence[str]] = [
        (
            "Run",
            "unbalance",
            "friction",
            "in the ramp",
            "mean held",
            "power",
            "maximum",
            "overshoot",
            "error",
        )
    ]
    for run in runs:
        name = f"  {run.speed_rpm:g} rpm" + (f" ({run.repeat})" if run.repeat > 1 else "")
        torques = (run.friction_N_m, run.ramp_torque_N_m, run.mean_torque_N_m)
        rows.append(
            (
                name,
                f"{run.unbalance_force_N:.2f} N",
                *(f"{torque:.4f} N·m" for torque in torques),
                f"{run.power_W:.1f} W",
                f"{run.greatest_torque_N_m:.4f} N·m",
                f"{run.overshoot_rpm:.1f} rpm",
                f"{100.0 * run.speed_error:.4f} %",
            )
        )
    return table(rows)


def _windage(rows: Sequence[BenchWindage]) -> str:
    lines: list[Sequence[str]] = [("Windage, an estimate", "minimum", "maximum", "over the friction")]
    for row in rows:
        low, high = row.least_of_friction, row.greatest_of_friction
        share = "-" if low is None or high is None else f"{100.0 * low:.2g} to {100.0 * high:.2g} %"
        torques = f"{row.least_N_m:.2g} N·m", f"{row.greatest_N_m:.2g} N·m"
        lines.append((f"  {row.speed_rpm:g} rpm", *torques, share))
    return table(lines)


def _heat(heat: HeatOfBench) -> str:
    """Return the course of temperature and torque, the readings beside it, and what they fix."""
    head = f"Heat of the bearings: {heat.capacity_J_K:.4g} J/K, {heat.conductance_W_K:.4g} W/K"
    lines = [f"{head}, time constant {heat.time_constant_s:.4g} s"]
    if heat.friction_factor != 1.0:
        lines.append(f"  friction {heat.friction_factor:.4g} times that of the bearings' model")
    rows: list[Sequence[str]] = [("Stage until", "speed", "temperature", "torque", "drop in it", "if held")]
    for stage in heat.stages:
        steady = "-"
        if stage.steady_C is not None and stage.steady_N_m is not None:
            steady = f"{stage.steady_C:.1f} °C, {stage.steady_N_m:.4f} N·m"
        rows.append(
            (
                f"  {stage.time_s:g} s",
                f"{RPM.written(stage.speed_rad_s):g} rpm",
                f"{stage.temperature_C:.1f} °C",
                f"{stage.torque_N_m:.4f} N·m",
                "-" if stage.drop_percent is None else f"{stage.drop_percent:.1f} %",
                steady,
            )
        )
    lines.append(table(rows))
    if heat.readings:
        rows = [("Reading at", "measured", "model", "temperature")]
        for each in heat.readings:
            torques = f"{each.torque_N_m:.4f} N·m", f"{each.model_N_m:.4f} N·m"
            rows.append((f"  {each.time_s:g} s", *torques, f"{each.temperature_C:.1f} °C"))
        lines.append(table(rows))
    for value in heat.fitted:
        known = value.pm is not None and value.fixed
        lines.append(f"  fitted {value.name} = {value.value:.4g}" + (f" ± {value.pm:.2g}" if known else ""))
    return "\n".join([*lines, *(f"  {line}" for line in heat.not_fixed)])


def _volts(value: float | None) -> str:
    return "" if value is None else f"{value:.4f} V"


def _pm(value: float | None) -> str:
    return "" if value is None else f" ± {value:.4f}"


def _dropped(reading: BenchReading) -> str:
    """Return the numbers of the runs left out, with "(temperature)" after runs dropped for it."""
    cold = reading.dropped_for_temperature
    return ", ".join(f"{run} (temperature)" if run in cold else str(run) for run in reading.dropped)


def _readings(readings: Sequence[BenchReading]) -> str:
    rows: list[Sequence[str]] = [("Reading", "speed", "mean", "zero", "torque", "runs left out")]
    for each in readings:
        rows.append(
            (
                f"  case {each.case}",
                f"{each.speed_rpm:g} rpm",
                _volts(each.mean_V),
                _volts(each.zero_V),
                f"{each.torque_N_m:.4f} N·m{_pm(each.uncertainty_N_m)}",
                _dropped(each),
            )
        )
    return table(rows)


def _comparison(comparison: Sequence[BenchComparison]) -> str:
    rows: list[Sequence[str]] = [("Comparison", "speed", "test", "simulated", "apart")]
    for each in comparison:
        simulated, apart = each.simulated_N_m, each.difference_percent
        rows.append(
            (
                f"  case {each.case}",
                f"{each.speed_rpm:g} rpm",
                f"{each.test_N_m:.4f} N·m{_pm(each.uncertainty_N_m)}",
                "no run" if simulated is None else f"{simulated:.4f} N·m",
                "" if apart is None else f"{apart:.2f} %",
            )
        )
    return table(rows)


# Plots of a rotor bench: speed and torque over time, windage by speed.


def bench_plots(
    report: BenchReport,
    traces: Sequence[SpeedTrace],
    heat: HeatRun | None = None,
    windage_at: Callable[[float], TorqueRange] | None = None,
) -> dict[str, Plot]:
    """Return speed and torque of each run over time, windage, and temperature and torque through a course."""
    others = {} if heat is None else _heat_plots(heat)
    speeds_rpm = report.input["schedule"]["speeds_rpm"]
    if windage_at is not None and speeds_rpm:
        from autobalance.engines.cycle.windage_section import windage_plot

        title, highest = "Windage of disc and shaft", max(speeds_rpm) * RAD_S_PER_RPM
        others["bench-windage"] = windage_plot(title, windage_at, highest)
    if not traces:
        return others
    names = [f"{speed:g} rpm" for speed in speeds_rpm]
    pairs = list(zip(names, traces, strict=True))
    speeds = [plots.Curve(name, trace.time_s, trace.speed / RAD_S_PER_RPM) for name, trace in pairs]
    torques = [plots.Curve(name, trace.time_s, trace.torque_N_m) for name, trace in pairs]
    return {
        "bench-speed": plots.lines("Speed on the bench", ("time [s]", "speed [1/min]"), speeds),
        "bench-torque": plots.lines("Torque on the bench", ("time [s]", "torque [N·m]"), torques),
        **others,
    }


def _heat_plots(heat: HeatRun) -> dict[str, Plot]:
    time = heat.warming.time_s
    torques = [plots.Curve("model", time, heat.torque_N_m)]
    readings = heat.answer.readings
    if readings:
        at, measured = np.array([(each.time_s, each.torque_N_m) for each in readings]).T
        torques.append(plots.Curve("readings", at, measured, measured=True))
    warm = [plots.Curve("bearings", time, heat.warming.celsius)]
    return {
        "heat-temperature": plots.lines(
            "Temperature of the bearings", ("time [s]", "temperature [°C]"), warm
        ),
        "heat-torque": plots.lines("Torque as the bearings warm", ("time [s]", "torque [N·m]"), torques),
    }


# Crank variants in one engine as lines to read.


def engine_bench_text(report: EngineBenchReport) -> str:
    """Return the variants by speed, and their run-up."""
    rows = report.variants
    speeds = [point.speed_rpm for point in rows[0].points]
    blocks = [_at(rows, place, speed) for place, speed in enumerate(speeds)]
    runs = [(each.name, each.run_up) for each in rows if each.run_up is not None]
    if runs:
        blocks.append(_run_up(runs))
    return "\n\n".join(blocks)


def _at(variants: Sequence[BenchVariant], place: int, speed_rpm: float) -> str:
    head = (f"At {speed_rpm:g} rpm", "factor", "inertia", "acceleration", "maximum main", "mean main")
    rows: list[Sequence[str]] = [(*head, "torque", "from", "to", "friction")]
    for each in variants:
        point, factor = each.points[place], each.balance_factor
        rows.append(
            (
                f"  {each.name}",
                "" if factor is None else f"{100.0 * factor:.1f} %",
                f"{each.inertia_g_mm2 / G_MM2_PER_KG_MM2:.5g} kg·mm²",
                f"{point.acceleration_rad_s2:.5g} rad/s²",
                f"{point.greatest_main_n:.5g} N",
                f"{point.mean_main_n:.5g} N",
                f"{point.torque_mean_n_m:.4g} N·m",
                f"{point.torque_least_n_m:.4g}",
                f"{point.torque_greatest_n_m:.4g}",
                f"{point.friction_mean_n_m:.4g} N·m",
            )
        )
    return table(rows)


def _run_up(runs: Sequence[tuple[str, VariantRunUp]]) -> str:
    _, first = runs[0]
    head = f"Run-up, {first.from_rpm:g} to {first.to_rpm:g} rpm without load"
    rows: list[Sequence[str]] = [(head, "time", "turns", "gas", "friction", "gained")]
    for name, run in runs:
        if run.time_s is None:
            rows.append((f"  {name}", "friction keeps it from there"))
            continue
        work = (run.gas_work_J, run.friction_work_J, run.kinetic_J)
        rows.append(
            (
                f"  {name}",
                f"{1e3 * run.time_s:.2f} ms",
                f"{run.turns:.2f}",
                *(f"{value:.5g} J" for value in work),
            )
        )
    return table(rows)


# Plots of crank variants in one engine: torque, bearing loads, acceleration, run-up.


FIGURES: dict[str, tuple[str, Callable[[VariantFigures], float], str]] = {
    "engine-bearing-force": (
        "Largest load of a main bearing",
        lambda point: point.greatest_main_n,
        "load [N]",
    ),
    "engine-acceleration": (
        "Acceleration without load",
        lambda point: point.acceleration_rad_s2,
        "acceleration [rad/s²]",
    ),
    "engine-mean-torque": ("Mean torque at the shaft", lambda point: point.torque_mean_n_m, "torque [N·m]"),
}


def engine_bench_plots(report: EngineBenchReport, curves: Sequence[VariantCurves]) -> dict[str, Plot]:
    """Return the plots by name; plots over the speed only for several speeds."""
    torque = [plots.Curve(each.name, each.angle_deg, each.torque_N_m) for each in curves]
    drawn = {"engine-torque": plots.lines("Output torque", ("crank angle [°]", "torque [N·m]"), torque)}
    if len(report.variants[0].points) > 1:
        for name, (title, figure, axis) in FIGURES.items():
            lines = [
                plots.Curve(
                    each.name,
                    np.array([point.speed_rpm for point in each.points]),
                    np.array([figure(point) for point in each.points]),
                )
                for each in report.variants
            ]
            drawn[name] = plots.lines(title, ("speed [1/min]", axis), lines)
    runs = [
        plots.Curve(each.name, 1e3 * each.run.time_s, each.run.speed_rad_s / RAD_S_PER_RPM)
        for each in curves
        if each.run is not None
    ]
    if runs:
        drawn["engine-run-up"] = plots.lines("Run-up without load", ("time [ms]", "speed [1/min]"), runs)
    return drawn
