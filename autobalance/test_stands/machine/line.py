"""``[machine.line]`` of a machine file: the lines that a machine writes, as a pattern with named groups."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from autobalance.declare import Values
from autobalance.errors import JobError
from autobalance.test_stands.machine.input import MACHINE_KEYS
from autobalance.test_stands.machine.live_reading import (
    ONE_PLANE_GROUPS,
    TWO_PLANE_GROUPS,
    LineFormat,
    Settling,
)
from autobalance.toml_files.keys import read_document
from autobalance.toml_files.typed_units import unbalance_unit
from autobalance.units import G_MM_PER


@dataclass(frozen=True)
class Watched:
    """Pattern of a machine's lines, conditions of a settled vector, and the other values of its reading."""

    line: LineFormat
    settling: Settling
    reading: Values
    speed_rpm: float | None


def read_watched(source: str | Path | Mapping[str, Any]) -> Watched:
    """Return the part of a machine file that ``machine --watch`` uses: the rotor may be missing.

    Raises
    ------
    FileError If it cannot be read. JobError If ``[machine.line]`` is missing or its pattern is invalid.
    """
    needless = ("kind", "rotor")
    keys = tuple(replace(key, default=None) if key.name in needless else key for key in MACHINE_KEYS)
    return read_document(source, "machine file", keys, _watched)


def _watched(values: Values) -> Watched:
    line = (values["machine"] or {}).get("line")
    if line is None:
        raise JobError(
            "[machine.line] is missing; expected a pattern with the groups amount, angle and maybe plane"
        )
    try:
        pattern = re.compile(line["pattern"])
    except re.error as error:
        raise JobError(f"machine.line.pattern is not a pattern: {error}") from None
    groups = set(pattern.groupindex)
    if not (set(ONE_PLANE_GROUPS) <= groups or set(TWO_PLANE_GROUPS) <= groups):
        raise JobError(
            f"machine.line.pattern has the groups {', '.join(sorted(groups)) or 'none'}; expected "
            f"(?P<amount>...) and (?P<angle>...), with (?P<plane>...) for two planes, or"
            f" {', '.join(TWO_PLANE_GROUPS)}"
        )
    unit = unbalance_unit(line["unit"])
    if unit is None:
        raise JobError(f"machine.line.unit is {line['unit']!r}; must be one of {', '.join(G_MM_PER)}")
    reading = values["reading"]
    least = reading["umar_g_mm"] if reading["umar_g_mm"] is not None else 0.0
    settling = Settling(line["settled_readings"], 0.01 * line["settled_percent"], least)
    return Watched(
        LineFormat(pattern, G_MM_PER[unit], line["planes"]), settling, reading, values["speed_rpm"]
    )
