"""``ab.machine``: simulate a balancing machine on a rotor of known unbalance."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.errors import JobError
from autobalance.report.plots import Plots
from autobalance.test_stands.machine.answer import (
    LeftUnbalance,
    MachineCorrection,
    MachineNoise,
    MachinePlane,
    MachineReport,
    MachineRun,
    PlaneNode,
    PlaneSpread,
    PlaneVector,
    SensorReading,
    SpunRotorFigures,
)
from autobalance.units import N_M_PER_G_MM2_S2, N_PER_G_MM_S2, UM_PER_MM, wrapped_deg
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.test_stands.bench.spun_rotor import SpunRotor
    from autobalance.test_stands.machine.balancing_machine import StaticStand
    from autobalance.test_stands.machine.input import Machine
    from autobalance.test_stands.machine.reported_rotor import ReportedRotor

Pair = tuple[float, float]


class MachineResult(VerbResult):
    """Sensors, readings and corrections; ``reading_toml`` is the first reading as a file for ``recut``."""

    content: MachineReport

    def text(self, units: str = "metric") -> str:
        """Return the reading as lines for people."""
        from autobalance.report.display_units import ON_SCREEN
        from autobalance.test_stands.machine.answer import machine_text

        return machine_text(self.content, ON_SCREEN[units])

    def plots(self) -> Plots:
        """Return a polar plot of the readings of all runs."""
        from autobalance.test_stands.machine.answer import runs_plot

        return Plots(runs_plot(self.content))

    def files(self) -> Mapping[str, bytes]:
        """Return ``reading.toml``, the first reading in the machine's own way of counting."""
        from autobalance.test_stands.machine.watch import reading_toml

        return {"reading.toml": reading_toml(self.content).encode()}


def machine(machine_file: str | Path | Mapping[str, Any]) -> MachineResult:
    """Simulate a balancing machine.

    Parameters
    ----------
    machine_file : path or dict
        Machine file: the kind of machine, the rotor, its unbalance, the noise. Or its structure.

    Returns
    -------
    MachineResult

    Raises
    ------
    JobError
        If a key is wrong, or the machine cannot read such a rotor.

    Examples
    --------
    >>> rotor = {"mass_g": 2000.0, "z_mm": 0.0}
    >>> found = machine({"kind": "hard", "speed_rpm": 600.0, "planes_mm": [-40.0, 40.0], "rotor": rotor,
    ...     "unbalance": [{"z_mm": 40.0, "g_mm": 100.0, "angle_deg": 30.0}]})
    >>> [round(plane["g_mm"], 6) for plane in found.report["runs"][0]["planes"]]
    [0.0, 100.0]
    """
    from autobalance.test_stands.machine.input import read_machine
    from autobalance.toml_files.keys import named_in

    case = read_machine(machine_file)
    with named_in(machine_file):
        return MachineResult(_report(case))


def _report(case: Machine) -> MachineReport:
    from autobalance.test_stands.bench.spun_rotor import spun_rotor
    from autobalance.test_stands.machine.balancing_machine import noisy_readings

    reported = _reported(case)
    body = case.body if reported is None else reported.body
    assert body is not None
    rotor = spun_rotor(body, case.unbalances, case.masses)
    planes_mm = case.planes_mm if reported is None or case.planes_mm is not None else reported.planes_mm
    names, places, true = _planes(case, rotor, planes_mm)
    runs = noisy_readings(true, case.noise, case.runs, case.seed)
    read = [[_plane(*each) for each in zip(names, places, values, strict=True)] for values in runs]
    stand, of_stand = _static(case, rotor)
    corrections, of_drill = _corrections(case, read[0])
    return MachineReport(
        input=case.values,
        rotor=_rotor_figures(rotor, planes_mm),
        sensors=_sensors(case, rotor, planes_mm),
        nodes=_nodes(case, rotor, planes_mm),
        static=stand,
        runs=[
            MachineRun(planes=planes, left=_left(names, true, values))
            for planes, values in zip(read, runs, strict=True)
        ],
        corrections=corrections,
        noise=MachineNoise(g_mm=_spread(names, runs)),
        bob_weights_g=None if reported is None else reported.fit_g,
        serial=None if reported is None else reported.serial,
        warnings=[*of_stand, *of_drill],
    )


def _reported(case: Machine) -> ReportedRotor | None:
    if case.report is None:
        return None
    from autobalance.test_stands.machine.reported_rotor import reported_rotor

    return reported_rotor(case.report)


def _planes(
    case: Machine, rotor: SpunRotor, planes_mm: Pair | None
) -> tuple[tuple[str, ...], tuple[float | None, ...], tuple[complex, ...]]:
    """Return name, place and true unbalance of each plane that is read."""
    if case.kind == "static":
        return ("static",), (None,), (rotor.unbalance_g_mm,)
    if planes_mm is None:
        raise JobError("planes_mm is missing; the report has no tolerance planes to read in")
    return ("A", "B"), planes_mm, rotor.in_planes(*planes_mm)


def _plane(name: str, z_mm: float | None, value: complex) -> MachinePlane:
    return MachinePlane(
        name=name,
        z_mm=z_mm,
        unbalance_g_mm=[value.real, value.imag],
        g_mm=abs(value),
        angle_deg=degrees(value),
    )


def degrees(value: complex) -> float:
    """Return the angle of a vector in [0, 360)."""
    return wrapped_deg(math.degrees(cmath.phase(value)))


def _rotor_figures(rotor: SpunRotor, planes_mm: Pair | None) -> SpunRotorFigures:
    unbalance, moment = rotor.unbalance_g_mm, rotor.moment_g_mm2
    planes = [] if planes_mm is None else list(zip("AB", planes_mm, rotor.in_planes(*planes_mm), strict=True))
    return SpunRotorFigures(
        mass_g=rotor.mass_g,
        centre_of_mass_mm=[unbalance.real / rotor.mass_g, unbalance.imag / rotor.mass_g, rotor.z_mm],
        unbalance_g_mm=[unbalance.real, unbalance.imag],
        moment_g_mm2=[moment.real, moment.imag],
        magnitude_g_mm=abs(unbalance),
        planes=[_plane(*each) for each in planes],
        kind=rotor.kind,
        principal_axis_rad=rotor.principal_axis_rad,
    )


def _sensor(name: str, z_mm: float, quantity: str, value: complex, unit: float) -> SensorReading:
    size = unit * abs(value)
    return SensorReading(
        name=name,
        z_mm=z_mm,
        force_N=size if quantity == "force_N" else None,
        displacement_um=size if quantity == "displacement_um" else None,
        moment_N_m=size if quantity == "moment_N_m" else None,
        angle_deg=degrees(value),
    )


def _sensors(case: Machine, rotor: SpunRotor, planes_mm: Pair | None) -> list[SensorReading] | None:
    from autobalance.test_stands.machine import balancing_machine as machines

    if case.kind == "static" or planes_mm is None:
        return None
    speed, supports = case.speed_rad_s or 0.0, case.bearings_mm or planes_mm
    if case.kind == "hard":
        forces = machines.support_forces(rotor, supports, speed)
        quantity, unit, places, values = "force_N", N_PER_G_MM_S2, supports, forces
    elif case.kind == "cradle":
        moments = machines.cradle_moments(rotor, planes_mm, speed)
        quantity, unit, places, values = "moment_N_m", N_M_PER_G_MM2_S2, planes_mm, moments
    else:
        places = supports if case.kind == "soft" else _node_places(rotor, planes_mm)
        moved = _displacements(case, rotor, places)
        quantity, unit, values = "displacement_um", UM_PER_MM, moved
    names = ("A", "B") if case.kind == "nodal" else ("1", "2")
    return [_sensor(*each, unit) for each in zip(names, places, (quantity,) * 2, values, strict=True)]


def _displacements(case: Machine, rotor: SpunRotor, places: Pair) -> tuple[complex, complex]:
    from autobalance.test_stands.machine.balancing_machine import free_displacement, sprung_displacements

    if case.kind == "soft" and case.stiffness_g_s2 > 0.0 and case.speed_rad_s is not None:
        try:
            return sprung_displacements(rotor, places, case.stiffness_g_s2, case.speed_rad_s)
        except ValueError as error:
            raise JobError(f"speed_rpm is {case.values['speed_rpm']:g}: {error}") from None
    return free_displacement(rotor, places[0]), free_displacement(rotor, places[1])


def _node_places(rotor: SpunRotor, planes_mm: Pair) -> Pair:
    """Return places at which planes A and B are read alone: each at the node of the other."""
    from autobalance.test_stands.machine.balancing_machine import node_mm

    try:
        return node_mm(rotor, planes_mm[1]), node_mm(rotor, planes_mm[0])
    except ValueError as error:
        raise JobError(f"planes_mm is [{planes_mm[0]:g}, {planes_mm[1]:g}]: {error}") from None


def _nodes(case: Machine, rotor: SpunRotor, planes_mm: Pair | None) -> list[PlaneNode] | None:
    """Return the node of each plane's unbalance; None for the kinds that have no such planes."""
    if case.kind != "nodal" or planes_mm is None:
        return None
    of_B, of_A = _node_places(rotor, planes_mm)
    return [PlaneNode(plane="A", z_mm=of_A), PlaneNode(plane="B", z_mm=of_B)]


def _static(case: Machine, rotor: SpunRotor) -> tuple[StaticStand | None, list[str]]:
    """Return the reading of a static stand, and warnings."""
    from autobalance.test_stands.machine.balancing_machine import static_stand

    if case.kind != "static" or case.stand is None:
        return None, []
    stand, polar = case.stand, case.polar_g_mm2
    if rotor.second_g_mm2 is not None:  # that of the rotor with all that is on it, about the axis
        around = rotor.second_g_mm2[0, 0] + rotor.second_g_mm2[1, 1]
        polar = float(around + abs(rotor.unbalance_g_mm) ** 2 / rotor.mass_g)
    elif polar is not None:
        polar += sum(each.mass_g * abs(each.offset_mm) ** 2 for each in case.masses)
    found = static_stand(
        abs(rotor.unbalance_g_mm),
        rotor.mass_g,
        stand.friction_lever_mm,
        stand.journal_radius_mm,
        stand.start_rad,
        polar,
    )
    if not found.rolls:
        still = (
            f"the rotor does not roll: its unbalance of {abs(rotor.unbalance_g_mm):.4g} g·mm is not over the "
            f"{found.least_g_mm:.4g} g·mm of rolling friction"
        )
        return found, [still]
    if polar is None:
        return found, ["rotor.polar_kg_mm2 is not given, so there is no roll_time_s"]
    return found, []


def _left(names: Sequence[str], true: Sequence[complex], read: Sequence[complex]) -> LeftUnbalance:
    """Return the residual where the reading is followed to the letter."""
    left = [a - b for a, b in zip(true, read, strict=True)]
    return LeftUnbalance(
        planes=[
            PlaneVector(
                name=name,
                unbalance_g_mm=[value.real, value.imag],
                g_mm=abs(value),
                angle_deg=degrees(value),
            )
            for name, value in zip(names, left, strict=True)
        ],
        magnitude_g_mm=abs(sum(left)),
    )


def _corrections(case: Machine, planes: Sequence[MachinePlane]) -> tuple[list[MachineCorrection], list[str]]:
    """Return amounts to take off for the first reading, at the heavy side, and warnings."""
    corrections, warnings = [], []
    for plane in planes:
        depth = None if case.drill is None else case.drill.depth_mm(plane.g_mm)
        if case.drill is not None and depth is None:
            point = case.drill.unbalance_g_mm(0.0)
            what = (
                "the drill's point alone takes off more" if plane.g_mm < point else "no hole is deep enough"
            )
            warnings.append(f"plane {plane.name}: {plane.g_mm:.4g} g·mm cannot be drilled; {what}")
        corrections.append(
            MachineCorrection(plane=plane.name, g_mm=plane.g_mm, angle_deg=plane.angle_deg, depth_mm=depth)
        )
    return corrections, warnings


def _spread(names: Sequence[str], runs: Sequence[Sequence[complex]]) -> list[PlaneSpread]:
    """Return mean and standard deviation of what each plane reads; None from a single run."""
    sizes = np.abs(np.array(runs))
    spread = np.std(sizes, axis=0, ddof=1) if len(runs) > 1 else [None] * len(names)
    return [
        PlaneSpread(name=name, mean=float(mean), standard_deviation=None if off is None else float(off))
        for name, mean, off in zip(names, sizes.mean(axis=0), spread, strict=True)
    ]
