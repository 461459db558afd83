"""The file of a balancing machine's reading, and the keys of every file that is read beside a job."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from autobalance import registry
from autobalance.declare import NOT_NEGATIVE, POSITIVE, Key, Range, Values
from autobalance.errors import JobError
from autobalance.toml_files.keys import read_document
from autobalance.toml_files.typed_units import refuse_unfilled
from autobalance.units import G_MM_PER_OZ_IN, wrapped_deg
from autobalance.value_classes import dataclass

# Keys of the convention of a balancing machine's reading, and angles between its sense and the rotor's.


Rotation = Literal["ccw", "cw"]
Reads = Literal["heavy", "light"]

PERCENT = Range("must be > 0 and ≤ 100", above=0.0, most=100.0)

ROTATION = Key("rotation", Rotation, "sense in which angle_deg counts, seen from +z", default="ccw")
ZERO_DEG = Key(
    "zero_deg", float, "the machine's zero mark in the rotor frame, ccw from crankpin 1", default=0.0
)
READS = Key("reads", Reads, "heavy: where the mass is too much; light: opposite", default="heavy")
URR_PERCENT = Key("urr_percent", float, "unbalance reduction ratio", PERCENT)
UMAR_G_MM = Key(
    "umar_g_mm", float, "minimum achievable residual unbalance of a plane's reading", NOT_NEGATIVE
)
SPEED_RPM = Key("speed_rpm", float, "speed of the machine", POSITIVE, None)
AS_READ = (
    Key("serial", str, "serial number, goes onto the sheet", default=None),
    SPEED_RPM,
    Key("bob_weights_g", tuple[float, ...], "clamped on, one a throw", NOT_NEGATIVE, None),
    Key("attached_fitted", bool, "were the [[engine.attached]] parts on", default=True),
    URR_PERCENT,
    UMAR_G_MM,
    ROTATION,
    ZERO_DEG,
)
"""Conventions of a machine's reading: of a reading file, and of trials that make one."""


@dataclass(frozen=True)
class Convention:
    """Convention of a reading's angles."""

    rotation: Rotation = "ccw"
    zero_deg: float = 0.0
    reads: Reads = "heavy"

    @staticmethod
    def of(values: Values) -> Convention:
        return Convention(values["rotation"], values["zero_deg"], values["reads"])

    @property
    def sense(self) -> float:
        """Return +1 where the machine counts counter-clockwise, −1 where clockwise."""
        return 1.0 if self.rotation == "ccw" else -1.0

    @property
    def offset_deg(self) -> float:
        """Return the rotor angle of a reading of 0°."""
        return self.zero_deg + (180.0 if self.reads == "light" else 0.0)

    def rotor_deg(self, angle_deg: float) -> float:
        """Return the angle of the heavy side in the rotor frame."""
        return wrapped_deg(self.offset_deg + self.sense * angle_deg)

    def machine_deg(self, rotor_deg: float) -> float:
        """Return the machine's angle for a heavy side at an angle of the rotor frame."""
        return wrapped_deg(self.sense * (rotor_deg - self.offset_deg))


# Read ``READING.toml``: a balancing machine's reading of a corrected crank.


PLANE_KEYS = (
    Key("at", Literal["A", "B"], "tolerance plane of the report", default=None),
    Key("z_mm", float, "or: place of the plane, rotor frame", default=None),
    Key("g_mm", float, "reading [g·mm]", NOT_NEGATIVE, None),
    Key("oz_in", float, "or [oz·in]", NOT_NEGATIVE, None),
    Key("g", float, "or a weight, with radius_mm", NOT_NEGATIVE, None),
    Key("radius_mm", float, "radius of that weight", POSITIVE, None),
    Key("angle_deg", float, "angle in the machine's direction from its zero mark"),
)
READING_KEYS = (
    *AS_READ,
    READS,
    Key("plane", says="one (static) or two", keys=PLANE_KEYS, many=True),
    Key("before", says="read before this report's cuts were made", keys=PLANE_KEYS, many=True, default=None),
    Key("correction", dict, "replaces the job's [correction] from this stage on", default=None),
)


@dataclass(frozen=True)
class ReadPlane:
    """Reading in a plane: heavy side in the rotor frame; ``at`` or ``z_mm`` is its place, or neither."""

    at: Literal["A", "B"] | None
    z_mm: float | None
    unbalance_g_mm: complex


@dataclass(frozen=True, eq=False)
class MachineReading:
    """A reading file; ``before`` is empty if nothing was read before the cuts."""

    values: Values
    serial: str | None
    speed_rpm: float | None
    bob_weights_g: tuple[float, ...] | None
    attached_fitted: bool
    urr: float
    umar_g_mm: float
    planes: tuple[ReadPlane, ...]
    before: tuple[ReadPlane, ...]
    correction: Mapping[str, Any] | None


def read_reading(source: str | Path | Mapping[str, Any]) -> MachineReading:
    """Read a reading file, or its structure.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If a key is unknown, missing or impossible.
    """
    return read_document(source, "reading file", READING_KEYS, _reading, refuse_unfilled)


def _reading(values: Values) -> MachineReading:
    convention = Convention.of(values)
    planes = _planes(values["plane"], "plane", convention)
    before = _planes(values["before"], "before", convention)
    if before and len(before) != len(planes):
        raise JobError(f"before has {len(before)} planes, plane {len(planes)}; both need as many")
    return MachineReading(
        values,
        values["serial"],
        values["speed_rpm"],
        values["bob_weights_g"],
        values["attached_fitted"],
        0.01 * values["urr_percent"],
        values["umar_g_mm"],
        planes,
        before,
        values["correction"],
    )


def _planes(tables: list[Values], key: str, convention: Convention) -> tuple[ReadPlane, ...]:
    if len(tables) > 2:
        raise JobError(f"{key} has {len(tables)} entries; expected one (static) or two")
    return tuple(
        _plane(each, f"{key}[{number}]", len(tables), convention) for number, each in enumerate(tables, 1)
    )


def _plane(each: Values, where: str, count: int, convention: Convention) -> ReadPlane:
    if each["at"] is not None and each["z_mm"] is not None:
        raise JobError(f"{where}.at is given with z_mm; expected one of them")
    if count == 2 and each["at"] is None and each["z_mm"] is None:
        raise JobError(f'{where}.at is missing; "A", "B", or z_mm')
    rotor = math.radians(convention.rotor_deg(each["angle_deg"]))
    return ReadPlane(each["at"], each["z_mm"], cmath.rect(_size_g_mm(each, where), rotor))


def _size_g_mm(each: Values, where: str) -> float:
    sizes = [key for key in ("g_mm", "oz_in", "g") if each[key] is not None]
    if len(sizes) != 1:
        fault = "missing; expected exactly one of g_mm, oz_in, g" if not sizes else f"given with {sizes[1]}"
        raise JobError(f"{where}.{sizes[0] if sizes else 'g_mm'} is {fault}")
    if sizes == ["g"]:
        if each["radius_mm"] is None:
            raise JobError(f"{where}.radius_mm is missing; g needs it")
        return float(each["g"] * each["radius_mm"])
    if each["radius_mm"] is not None:
        raise JobError(f"{where}.radius_mm is given with {sizes[0]}; it belongs to g")
    return float(each["g_mm"] if sizes == ["g_mm"] else each["oz_in"] * G_MM_PER_OZ_IN)


# Keys of each file that the program reads beside a job, by the name of its schema.


def forms_of(name: str) -> Mapping[str, tuple[Key, ...]]:
    """Return the keys at the top level of a file, by its form; most have one, without a name."""
    declared = registry.loaded(registry.FILES[name])
    if callable(declared):
        declared = declared()
    return declared if isinstance(declared, Mapping) else {"": declared}
