"""Plots of crank variants in one engine: torque, bearing loads, acceleration, run-up."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.report import plots
from autobalance.report.plot_files import Plot
from autobalance.units import RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.test_stands.bench.answer import EngineBenchReport
    from autobalance.test_stands.bench.engine_variants import VariantCurves, VariantFigures

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
