"""Plots of a rotor bench: speed and torque over time, windage by speed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.report import plots
from autobalance.report.plot_files import Plot
from autobalance.units import RAD_S_PER_RPM

if TYPE_CHECKING:
    from autobalance.engines.cycle.windage import Range
    from autobalance.test_stands.bench.answer import BenchReport
    from autobalance.test_stands.bench.heat import HeatRun
    from autobalance.test_stands.bench.speed_control import Trace


def bench_plots(
    report: BenchReport,
    traces: Sequence[Trace],
    heat: HeatRun | None = None,
    windage_at: Callable[[float], Range] | None = None,
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
