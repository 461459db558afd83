"""The report of `machine`, and its text and plots."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np

from autobalance.declare import Angle, Degrees, NotNegative, Pair, Positive, Size, Triple, record
from autobalance.report import plots
from autobalance.report.display_units import DisplayUnits
from autobalance.report.plots import Plot
from autobalance.report.records.answers import Head
from autobalance.report.tables import table
from autobalance.test_stands.machine.balancing_machine import StaticStand

if TYPE_CHECKING:
    from autobalance.test_stands.machine.balancing_machine import StaticStand


# The report of `machine`.


@record
class PlaneVector:
    """Unbalance in a plane."""

    name: str
    unbalance_g_mm: Pair
    g_mm: NotNegative
    angle_deg: Angle


@record
class MachinePlane:
    """Reading, or true unbalance, in a plane; without a place on a static stand."""

    schema_name: ClassVar[str] = "plane_reading"

    name: str
    z_mm: float | None
    unbalance_g_mm: Pair
    g_mm: NotNegative
    angle_deg: Angle


@record
class SpunRotorFigures:
    """The rotor as it is."""

    mass_g: Positive
    centre_of_mass_mm: Triple
    unbalance_g_mm: Pair
    moment_g_mm2: Pair
    magnitude_g_mm: NotNegative
    planes: Annotated[Sequence[MachinePlane], Size(most=2)]
    kind: Literal["balanced", "static", "couple", "quasi_static", "dynamic"]
    principal_axis_rad: Degrees | None


@record
class SensorReading:
    """Reading of a sensor of the machine."""

    name: str
    z_mm: float
    force_N: NotNegative | None
    displacement_um: NotNegative | None
    moment_N_m: NotNegative | None
    angle_deg: Angle


@record
class PlaneNode:
    """Place at which a plane's unbalance moves the axis least."""

    plane: str
    z_mm: float


@record
class LeftUnbalance:
    """Residual unbalance where a reading is followed to the letter."""

    planes: Sequence[PlaneVector]
    magnitude_g_mm: NotNegative


@record
class MachineRun:
    """A spin of the rotor."""

    planes: Sequence[MachinePlane]
    left: LeftUnbalance


@record
class MachineCorrection:
    """Correction of the first reading: the amount to take off at the heavy side."""

    plane: str
    g_mm: NotNegative
    angle_deg: Angle
    depth_mm: NotNegative | None


@record
class PlaneSpread:
    """Mean and standard deviation of what a plane reads; None from a single run."""

    name: str
    mean: NotNegative
    standard_deviation: NotNegative | None


@record
class MachineNoise:
    """Scatter of the readings over the runs."""

    g_mm: Sequence[PlaneSpread]


@record
class MachineReport(Head):
    """Readings of a balancing machine on a rotor of known unbalance, and the residual after them."""

    command: Literal["machine"] = "machine"
    input: Mapping[str, Any]
    rotor: SpunRotorFigures
    sensors: Sequence[SensorReading] | None
    nodes: Sequence[PlaneNode] | None
    static: StaticStand | None
    runs: Sequence[MachineRun]
    corrections: Sequence[MachineCorrection]
    noise: MachineNoise
    bob_weights_g: Sequence[float] | None
    serial: str | None
    warnings: Sequence[str]


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
