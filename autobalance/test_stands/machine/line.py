"""Lines that a balancing machine writes, as vectors, and the settling of its readings."""

from __future__ import annotations

import cmath
import math
import re
from collections import deque
from collections.abc import Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Any

from autobalance.declare import Values
from autobalance.errors import JobError
from autobalance.test_stands.machine.input import MACHINE_KEYS
from autobalance.toml_files.keys import read_document
from autobalance.toml_files.typed_units import unbalance_unit
from autobalance.units import G_MM_PER
from autobalance.value_classes import dataclass

# Lines of a balancing machine as vectors, and the settling of its readings; pure numbers.


ONE_PLANE_GROUPS = ("amount", "angle")
"""Groups of a line with one plane; ``plane`` is its name."""
TWO_PLANE_GROUPS = ("amount_a", "angle_a", "amount_b", "angle_b")
"""Groups of a line with both planes."""


@dataclass(frozen=True)
class LineFormat:
    """Format of vectors in a machine's lines.

    Attributes
    ----------
    pattern : re.Pattern
        With the groups ``amount``, ``angle`` and maybe ``plane``, or those of both planes.
    g_mm_per_unit : float
        Of the amounts.
    planes : (str, str)
        The machine's names of planes A and B.
    """

    pattern: re.Pattern[str]
    g_mm_per_unit: float
    planes: tuple[str, str]

    def vectors(self, line: str) -> dict[str, complex]:
        """Return the vectors of a line by plane, ``A``, ``B`` or, with one plane only, ``""`` [g·mm].

        Angles have the machine's own sense. A line that is not a reading gives none.
        """
        match = self.pattern.search(line)
        if match is None:
            return {}
        groups = match.groupdict()
        pairs: dict[str | None, tuple[str | None, str | None]]
        if TWO_PLANE_GROUPS[0] in groups:
            pairs = {name: (groups[f"amount_{end}"], groups[f"angle_{end}"]) for name, end in ("Aa", "Bb")}
        else:
            pairs = {self._name(groups.get("plane")): (groups["amount"], groups["angle"])}
        try:
            return {
                name: cmath.rect(_number(amount) * self.g_mm_per_unit, math.radians(_number(angle)))
                for name, (amount, angle) in pairs.items()
                if name is not None and amount is not None and angle is not None
            }
        except ValueError:
            return {}

    def _name(self, typed: str | None) -> str | None:
        if typed is None:
            return ""
        return dict(zip(self.planes, "AB", strict=True)).get(typed.strip())


def _number(text: str) -> float:
    """Return a number written with a point or a comma."""
    return float(text.strip().replace(",", "."))


@dataclass
class Settling:
    """Last readings of each plane, settled when all are near their mean.

    Attributes
    ----------
    count : int
        Readings that must agree.
    share : float
        Largest distance of a reading from the mean, over its magnitude.
    least_g_mm : float
        Lower bound of that distance.
    """

    count: int
    share: float
    least_g_mm: float
    last: dict[str, deque[complex]] = field(default_factory=dict)

    def add(self, plane: str, vector: complex) -> None:
        self.last.setdefault(plane, deque(maxlen=self.count)).append(vector)

    @property
    def settled(self) -> dict[str, complex] | None:
        """Means by plane once every plane has settled, else None; one plane of two is not enough."""
        planes = self.last
        if not planes or (len(planes) == 1 and "" not in planes):
            return None
        means = {name: sum(each) / len(each) for name, each in planes.items()}
        for name, each in planes.items():
            near = max(self.share * abs(means[name]), self.least_g_mm)
            if len(each) < self.count or max(abs(one - means[name]) for one in each) > near:
                return None
        return dict(sorted(means.items()))


# ``[machine.line]`` of a machine file: the lines that a machine writes, as a pattern with named groups.


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
