"""``[drive]`` of a job, or a separate file: gears, belts and shafts that the crank drives."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from autobalance.declare import Key, Values, keys_of, made
from autobalance.errors import JobError
from autobalance.job.tables import AddonTables, TablesRead
from autobalance.signals.sources import DriveSources
from autobalance.toml_files.keys import read_document

DRIVE_KEYS = keys_of(DriveSources)
DRIVE = Key(
    "drive",
    says="gears, belts and shafts that the crank drives: see [signals.md](signals.md)",
    keys=DRIVE_KEYS,
    default=None,
    verbs="orders",
    shape={"minProperties": 1},
)


def _made(read: TablesRead) -> DriveSources | None:
    table = read.values.get("drive")
    return None if table is None else drive_of(table)


TABLES = AddonTables((DRIVE,), _made)


def read_drive(source: str | Path | Mapping[str, Any]) -> DriveSources:
    """Read a drive file, or its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a key is unknown, missing or impossible, or there is nothing in it.
    """
    return read_document(source, "drive file", DRIVE_KEYS, _drive)


def drive_of(values: Values) -> DriveSources:
    """Return the drive of a job's ``[drive]``.

    Raises
    ------
    JobError
        If there is nothing in it, or it is impossible.
    """
    return _drive(values, "drive.")


def _drive(values: Values, path: str = "") -> DriveSources:
    drive = made(DriveSources, values)
    if not (drive.gears or drive.belts or drive.shafts):
        raise JobError(f"{path}gear, belt and shaft are all missing; expected at least one")
    for number, belt in enumerate(drive.belts, 1):
        if belt.length_mm <= math.pi * belt.pulley_mm:
            around = math.pi * belt.pulley_mm
            raise JobError(
                f"{path}belt[{number}].length_mm is {belt.length_mm:g}; must be more than once around its"
                f" pulley, {around:.4g} mm"
            )
    return drive
