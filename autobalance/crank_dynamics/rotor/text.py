"""A beam rotor as lines to read."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autobalance.crank_dynamics.rotor.answer import RotorReport
from autobalance.crank_dynamics.rotor.balancing_procedures import BalancingAdvice
from autobalance.crank_dynamics.rotor.critical_speeds import CriticalSpeed
from autobalance.crank_dynamics.rotor.modal_balancing import AddedUnbalance
from autobalance.crank_dynamics.rotor.run_up import RunUpMotion
from autobalance.crank_dynamics.rotor.unbalance_response import Response, Static
from autobalance.declare import ABSENT, DEGREES, G_MM, HERTZ, MM, RPM, UM
from autobalance.report.tables import table

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
