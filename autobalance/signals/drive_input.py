"""``[drive]`` of a job, or a separate file: gears, belts and shafts that the crank drives."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autobalance.declare import COUNTED, NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.errors import JobError
from autobalance.job.addon_tables import AddonTables, TablesRead
from autobalance.signals.drive_sources import Belt, Drive, DrivenShaft, Gear
from autobalance.toml_files.keys import read_document

NAME = Key("name", str, "name in reports")
GEAR_KEYS = (
    NAME,
    Key("teeth", int, "teeth of the wheel whose speed is given", COUNTED),
    Key("speed", float, "speed of that wheel over the crank's", POSITIVE, 1.0),
    Key("mates", int, "teeth of the other wheel", COUNTED, None),
    Key("error_um", float, "transmission error once a tooth, peak", NOT_NEGATIVE, None),
    Key("runout_um", float, "eccentricity of the wheel", NOT_NEGATIVE, None),
    Key("stiffness_N_um", float, "stiffness of the mesh", POSITIVE, None),
)
BELT_KEYS = (
    NAME,
    Key("length_mm", float, "length of the belt or chain", POSITIVE),
    Key("pulley_mm", float, "pitch diameter of the pulley", POSITIVE),
    Key("speed", float, "speed of that pulley over the crank's", POSITIVE, 1.0),
    Key("teeth", int, "teeth of the pulley, for a toothed belt or a chain", COUNTED, None),
    Key("runout_um", float, "eccentricity of the pulley", NOT_NEGATIVE, None),
    Key("stiffness_N_um", float, "stiffness of the spans", POSITIVE, None),
)
SHAFT_KEYS = (
    NAME,
    Key("speed", float, "its speed over the crank's", POSITIVE),
    Key("unbalance_g_mm", float, "its unbalance", NOT_NEGATIVE, None),
)
DRIVE_KEYS = (
    Key("gear", says="pairs of wheels", keys=GEAR_KEYS, many=True, default=()),
    Key("belt", says="belts and chains", keys=BELT_KEYS, many=True, default=()),
    Key("shaft", says="shafts and accessories", keys=SHAFT_KEYS, many=True, default=()),
)
DRIVE = Key(
    "drive",
    says="gears, belts and shafts that the crank drives: see [signals.md](signals.md)",
    keys=DRIVE_KEYS,
    default=None,
    verbs="orders",
    shape={"minProperties": 1},
)


def _made(read: TablesRead) -> Drive | None:
    table = read.values.get("drive")
    return None if table is None else drive_of(table)


TABLES = AddonTables((DRIVE,), _made)


def read_drive(source: str | Path | Mapping[str, Any]) -> Drive:
    """Read a drive file, or its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a key is unknown, missing or impossible, or there is nothing in it.
    """
    return read_document(source, "drive file", DRIVE_KEYS, _drive)


def drive_of(values: Values) -> Drive:
    """Return the drive of a job's ``[drive]``.

    Raises
    ------
    JobError
        If there is nothing in it, or it is impossible.
    """
    return _drive(values, "drive.")


def _drive(values: Values, path: str = "") -> Drive:
    gears = tuple(Gear(**each) for each in values["gear"])
    belts = tuple(Belt(**each) for each in values["belt"])
    shafts = tuple(DrivenShaft(**each) for each in values["shaft"])
    if not (gears or belts or shafts):
        raise JobError(f"{path}gear, belt and shaft are all missing; expected at least one")
    for number, belt in enumerate(belts, 1):
        if belt.length_mm <= math.pi * belt.pulley_mm:
            around = math.pi * belt.pulley_mm
            raise JobError(
                f"{path}belt[{number}].length_mm is {belt.length_mm:g}; must be more than once around its"
                f" pulley, {around:.4g} mm"
            )
    return Drive(gears, belts, shafts)
