"""Plots of a beam rotor: Campbell diagram, shapes, response, orbits, stiffness map, run in time."""

from __future__ import annotations

import numpy as np

from autobalance.report.plot_files import Plot
from autobalance.report.plots import Curve, lines
from autobalance.types import Values

Files = dict[str, Plot]
SHAPES = 4
TURN = np.linspace(0.0, 2.0 * np.pi, 73)


def rotor_plots(report: Values) -> Files:
    """Return the plots by name, as far as the report has their values."""
    plots_drawn = {"rotor-shapes": _shapes(report)} if report["modes"] else {}
    if len(report["campbell"]) > 1:
        plots_drawn["rotor-campbell"] = _campbell(report["campbell"])
        if report["response"]:
            plots_drawn["rotor-response"] = _response(
                report["response"], "major_um", "half the major axis [µm]"
            )
            plots_drawn["rotor-phase"] = _response(report["response"], "x_phase_deg", "phase along x [°]")
    if report["response"]:
        plots_drawn["rotor-orbits"] = _orbits(report["response"])
    if report["stiffness_map"]:
        plots_drawn["rotor-stiffness-map"] = _stiffness_map(report["stiffness_map"])
    if report["run_up"]:
        plots_drawn["rotor-run-up"] = _run_up(report["run_up"])
    return plots_drawn


def _campbell(rows: list[Values]) -> Plot:
    speeds = np.array([row["speed_rpm"] for row in rows])
    most = max(len(row["modes"]) for row in rows)
    curves = []
    for at in range(most):
        values = [row["modes"][at]["frequency_hz"] if at < len(row["modes"]) else np.nan for row in rows]
        curves.append(Curve(f"mode {at + 1}", speeds, np.array(values)))
    curves.append(Curve("speed", speeds, speeds / 60.0))
    return lines("Campbell diagram", ("speed [1/min]", "frequency [Hz]"), curves)


def _shapes(report: Values) -> Plot:
    curves = []
    for number, mode in enumerate(report["modes"][:SHAPES], 1):
        z = np.array([each["z_mm"] for each in mode["shape"]])
        for axis in "xy":
            amount = np.array([each[axis] for each in mode["shape"]])
            phase = np.radians([each[f"{axis}_phase_deg"] for each in mode["shape"]])
            lean = phase[int(np.argmax(amount))]
            if amount.max() > 1e-3:
                name = f"{number}{axis}: {mode['frequency_hz']:.1f} Hz"
                curves.append(Curve(name, z, amount * np.cos(phase - lean)))
    return lines("Mode shapes", ("z [mm]", "deflection, greatest 1 [-]"), curves)


def _response(response: list[Values], key: str, label: str) -> Plot:
    curves = [
        Curve(
            f"z {probe['z_mm']:.1f} mm",
            np.array([point["speed_rpm"] for point in probe["points"]]),
            np.array([np.nan if point[key] is None else point[key] for point in probe["points"]]),
        )
        for probe in response
    ]
    return lines("Unbalance response", ("speed [1/min]", label), curves)


def _orbits(response: list[Values]) -> Plot:
    """Return each probe's orbit at the speed at which it is greatest."""
    curves = []
    for probe in response:
        known = [point for point in probe["points"] if point["major_um"] is not None]
        if known:
            point = max(known, key=lambda each: float(each["major_um"]))
            x = point["x_um"] * np.cos(TURN + np.radians(point["x_phase_deg"]))
            y = point["y_um"] * np.cos(TURN + np.radians(point["y_phase_deg"]))
            curves.append(Curve(f"z {probe['z_mm']:.1f} mm, {point['speed_rpm']:.0f} rpm", x, y))
    return lines("Orbits", ("x [µm]", "y [µm]"), curves, equal=True)


def _stiffness_map(rows: list[Values]) -> Plot:
    most = max((len(row["criticals"]) for row in rows), default=0)
    stiffness = np.array([row["k_n_m"] for row in rows])
    curves = []
    for at in range(most):
        values = [row["criticals"][at]["speed_rpm"] if at < len(row["criticals"]) else np.nan for row in rows]
        curves.append(Curve(f"critical {at + 1}", stiffness, np.array(values)))
    labels = ("stiffness of all bearings [N/m]", "critical speed [1/min]")
    return lines("Undamped critical speeds", labels, curves, logarithmic=True)


def _run_up(runs: list[Values]) -> Plot:
    curves = [
        Curve(
            f"z {run['z_mm']:.1f} mm",
            np.array([point["speed_rpm"] for point in run["points"]]),
            np.array([np.hypot(point["x_um"], point["y_um"]) for point in run["points"]]),
        )
        for run in runs
    ]
    return lines("Run in time", ("speed [1/min]", "distance from the axis [µm]"), curves)
