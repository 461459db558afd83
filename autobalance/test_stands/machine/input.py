"""``MACHINE.toml``: a balancing machine and the rotor on it."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from autobalance.declare import COUNTED, FILLED, NOT_NEGATIVE, POSITIVE, Key, Range, Values
from autobalance.errors import JobError
from autobalance.job.files.reading_keys import (
    READS,
    ROTATION,
    SPEED_RPM,
    UMAR_G_MM,
    URR_PERCENT,
    ZERO_DEG,
    Convention,
)
from autobalance.test_stands.bench.spun_rotor import PlanarUnbalance, PointMass, RigidBody, axisymmetric
from autobalance.test_stands.machine.balancing_machine import Noise
from autobalance.test_stands.machine.drilled_depth import DrillPlace, HoleDirection
from autobalance.toml_files.keys import read_document
from autobalance.units import G_MM2_PER_KG_MM2, G_PER_MM3_PER_KG_M3, RAD_S_PER_RPM, STEEL_KG_M3

MachineKind = Literal["hard", "soft", "cradle", "nodal", "static"]
Pair = tuple[float, float]

G_S2_PER_N_MM = 1e6
"""1 N/mm in g/s², the stiffness of mm, g, s."""
MOST_RUNS = 100_000
POINT = Range("must be > 0 and ≤ 180", above=0.0, most=180.0)
RUNS = Range(f"must be 1 to {MOST_RUNS}", least=1, most=MOST_RUNS)

ROTOR_KEYS = (
    Key("report", str, "report of balance or recut: its solid and its bob-weights", default=None),
    Key("mass_g", float, "or: mass of the rotor", NOT_NEGATIVE, None),
    Key("z_mm", float, "its centre of mass", default=None),
    Key("transverse_kg_mm2", float, "inertia across the axis about the centre of mass", POSITIVE, None),
    Key("polar_kg_mm2", float, "inertia about the axis", POSITIVE, None),
)
UNBALANCE_KEYS = (
    Key("z_mm", float, "plane of the unbalance"),
    Key("g_mm", float, "its size", NOT_NEGATIVE),
    Key("angle_deg", float, "its heavy side"),
)
MASS_KEYS = (
    Key("g", float, "point mass", POSITIVE),
    Key("x_mm", float, "towards crankpin 1"),
    Key("y_mm", float, "across"),
    Key("z_mm", float, "along the axis"),
)
NOISE_KEYS = (
    Key("g_mm", float, "standard deviation of x and of y of each plane's reading", NOT_NEGATIVE, 0.0),
    Key("gain_percent", float, "error of the reading's size", NOT_NEGATIVE, 0.0),
    Key("angle_deg", float, "error of the reading's angle", NOT_NEGATIVE, 0.0),
)
READING_KEYS = (
    ROTATION,
    ZERO_DEG,
    READS,
    replace(URR_PERCENT, default=None),
    replace(UMAR_G_MM, default=None),
)
STATIC_KEYS = (
    Key("journal_radius_mm", float, "the journals roll on it", POSITIVE),
    Key("friction_lever_mm", float, "lever of rolling friction", NOT_NEGATIVE),
    Key("start_deg", float, "heavy side to straight down where it is let go", POINT, 90.0),
)
DRILL_KEYS = (
    Key("diameter_mm", float, "diameter of the drill", POSITIVE),
    Key("radius_mm", float, "radius of the rim, taken as flat; axial: radius of the hole's centre", POSITIVE),
    Key("point_angle_deg", float, "point angle of the drill", POINT, 118.0),
    Key("density_kg_m3", float, "density of the metal", POSITIVE, STEEL_KG_M3),
    Key("direction", HoleDirection, "into the rim, or along the axis", default="radial"),
)
LINE_KEYS = (
    Key(
        "pattern",
        str,
        "pattern of a line: a regular expression with the groups amount, angle and maybe plane",
    ),
    Key("unit", str, "unit of the amounts", default="g·mm"),
    Key("planes", tuple[str, str], "names of planes A and B in the lines", default=("A", "B")),
    Key("settled_readings", int, "readings in a row that must agree", COUNTED, 5),
    Key(
        "settled_percent",
        float,
        "largest difference of settled vectors from their mean, of the amount",
        POSITIVE,
        2.0,
    ),
)
MACHINE_KEYS = (
    Key("seed", int, "seed of the noise", NOT_NEGATIVE, 1),
    Key("runs", int, "how many readings", RUNS, 1),
    Key("kind", MachineKind, "hard: forces; soft, nodal: displacements; cradle: moments; static: rolls"),
    SPEED_RPM,
    Key("planes_mm", Pair, "planes A, B of the reading; default the report's tolerance planes", default=None),
    Key("bearings_mm", Pair, "two supports of hard and soft; default planes_mm", default=None),
    Key("stiffness_n_mm", float, "soft: of each support, horizontally; 0: free", NOT_NEGATIVE, 0.0),
    Key("rotor", says="rotor to be spun", keys=ROTOR_KEYS),
    Key("unbalance", says="on top", keys=UNBALANCE_KEYS, many=True, default=None),
    Key("mass", says="on top", keys=MASS_KEYS, many=True, default=None),
    Key("noise", says="standard deviations of normal draws", keys=NOISE_KEYS, default=FILLED),
    Key("reading", says="conventions of the written reading", keys=READING_KEYS, default=FILLED),
    Key("static", says="the stand", keys=STATIC_KEYS, default=None),
    Key("drill", says="drill that removes the metal", keys=DRILL_KEYS, default=None),
    Key(
        "machine",
        says="the machine's own lines, for --watch",
        keys=(Key("line", says="as it writes them", keys=LINE_KEYS, default=None),),
        default=None,
    ),
)


@dataclass(frozen=True)
class Stand:
    """The static stand."""

    journal_radius_mm: float
    friction_lever_mm: float
    start_rad: float


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
    noise: Noise
    convention: Convention
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
        _scaled(values["rotor"]["polar_kg_mm2"], G_MM2_PER_KG_MM2),
        tuple(
            PlanarUnbalance(each["z_mm"], cmath.rect(each["g_mm"], math.radians(each["angle_deg"])))
            for each in values["unbalance"]
        ),
        tuple(
            PointMass(each["g"], complex(each["x_mm"], each["y_mm"]), each["z_mm"]) for each in values["mass"]
        ),
        _noise(values["noise"]),
        Convention.of(values["reading"]),
        _stand(values["static"]),
        _drill(values["drill"]),
    )


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _rotor(values: Values, folder: Path) -> tuple[Path | None, RigidBody | None]:
    rotor = values["rotor"]
    if rotor["report"] is not None:
        numbers = [
            key for key in ("mass_g", "z_mm", "transverse_kg_mm2", "polar_kg_mm2") if rotor[key] is not None
        ]
        if numbers:
            raise JobError(f"rotor.{numbers[0]} is given with rotor.report; the report's solid says it")
        return folder / rotor["report"], None
    if rotor["mass_g"] is None:
        raise JobError("rotor.mass_g is missing; or rotor.report")
    if rotor["mass_g"] == 0.0:
        if not values["mass"]:
            raise JobError("rotor.mass_g is 0 and there is no [[mass]]; the rotor must have a mass")
        return None, axisymmetric(0.0, rotor["z_mm"] or 0.0, 0.0, 0.0)
    if rotor["z_mm"] is None:
        raise JobError("rotor.z_mm is missing; it is the place of the centre of mass")
    transverse = _scaled(rotor["transverse_kg_mm2"], G_MM2_PER_KG_MM2)
    if values["kind"] in ("soft", "nodal") and transverse is None:
        raise JobError(f'rotor.transverse_kg_mm2 is missing; kind = "{values["kind"]}" needs it')
    polar = _scaled(rotor["polar_kg_mm2"], G_MM2_PER_KG_MM2)
    if polar is not None and transverse is not None and polar > 2.0 * transverse * (1.0 + 1e-9):
        raise JobError(
            f"rotor.polar_kg_mm2 is {rotor['polar_kg_mm2']:g}, over twice transverse_kg_mm2, "
            f"{rotor['transverse_kg_mm2']:g}; no body has that"
        )
    return None, axisymmetric(rotor["mass_g"], rotor["z_mm"], transverse, polar)


def _noise(table: Values) -> Noise:
    return Noise(table["g_mm"], 0.01 * table["gain_percent"], math.radians(table["angle_deg"]))


def _stand(table: Values | None) -> Stand | None:
    if table is None:
        return None
    return Stand(table["journal_radius_mm"], table["friction_lever_mm"], math.radians(table["start_deg"]))


def _drill(table: Values | None) -> DrillPlace | None:
    if table is None:
        return None
    return DrillPlace(
        table["diameter_mm"],
        table["radius_mm"],
        math.radians(table["point_angle_deg"]),
        table["density_kg_m3"] * G_PER_MM3_PER_KG_M3,
        table["direction"],
    )
