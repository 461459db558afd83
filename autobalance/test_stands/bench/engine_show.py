"""Crank variants in one engine as lines to read, and as plots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.report import plots
from autobalance.report.plots import Plot
from autobalance.report.tables import table
from autobalance.units import G_MM2_PER_KG_MM2, RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.test_stands.bench.answer import BenchVariant, EngineBenchReport, VariantRunUp
    from autobalance.test_stands.bench.engine_variants import VariantCurves, VariantFigures


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
