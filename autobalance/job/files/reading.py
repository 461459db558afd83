"""Read ``READING.toml``: a balancing machine's reading of a corrected crank."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from autobalance.declare import NOT_NEGATIVE, POSITIVE, Key, Values
from autobalance.errors import JobError
from autobalance.job.files.reading_keys import AS_READ, READS, Convention
from autobalance.toml_files.keys import read_document
from autobalance.toml_files.typed_units import refuse_unfilled
from autobalance.units import G_MM_PER_OZ_IN

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
