"""Plots of a torsional chain: mode shapes, torques over the speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.crank_dynamics.torsion.answer import TorsionReport
from autobalance.crank_dynamics.torsion.dampers import DamperFigures
from autobalance.crank_dynamics.torsion.figures import Damping
from autobalance.crank_dynamics.torsion.run_up import RunUpFigures
from autobalance.crank_dynamics.torsion.strains import OrderResponse
from autobalance.declare import HERTZ, RPM
from autobalance.report.plot_files import Plot
from autobalance.report.plots import Curve, drawn, lines, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DRAWN_MODES = 5
MIN_UPRIGHT_STATIONS = 12
"""Fewest stations with upright names."""
MAX_MARKED_SPEEDS = 30
"""Most critical speeds drawn, the largest torque first."""


def torsion_plots(report: TorsionReport) -> dict[str, Plot]:
    """Return the plots by name, as far as the report has their values."""
    plots_drawn = {}
    if report.modes:
        plots_drawn["torsion-modes"] = _modes(report)
    if report.response:
        plots_drawn["torsion-torque"] = _torques(report.response, report.damping)
    if any(each.heat_W for each in report.dampers) and len(report.dampers[0].heat_W) > 1:
        plots_drawn["torsion-damper-heat"] = _heat(report.dampers)
    if report.critical:
        plots_drawn["torsion-critical"] = _critical_map(report)
    if report.run_up is not None:
        plots_drawn["torsion-run-up"] = _run_up(report.run_up)
    return plots_drawn


def _run_up(found: RunUpFigures) -> Plot:
    """Return torque over the speed through the run-up and steady, of the shaft with the largest torque."""
    worst = max(range(len(found.shafts)), key=lambda link: found.shafts[link].greatest_torque_n_m)
    speeds = np.array([RPM.written(each.speed_rad_s) for each in found.points])
    passed = np.array([each.torque_n_m[worst] for each in found.points], dtype=np.float64)
    steady = np.array([each.steady_torque_n_m[worst] for each in found.points], dtype=np.float64)
    curves = [Curve(f"run-up, {found.rate_rpm_s:g} rpm/s", speeds, passed), Curve("steady", speeds, steady)]
    title = f"Run-up: shaft {found.shafts[worst].between}"
    return lines(title, ("speed [1/min]", "maximum torque [N·m]"), curves)


def _modes(report: TorsionReport) -> Plot:
    """Return mode shapes by the names of their stations, a line along each shaft; gears end a line."""
    names = report.model.stations
    joined = {(low, high) for low, high in report.model.links}
    ends = [number for number in range(1, len(names)) if (number, number + 1) not in joined]

    def draw(axes: Axes) -> None:
        for number, mode in enumerate(report.modes[:DRAWN_MODES]):
            places = np.insert(np.arange(1.0, len(names) + 1.0), ends, np.nan)
            shape = np.insert(np.array(mode.shape, dtype=float), ends, np.nan)
            axes.plot(
                places,
                shape,
                label=f"{HERTZ.written(mode.frequency_rad_s):.1f} Hz",
                marker=".",
                **style(number),
            )
        axes.axhline(0.0, color="0.4", linewidth=0.8)
        for each in ends:
            axes.axvline(each + 0.5, color="0.6", linewidth=0.8, linestyle=":")
        axes.set_xticks(
            range(1, len(names) + 1), names, rotation=30 if len(names) < MIN_UPRIGHT_STATIONS else 90
        )
        axes.set_xlabel("station")

    return drawn("Torsional modes", "angle, maximum 1 [-]", draw)


def _heat(dampers: Sequence[DamperFigures]) -> Plot:
    curves = []
    for number, each in enumerate(dampers, 1):
        speeds = np.array([RPM.written(one.speed_rad_s) for one in each.heat_W])
        heat = np.array([np.nan if one.heat_W is None else one.heat_W for one in each.heat_W])
        curves.append(Curve(f"damper {number}, {each.kind}", speeds, heat))
    return lines("Heat of the dampers", ("speed [1/min]", "heat [W]"), curves)


def _critical_map(report: TorsionReport) -> Plot:
    """Return natural frequencies over the speed with the orders' rays; a dot's area grows with the torque."""
    critical = report.critical
    low, high = (float(each) for each in report.input["speed_rpm"])
    most = max((each.torque_n_m or 0.0 for each in critical), default=0.0)
    shown = sorted(critical, key=lambda each: -(each.torque_n_m or 0.0))[:MAX_MARKED_SPEEDS]
    orders = sorted({each.order for each in shown})
    frequencies = sorted({HERTZ.written(each.frequency_rad_s) for each in critical})
    top = 1.15 * max(frequencies)

    def draw(axes: Axes) -> None:
        for frequency in frequencies:
            axes.plot([low, high], [frequency] * 2, color="black", linewidth=1.4)
        for order in orders:
            end = min(high, 60.0 * 0.97 * top / order)
            axes.plot([low, end], [order * low / 60.0, order * end / 60.0], color="0.6", linewidth=0.8)
            axes.annotate(f" {order:g}", (end, order * end / 60.0), fontsize="small", color="0.35")
        for each in shown:
            share = (each.torque_n_m or 0.0) / most if most else 0.0
            speed, frequency = RPM.written(each.speed_rad_s), HERTZ.written(each.frequency_rad_s)
            axes.scatter(speed, frequency, s=12.0 + 160.0 * share, color="#d55e00")
        axes.set_xlim(low, high + 0.05 * (high - low))
        axes.set_ylim(0.0, top)
        axes.set_xlabel("speed [1/min]")

    area = "; dots grow with the torque" if most else ""
    return drawn(f"Critical speeds by order{area}", "natural frequency [Hz]", draw)


def _torques(response: Sequence[OrderResponse], damping: Damping) -> Plot:
    """Return the largest torque along the chain over the speed, for the strongest orders."""
    curves = []
    for each in response:
        speeds = np.array([RPM.written(point.speed_rad_s) for point in each.points])
        torques = [max((t for t in point.torque_n_m if t is not None), default=0.0) for point in each.points]
        curves.append(Curve(f"order {each.order:g}", speeds, np.array(torques)))
    curves.sort(key=lambda curve: -float(curve.y.max()))
    labels = ("speed [1/min]", "maximum torque [N·m]")
    title = "Torsional response, undamped: peaks have no limit" if damping.is_none else "Torsional response"
    return lines(title, labels, curves[:DRAWN_MODES])
