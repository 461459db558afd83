"""A balancing machine's reading as lines to read, and as points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from autobalance.report import plots
from autobalance.report.display_units import DisplayUnits
from autobalance.report.plots import Plot
from autobalance.report.tables import table

if TYPE_CHECKING:
    from autobalance.test_stands.machine.answer import MachineReport, PlaneSpread, SensorReading
    from autobalance.test_stands.machine.balancing_machine import StaticStand


# A balancing machine's reading as lines to read.


KINDS = {
    "hard": "hard-bearing machine (forces)",
    "soft": "soft-bearing machine (displacements)",
    "cradle": "pivoted cradle (moments)",
    "nodal": "nodal-point machine (displacements)",
    "static": "static stand",
}
UNBALANCE_KINDS = {
    "balanced": "balanced",
    "static": "static unbalance",
    "couple": "couple unbalance",
    "quasi_static": "quasi-static unbalance",
    "dynamic": "dynamic unbalance",
}


def machine_text(report: MachineReport, units: DisplayUnits) -> str:
    """Return rotor, sensors, nodes, static stand, and the reading with its corrections."""
    rotor, settings = report.rotor, report.input
    speed = "" if settings["speed_rpm"] is None else f" at {settings['speed_rpm']:g} rpm"
    tilt = rotor.principal_axis_rad
    parts = [
        f"{KINDS[settings['kind']]}{speed}: {units.of_mass(rotor.mass_g)}, centre of mass at z "
        f"{units.of_length(rotor.centre_of_mass_mm[2])}, {UNBALANCE_KINDS[rotor.kind]} of "
        f"{units.of_unbalance(rotor.magnitude_g_mm)}"
        + ("" if tilt is None else f", principal axis tilted by {math.degrees(tilt):.4f}°"),
    ]
    if report.sensors:
        parts.append(_sensors(report.sensors, units))
    if report.nodes:
        nodes = (f"of plane {each.plane} at z {units.of_length(each.z_mm)}" for each in report.nodes)
        parts.append(f"Nodes: {', '.join(nodes)}")
    if report.static is not None:
        parts.append(_static(report.static, units))
    parts.append(_reading(report, units))
    return "\n\n".join(parts)


def _sensors(sensors: Sequence[SensorReading], units: DisplayUnits) -> str:
    rows: list[Sequence[str]] = [("Sensor", "z", "amplitude", "angle")]
    for each in sensors:
        sizes = ((each.force_N, "N"), (each.displacement_um, "µm"), (each.moment_N_m, "N·m"))
        amplitude = next(f"{size:.4g} {unit}" for size, unit in sizes if size is not None)
        rows.append(
            (
                f"  {each.name}",
                units.of_length(each.z_mm),
                amplitude,
                f"{each.angle_deg:.2f}°",
            )
        )
    return table(rows)


def _static(static: StaticStand, units: DisplayUnits) -> str:
    least = units.of_unbalance(static.least_g_mm)
    if not static.rolls or static.rest_within_rad is None:
        return f"The rotor does not roll; it would from {least}"
    time = "" if static.roll_time_s is None else f", heavy side down after {static.roll_time_s:.3f} s"
    return (
        f"The rotor rolls (from {least}) and rests within ±{math.degrees(static.rest_within_rad):.2f}°{time}"
    )


def _reading(report: MachineReport, units: DisplayUnits) -> str:
    rows: list[Sequence[str]] = [("Plane", "true", "read", "take off at", "depth", "left")]
    first = report.runs[0]
    true = {plane.name: plane.g_mm for plane in report.rotor.planes}
    for plane, left, correction in zip(first.planes, first.left.planes, report.corrections, strict=True):
        depth = correction.depth_mm
        rows.append(
            (
                f"  {plane.name}",
                units.of_unbalance(true.get(plane.name, report.rotor.magnitude_g_mm)),
                units.of_unbalance(plane.g_mm),
                units.heavy_at(plane.g_mm, plane.angle_deg, 2),
                "" if depth is None else units.of_length(depth),
                units.of_unbalance(left.g_mm),
            )
        )
    runs = len(report.runs)
    more = "" if runs == 1 else f"\n  the first of {runs} runs; {_spread(report.noise.g_mm, units)}"
    return table(rows) + more


def _spread(noise: Sequence[PlaneSpread], units: DisplayUnits) -> str:
    read = units.of_unbalance
    return ", ".join(
        f"{each.name} {read(each.mean)} ± {read(each.standard_deviation)}"
        for each in noise
        if each.standard_deviation is not None
    )


# Plots of a balancing machine: its readings as points.


def runs_plot(report: MachineReport) -> dict[str, Plot]:
    """Return the readings of all runs of ``machine`` in each plane, and the true unbalance, as points."""
    runs = np.array([[plane.unbalance_g_mm for plane in run.planes] for run in report.runs])
    left = np.array([plane.unbalance_g_mm for plane in report.runs[0].left.planes])
    true = runs[0] + left
    names = [plane.name for plane in report.runs[0].planes]
    clouds = {f"read in {name}": runs[:, number] for number, name in enumerate(names)}
    clouds |= {f"true in {name}": true[number][None, :] for number, name in enumerate(names)}
    labels = ("x, towards crankpin 1 [g·mm]", "y [g·mm]")
    return {"machine-readings": plots.scatter("Readings of the machine", labels, clouds)}
