"""``MACHINE.toml``: a balancing machine and the rotor on it."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from autobalance.declare import (
    COUNTED,
    DEGREES,
    FILLED,
    KG_MM2,
    NOT_NEGATIVE,
    POSITIVE,
    Key,
    Range,
    Values,
    keys_of,
    made,
)
from autobalance.errors import JobError
from autobalance.job import reading
from autobalance.test_stands.bench.spun_rotor import PlanarUnbalance, PointMass, RigidBody, axisymmetric
from autobalance.test_stands.machine.balancing_machine import POINT, DrillPlace, ReadingNoise
from autobalance.toml_files.keys import read_document
from autobalance.units import G_S2_PER_N_MM, RAD_S_PER_RPM
from autobalance.value_classes import dataclass

MachineKind = Literal["hard", "soft", "cradle", "nodal", "static"]
Pair = tuple[float, float]

MOST_RUNS = 100_000
RUNS = Range(f"must be 1 to {MOST_RUNS}", least=1, most=MOST_RUNS)


@dataclass(frozen=True)
class RotorTable:
    """``[rotor]``: a report's crank, or a body given by its numbers."""

    report: Annotated[str | None, "report of balance or recut: its solid and its bob-weights"] = None
    mass_g: Annotated[float | None, NOT_NEGATIVE, "or: mass of the rotor"] = None
    z_mm: Annotated[float | None, "place of the centre of mass"] = None
    transverse_g_mm2: Annotated[
        float | None, KG_MM2, POSITIVE, "inertia across the axis about the centre of mass"
    ] = None
    polar_g_mm2: Annotated[float | None, KG_MM2, POSITIVE, "inertia about the axis"] = None


@dataclass(frozen=True)
class HiddenUnbalance:
    """``[[unbalance]]``: what the machine is to find."""

    z_mm: Annotated[float, "plane of the unbalance"]
    g_mm: Annotated[float, NOT_NEGATIVE, "size"]
    angle_rad: Annotated[float, DEGREES, "angle of the heavy side"]

    def in_plane(self) -> PlanarUnbalance:
        """Return the same as a complex number."""
        return PlanarUnbalance(self.z_mm, cmath.rect(self.g_mm, self.angle_rad))


@dataclass(frozen=True)
class HiddenMass:
    """``[[mass]]``."""

    g: Annotated[float, POSITIVE, "point mass"]
    x_mm: Annotated[float, "towards crankpin 1"]
    y_mm: Annotated[float, "across"]
    z_mm: Annotated[float, "along the axis"]

    def point(self) -> PointMass:
        """Return the same, x and y as a complex number."""
        return PointMass(self.g, complex(self.x_mm, self.y_mm), self.z_mm)


READING_KEYS = (
    reading.ROTATION,
    reading.ZERO_DEG,
    reading.READS,
    replace(reading.URR_PERCENT, default=None),
    replace(reading.UMAR_G_MM, default=None),
)


@dataclass(frozen=True)
class Stand:
    """``[static]``: the static stand."""

    journal_radius_mm: Annotated[float, POSITIVE, "the journals roll on it"]
    friction_lever_mm: Annotated[float, NOT_NEGATIVE, "lever of rolling friction"]
    start_rad: Annotated[float, DEGREES, POINT, "heavy side to straight down where it is let go"] = (
        0.5 * math.pi
    )


@dataclass(frozen=True)
class WatchedLine:
    """``[machine.line]``: a line as the machine writes it."""

    pattern: Annotated[
        str, "pattern of a line: a regular expression with the groups amount, angle and maybe plane"
    ]
    unit: Annotated[str, "unit of the amounts"] = "g·mm"
    planes: Annotated[tuple[str, str], "names of planes A and B in the lines"] = ("A", "B")
    settled_readings: Annotated[int, COUNTED, "readings in a row that must agree"] = 5
    settled_percent: Annotated[
        float, POSITIVE, "largest difference of settled vectors from their mean, of the amount"
    ] = 2.0


LINE_KEYS = keys_of(WatchedLine)
MACHINE_KEYS = (
    Key("seed", int, "seed of the noise", NOT_NEGATIVE, 1),
    Key("runs", int, "number of readings", RUNS, 1),
    Key("kind", MachineKind, "hard: forces; soft, nodal: displacements; cradle: moments; static: rolls"),
    reading.SPEED_RPM,
    Key("planes_mm", Pair, "planes A, B of the reading; default the report's tolerance planes", default=None),
    Key("bearings_mm", Pair, "two supports of hard and soft; default planes_mm", default=None),
    Key("stiffness_n_mm", float, "soft: of each support, horizontally; 0: free", NOT_NEGATIVE, 0.0),
    Key("rotor", says="rotor to be spun", keys=keys_of(RotorTable)),
    Key("unbalance", says="on top", keys=keys_of(HiddenUnbalance), many=True, default=None),
    Key("mass", says="on top", keys=keys_of(HiddenMass), many=True, default=None),
    Key("noise", says="standard deviations of normal draws", keys=keys_of(ReadingNoise), default=FILLED),
    Key("reading", says="conventions of the written reading", keys=READING_KEYS, default=FILLED),
    Key("static", says="the stand", keys=keys_of(Stand), default=None),
    Key("drill", says="drill that removes the metal", keys=keys_of(DrillPlace), default=None),
    Key(
        "machine",
        says="the machine's own lines, for --watch",
        keys=(Key("line", says="as it writes them", keys=LINE_KEYS, default=None),),
        default=None,
    ),
)


@dataclass(frozen=True, eq=False)
class Machine:
    """The file in mm, g, s, rad.

    ``body`` and ``planes_mm`` are None if a report has them.

    ``polar_g_mm2`` is that of the rotor without point masses, None if it is not given.
    """

    values: Values
    kind: MachineKind
    seed: int
    runs: int
    speed_rad_s: float | None
    planes_mm: Pair | None
    bearings_mm: Pair | None
    stiffness_g_s2: float
    report: Path | None
    body: RigidBody | None
    polar_g_mm2: float | None
    unbalances: tuple[PlanarUnbalance, ...]
    masses: tuple[PointMass, ...]
    noise: ReadingNoise
    convention: reading.Convention
    stand: Stand | None
    drill: DrillPlace | None


def read_machine(source: str | Path | Mapping[str, Any]) -> Machine:
    """Read a machine file, or its structure; a report's path is relative to the file.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a key is unknown, missing or impossible.
    """
    folder = Path() if isinstance(source, Mapping) else Path(source).parent
    return read_document(source, "machine file", MACHINE_KEYS, lambda values: _machine(values, folder))


def _machine(values: Values, folder: Path) -> Machine:
    kind, speed, planes = values["kind"], values["speed_rpm"], values["planes_mm"]
    report, body = _rotor(values, folder)
    for key in ("planes_mm", "bearings_mm"):
        if values[key] is not None and values[key][0] == values[key][1]:
            raise JobError(
                f"{key} is [{values[key][0]:g}, {values[key][1]:g}]; expected two different places"
            )
    if planes is None and report is None and kind != "static":
        raise JobError("planes_mm is missing; a rotor given as numbers has no tolerance planes to read in")
    if kind == "static" and values["static"] is None:
        raise JobError("[static] is missing; the static stand needs journal_radius_mm and friction_lever_mm")
    sprung = kind == "soft" and values["stiffness_n_mm"] > 0.0
    if speed is None and (kind in ("hard", "cradle") or sprung):
        raise JobError(f'speed_rpm is missing; kind = "{kind}" needs it')
    return Machine(
        values,
        kind,
        values["seed"],
        values["runs"],
        None if speed is None else speed * RAD_S_PER_RPM,
        planes,
        values["bearings_mm"],
        values["stiffness_n_mm"] * G_S2_PER_N_MM,
        report,
        body,
        made(RotorTable, values["rotor"]).polar_g_mm2,
        tuple(made(HiddenUnbalance, each).in_plane() for each in values["unbalance"]),
        tuple(made(HiddenMass, each).point() for each in values["mass"]),
        made(ReadingNoise, values["noise"]),
        reading.Convention.of(values["reading"]),
        None if values["static"] is None else made(Stand, values["static"]),
        None if values["drill"] is None else made(DrillPlace, values["drill"]),
    )


def _rotor(values: Values, folder: Path) -> tuple[Path | None, RigidBody | None]:
    rotor = made(RotorTable, values["rotor"])
    if rotor.report is not None:
        numbers = [key for key, value in values["rotor"].items() if key != "report" and value is not None]
        if numbers:
            raise JobError(f"rotor.{numbers[0]} is given with rotor.report, which has it; remove one of them")
        return folder / rotor.report, None
    if rotor.mass_g is None:
        raise JobError("rotor.mass_g is missing; or rotor.report")
    if rotor.mass_g == 0.0:
        if not values["mass"]:
            raise JobError("rotor.mass_g is 0 and there is no [[mass]]; the rotor must have a mass")
        return None, axisymmetric(0.0, rotor.z_mm or 0.0, 0.0, 0.0)
    if rotor.z_mm is None:
        raise JobError("rotor.z_mm is missing; it is the place of the centre of mass")
    transverse, polar = rotor.transverse_g_mm2, rotor.polar_g_mm2
    if values["kind"] in ("soft", "nodal") and transverse is None:
        raise JobError(f'rotor.transverse_kg_mm2 is missing; kind = "{values["kind"]}" needs it')
    if polar is not None and transverse is not None and polar > 2.0 * transverse * (1.0 + 1e-9):
        raise JobError(
            f"rotor.polar_kg_mm2 is {KG_MM2.written(polar):g}, over twice transverse_kg_mm2, "
            f"{KG_MM2.written(transverse):g}; no body has that"
        )
    return None, axisymmetric(rotor.mass_g, rotor.z_mm, transverse, polar)
