"""Plots of a beam rotor: Campbell diagram, shapes, response, orbits, stiffness map, run in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from autobalance.crank_dynamics.rotor.answer import RotorReport
from autobalance.crank_dynamics.rotor.run_up import RunUpMotion
from autobalance.crank_dynamics.rotor.stiffness_map import StiffnessRow
from autobalance.crank_dynamics.rotor.unbalance_response import OrbitPoint, Response
from autobalance.crank_dynamics.rotor.whirl_modes import CampbellRow, ShapedMode
from autobalance.declare import DEGREES, HERTZ, MM, RPM, UM, Unit
from autobalance.report.plot_files import Plot
from autobalance.report.plots import Curve, lines

Files = dict[str, Plot]
SHAPES = 4
TURN = np.linspace(0.0, 2.0 * np.pi, 73)


def rotor_plots(report: RotorReport) -> Files:
    """Return the plots by name, as far as the report has their values."""
    plots_drawn = {"rotor-shapes": _shapes(report.modes)} if report.modes else {}
    if len(report.campbell) > 1:
        plots_drawn["rotor-campbell"] = _campbell(report.campbell)
        if report.response:
            plots_drawn["rotor-response"] = _response(
                report.response, lambda point: _written(UM, point.major_m), "half the major axis [µm]"
            )
            plots_drawn["rotor-phase"] = _response(
                report.response, lambda point: _written(DEGREES, point.x_phase_rad), "phase along x [°]"
            )
    if report.response:
        plots_drawn["rotor-orbits"] = _orbits(report.response)
    if report.stiffness_map:
        plots_drawn["rotor-stiffness-map"] = _stiffness_map(report.stiffness_map)
    if report.run_up:
        plots_drawn["rotor-run-up"] = _run_up(report.run_up)
    return plots_drawn


def _written(unit: Unit, value: float | None) -> float:
    return np.nan if value is None else unit.written(value)


def _name(z_m: float) -> str:
    return f"z {MM.written(z_m):.1f} mm"


def _campbell(rows: Sequence[CampbellRow]) -> Plot:
    speeds = np.array([RPM.written(row.speed_rad_s) for row in rows])
    most = max(len(row.modes) for row in rows)
    curves = []
    for at in range(most):
        values = [
            HERTZ.written(row.modes[at].frequency_rad_s) if at < len(row.modes) else np.nan for row in rows
        ]
        curves.append(Curve(f"mode {at + 1}", speeds, np.array(values)))
    curves.append(Curve("speed", speeds, speeds / 60.0))
    return lines("Campbell diagram", ("speed [1/min]", "frequency [Hz]"), curves)


def _shapes(modes: Sequence[ShapedMode]) -> Plot:
    curves = []
    for number, mode in enumerate(modes[:SHAPES], 1):
        z = np.array([MM.written(each.z_m) for each in mode.shape])
        in_x = np.array([(each.x, each.x_phase_rad) for each in mode.shape]).T
        in_y = np.array([(each.y, each.y_phase_rad) for each in mode.shape]).T
        for axis, (amount, phase) in (("x", in_x), ("y", in_y)):
            lean = phase[int(np.argmax(amount))]
            if amount.max() > 1e-3:
                name = f"{number}{axis}: {HERTZ.written(mode.figures.frequency_rad_s):.1f} Hz"
                curves.append(Curve(name, z, amount * np.cos(phase - lean)))
    return lines("Mode shapes", ("z [mm]", "deflection, maximum 1 [-]"), curves)


def _response(response: Sequence[Response], value: Callable[[OrbitPoint], float], label: str) -> Plot:
    curves = [
        Curve(
            _name(probe.z_m),
            np.array([RPM.written(point.speed_rad_s) for point in probe.points]),
            np.array([value(point) for point in probe.points]),
        )
        for probe in response
    ]
    return lines("Unbalance response", ("speed [1/min]", label), curves)


def _orbits(response: Sequence[Response]) -> Plot:
    """Return each probe's orbit at the speed at which it is largest."""
    curves = []
    for probe in response:
        point = probe.greatest
        if point is not None:
            x = _written(UM, point.x_m) * np.cos(TURN + (point.x_phase_rad or 0.0))
            y = _written(UM, point.y_m) * np.cos(TURN + (point.y_phase_rad or 0.0))
            curves.append(Curve(f"{_name(probe.z_m)}, {RPM.written(point.speed_rad_s):.0f} rpm", x, y))
    return lines("Orbits", ("x [µm]", "y [µm]"), curves, equal=True)


def _stiffness_map(rows: Sequence[StiffnessRow]) -> Plot:
    speeds = [row.criticals.critical_speeds_rad_s for row in rows]
    stiffness = np.array([row.k_n_m for row in rows])
    curves = []
    for at in range(max(map(len, speeds))):
        values = [RPM.written(row[at]) if at < len(row) else np.nan for row in speeds]
        curves.append(Curve(f"critical {at + 1}", stiffness, np.array(values)))
    labels = ("stiffness of all bearings [N/m]", "critical speed [1/min]")
    return lines("Undamped critical speeds", labels, curves, logarithmic=True)


def _run_up(runs: Sequence[RunUpMotion]) -> Plot:
    curves = [
        Curve(
            _name(run.z_m),
            np.array([RPM.written(point.speed_rad_s) for point in run.points]),
            np.array([UM.written(np.hypot(point.x_m, point.y_m)) for point in run.points]),
        )
        for run in runs
    ]
    return lines("Run in time", ("speed [1/min]", "distance from the axis [µm]"), curves)
