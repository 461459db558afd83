"""The report of `rotor`, and its text and plots."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, Literal

import numpy as np

from autobalance.crank_dynamics.rotor.balancing import AddedUnbalance, BalancingAdvice
from autobalance.crank_dynamics.rotor.critical_speeds import Criticals, CriticalSpeed, RotorMass, StiffnessRow
from autobalance.crank_dynamics.rotor.from_crank import EquivalentShaft
from autobalance.crank_dynamics.rotor.unbalance_response import OrbitPoint, Response, RunUpMotion, Static
from autobalance.crank_dynamics.rotor.whirl_modes import CampbellRow, ShapedMode
from autobalance.declare import ABSENT, DEGREES, G_MM, HERTZ, INLINE, MM, RPM, UM, Absent, Unit, record
from autobalance.report.plots import Curve, Plot, lines
from autobalance.report.records.answers import Head
from autobalance.report.tables import table

# The report of `rotor`: mm, rpm, Hz, µm and degrees; None where a thing does not apply.


@record
class RotorReport(Head):
    """A shaft on bearings: its critical speeds, modes, response and balancing."""

    command: Literal["rotor"] = "rotor"
    input: Mapping[str, Any]
    mass: Annotated[RotorMass, INLINE]
    criticals: Annotated[Criticals, INLINE]
    modes: Sequence[ShapedMode]
    campbell: Sequence[CampbellRow]
    response: Sequence[Response]
    static: Static
    balancing: Sequence[AddedUnbalance]
    advice: BalancingAdvice
    stiffness_map: Sequence[StiffnessRow]
    run_up: Sequence[RunUpMotion]
    equivalent: EquivalentShaft | Absent = ABSENT
    notes: Sequence[str] | Absent = ABSENT


# A beam rotor as lines to read.


SHOWN_MODES = 12
NO_WHIRL = "none"


def rotor_text(report: RotorReport) -> str:
    parts = [
        _head(report),
        _criticals(report.criticals.criticals),
        _modes(report),
        _response(report.response),
        _sag(report.static),
        _balancing(report.balancing),
        _advice(report.advice),
        _run_up(report.run_up),
        *(() if report.notes is ABSENT else report.notes),
    ]
    return "\n\n".join(part for part in parts if part)


def _head(report: RotorReport) -> str:
    mass = report.mass
    lines = [
        f"Rotor of {mass.mass_kg:.4g} kg, centre of mass at {_z(mass.centre_of_mass_m, 2)},"
        f" {mass.elements} beam elements ({report.input['beam']})"
    ]
    if mass.rigid_body_modes:
        lines.append(
            f"The bearings leave it free: {mass.rigid_body_modes} rigid-body modes, without frequency,"
            " are left out"
        )
    return "\n".join(lines)


def _z(z_m: float, digits: int = 1) -> str:
    return f"z {MM.written(z_m):.{digits}f} mm"


def _criticals(criticals: Sequence[CriticalSpeed]) -> str:
    if not criticals:
        return "No critical speed in the range looked at"
    rows: list[Sequence[str]] = [("Critical speed", "whirl", "log decrement")]
    rows += [
        (f"{RPM.written(each.speed_rad_s):.1f} rpm", each.whirl or NO_WHIRL, f"{each.log_decrement:.5f}")
        for each in criticals
    ]
    return table(rows)


def _modes(report: RotorReport) -> str:
    rows: list[Sequence[str]] = [("Mode", "frequency", "log decrement", "whirl")]
    rows += [
        (
            str(number),
            f"{HERTZ.written(each.figures.frequency_rad_s):.3f} Hz",
            f"{each.figures.log_decrement:.5f}",
            each.figures.whirl or NO_WHIRL,
        )
        for number, each in enumerate(report.modes[:SHOWN_MODES], 1)
    ]
    speed = RPM.written(report.campbell[0].speed_rad_s)
    return f"Modes at {speed:g} rpm\n" + table(rows) if len(rows) > 1 else "No mode that vibrates"


def _response(response: Sequence[Response]) -> str:
    rows: list[Sequence[str]] = [("Unbalance response", "maximum", "at")]
    for probe in response:
        greatest = probe.greatest
        if greatest is not None and greatest.major_m:
            micrometres, rpm = UM.written(greatest.major_m), RPM.written(greatest.speed_rad_s)
            rows.append((_z(probe.z_m), f"{micrometres:.4g} µm", f"{rpm:.0f} rpm"))
    return table(rows) if len(rows) > 1 else ""


def _sag(static: Static) -> str:
    forces = [each for each in static.reactions if each.x_n or each.y_n]
    if not forces:
        return ""
    rows: list[Sequence[str]] = [("Bearing's force on the shaft", "x", "y")]
    rows += [(_z(each.z_m), f"{each.x_n:.3f} N", f"{each.y_n:.3f} N") for each in forces]
    deepest = max((math.hypot(each.x_m, each.y_m) for each in static.deflections), default=0.0)
    return table(rows) + f"\nLargest deflection under gravity {UM.written(deepest):.4g} µm"


def _balancing(planes: Sequence[AddedUnbalance]) -> str:
    if not planes:
        return ""
    rows: list[Sequence[str]] = [("Unbalance to add", "amount", "angle")]
    rows += [
        (_z(each.z_m), f"{G_MM.written(each.kg_m):.3f} g·mm", f"{DEGREES.written(each.angle_rad):.1f}°")
        for each in planes
    ]
    return table(rows)


def _advice(advice: BalancingAdvice) -> str:
    names = ", ".join(f"{each.letter} ({each.name})" for each in advice.procedures)
    head = f"Balancing as a {advice.behaviour} rotor, {advice.reason}"
    return f"{head}: {advice.standard} procedure {names}"


def _run_up(runs: Sequence[RunUpMotion]) -> str:
    if not runs:
        return ""
    rows: list[Sequence[str]] = [("Run in time", "maximum", "at")]
    rows += [
        (_z(each.z_m), f"{UM.written(each.greatest_m):.4g} µm", f"{RPM.written(each.at_rad_s):.0f} rpm")
        for each in runs
    ]
    return table(rows)


# Plots of a beam rotor: Campbell diagram, shapes, response, orbits, stiffness map, run in time.


Files = dict[str, Plot]
SHAPES = 4
TURN = np.linspace(0.0, 2.0 * np.pi, 73)


def rotor_plots(report: RotorReport) -> Files:
    """Return the plots by name, as far as the report has their values."""
    plots_drawn = {"rotor-shapes": _shapes(report.modes)} if report.modes else {}
    if len(report.campbell) > 1:
        plots_drawn["rotor-campbell"] = _campbell(report.campbell)
        if report.response:
            plots_drawn["rotor-response"] = _plot_response(
                report.response, lambda point: _written(UM, point.major_m), "half the major axis [µm]"
            )
            plots_drawn["rotor-phase"] = _plot_response(
                report.response, lambda point: _written(DEGREES, point.x_phase_rad), "phase along x [°]"
            )
    if report.response:
        plots_drawn["rotor-orbits"] = _orbits(report.response)
    if report.stiffness_map:
        plots_drawn["rotor-stiffness-map"] = _stiffness_map(report.stiffness_map)
    if report.run_up:
        plots_drawn["rotor-run-up"] = _plot_run_up(report.run_up)
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


def _plot_response(response: Sequence[Response], value: Callable[[OrbitPoint], float], label: str) -> Plot:
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


def _plot_run_up(runs: Sequence[RunUpMotion]) -> Plot:
    curves = [
        Curve(
            _name(run.z_m),
            np.array([RPM.written(point.speed_rad_s) for point in run.points]),
            np.array([UM.written(np.hypot(point.x_m, point.y_m)) for point in run.points]),
        )
        for run in runs
    ]
    return lines("Run in time", ("speed [1/min]", "distance from the axis [µm]"), curves)
