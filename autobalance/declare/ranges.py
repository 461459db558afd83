"""Units of fields by the endings of their names, and ranges, sizes and patterns of values."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, Final

from autobalance.units import (
    BAR_PER_MPA,
    G_MM2_PER_KG_MM2,
    G_PER_MM3_PER_KG_M3,
    M_PER_MM,
    N_M_PER_N_MM,
    RAD_S_PER_RPM,
)
from autobalance.value_classes import dataclass

# Ranges of numbers, sizes of lists and patterns of texts, for readers, schemas and messages.


MIN_POSITIVE = 1e-9
"""Smallest positive number where one is needed: dividing by less overflows."""


@dataclass(frozen=True)
class TypedIn:
    """Optional unit of a typed number, where the name of its key does not end in one."""

    unit: str


@dataclass(frozen=True)
class Size:
    """Smallest and largest number of entries of a list."""

    least: int = 0
    most: int | None = None

    def schema(self) -> dict[str, Any]:
        """Return the size as keywords of JSON Schema."""
        least = {"minItems": self.least} if self.least else {}
        return least if self.most is None else {**least, "maxItems": self.most}


@dataclass(frozen=True)
class Pattern:
    """Regular expression that a text follows, and its smallest length."""

    expression: str = ""
    least: int = 0

    def schema(self) -> dict[str, Any]:
        """Return them as keywords of JSON Schema."""
        pattern = {"pattern": self.expression} if self.expression else {}
        return {**pattern, "minLength": self.least} if self.least else pattern


@dataclass(frozen=True)
class Range:
    """Range of a number.

    ``text`` names it in a message. ``least`` and ``most`` may be reached, ``above`` and ``below`` may not.
    The absolute value must be above ``apart``. ``besides`` are numbers that are permitted in any case, and
    ``one_of`` the only permitted ones, if there are few.
    """

    text: str = ""
    least: float | None = None
    most: float | None = None
    above: float | None = None
    below: float | None = None
    apart: float | None = None
    besides: tuple[float, ...] = ()
    one_of: tuple[float, ...] = ()

    def holds(self, number: float) -> bool:
        if self.one_of:
            return number in self.one_of
        within = (
            (self.least is None or number >= self.least)
            and (self.most is None or number <= self.most)
            and (self.above is None or number > self.above)
            and (self.below is None or number < self.below)
            and (self.apart is None or abs(number) > self.apart)
        )
        return within or number in self.besides

    def schema(self) -> dict[str, Any]:
        """Return the range as keywords of JSON Schema."""
        if self.one_of:
            return {"enum": list(self.one_of)}
        named = {
            "minimum": self.least,
            "maximum": self.most,
            "exclusiveMinimum": self.above,
            "exclusiveMaximum": self.below,
        }
        limits: dict[str, Any] = {word: value for word, value in named.items() if value is not None}
        if self.apart is not None:
            limits["anyOf"] = [{"exclusiveMinimum": self.apart}, {"exclusiveMaximum": -self.apart}]
        if not self.besides:
            return limits
        return {"anyOf": [limits, {"enum": list(self.besides)}]}


ANY = Range()
POSITIVE = Range("must be > 0", above=0.0)
NOT_NEGATIVE = Range("must be ≥ 0", least=0.0)
SHARE = Range("must be 0 to 1", least=0.0, most=1.0)
COUNTED = Range("must be ≥ 1", least=1)


# Units of fields and their keys: the endings of both names, and the way from one unit to the other.


@dataclass(frozen=True)
class Unit:
    """Unit outside of a field whose name ends in another: outside = inside · ``times`` / ``over``.

    Two numbers, because one of them is exact: 0.3 MPa is 3.0 bar as 0.3 · 10, and not as 0.3 / 0.1.
    """

    inside: str
    outside: str
    times: float = 1.0
    over: float = 1.0

    def key(self, name: str) -> str:
        """Return the key of a field.

        Raises
        ------
        TypeError
            If the field's name does not end in its unit.
        """
        if not name.endswith(self.inside):
            raise TypeError(f"{name}: a field whose key ends in {self.outside} must end in {self.inside}")
        return name.removesuffix(self.inside) + self.outside

    def written(self, number: float) -> float:
        """Return a number of the field's unit in the key's: of those that are read as it, one that was typed.

        Examples
        --------
        >>> RPM.read(3000.0) / RAD_S_PER_RPM, RPM.written(RPM.read(3000.0))
        (3000.0000000000005, 3000.0)
        """
        written = number * self.times / self.over
        typed = float(f"{written:.15g}")
        return typed if self.read(typed) == number else written

    def read(self, number: float) -> float:
        """Return a number of the key's unit in the field's."""
        return number * self.over / self.times


def converted(value: Any, convert: Callable[[float], float]) -> Any:
    """Return a number, or each number of a sequence or an array as a tuple, in another unit.

    Other values than numbers are returned unchanged.
    """
    if type(value) is float:
        return convert(value)
    if isinstance(value, list | tuple) or getattr(value, "ndim", None):
        return tuple(converted(each, convert) for each in value)
    return value if value is None or isinstance(value, str | bool) else convert(float(value))


DEGREES: Final = Unit("_rad", "_deg", times=180.0 / math.pi)
MRAD: Final = Unit("_rad", "_mrad", times=1e3)
RPM: Final = Unit("_rad_s", "_rpm", over=RAD_S_PER_RPM)
HERTZ: Final = Unit("_rad_s", "_hz", over=2.0 * math.pi)
KG_MM2: Final = Unit("_g_mm2", "_kg_mm2", over=G_MM2_PER_KG_MM2)
BAR: Final = Unit("_mpa", "_bar", times=BAR_PER_MPA)
MPA: Final = Unit("_pa", "_MPa", over=1e6)
GPA: Final = Unit("_pa", "_gpa", over=1e9)
JOULES: Final = Unit("_n_mm", "_J", times=N_M_PER_N_MM)
NEWTONS: Final = Unit("_n", "_N")
NEWTON_METRES: Final = Unit("_n_m", "_N_m")
MM: Final = Unit("_m", "_mm", over=M_PER_MM)
UM: Final = Unit("_m", "_um", times=1e6)
MM3_S: Final = Unit("_m3_s", "_mm3_s", times=1e9)
G_MM: Final = Unit("_kg_m", "_g_mm", times=1e6)
KG_MM2_OF_SI: Final = Unit("_kg_m2", "_kg_mm2", times=1e6)
KG_M3: Final = Unit("_g_mm3", "_kg_m3", over=G_PER_MM3_PER_KG_M3)
PERCENT: Final = Unit("", "_percent", times=100.0)
"""Unit of a share, whose name ends in no unit."""

Degrees = Annotated[float, DEGREES]
Mm = Annotated[float, MM]
Um = Annotated[float, UM]
Mrad = Annotated[float, MRAD]
Rpm = Annotated[float, RPM]
Hertz = Annotated[float, HERTZ]
KgMm2 = Annotated[float, KG_MM2]
Bar = Annotated[float, BAR]
Mpa = Annotated[float, MPA]
Joules = Annotated[float, JOULES]
Newtons = Annotated[float, NEWTONS]
NewtonMetres = Annotated[float, NEWTON_METRES]

UNIT_BY_ENDING = {
    "_kg_mm2": "kg·mm²",
    "_kg_m3": "kg/m³",
    "_J_kg_K": "J/(kg·K)",
    "_J_K": "J/K",
    "_W_K": "W/K",
    "_mm2_s": "mm²/s",
    "_mm3_s": "mm³/s",
    "_N_m_s_rad": "N·m·s/rad",
    "_N_m_rad": "N·m/rad",
    "_N_um": "N/µm",
    "_k_N_mm": "N/mm",  # of a spring
    "_N_mm": "N·mm",
    "_N_m": "N·m",
    "_n_mm": "N/mm",
    "_n_s_m": "N·s/m",
    "_n_m": "N/m",
    "_m_s2": "m/s²",
    "_Pa_s": "Pa·s",
    "_per_K": "1/K",
    "_cm3": "cm³",
    "_g_mm": "g·mm",
    "_oz_in": "oz·in",
    "_percent": "%",
    "_kg_mm": "kg·mm",
    "_rpm": "1/min",
    "_deg": "°",
    "_bar": "bar",
    "_gpa": "GPa",
    "_MPa": "MPa",
    "_um": "µm",
    "_mm": "mm",
    "_kg": "kg",
    "_oz": "oz",
    "_lb": "lb",
    "_hz": "Hz",
    "_g": "g",
    "_J": "J",
    "_K": "K",
    "_C": "°C",
    "_N": "N",
    "_s": "s",
}
"""Unit of a key's numbers, by the ending of its name; the first that fits."""


def unit_of_name(name: str) -> str:
    """Return the unit that a key's name ends in; empty: none.

    Examples
    --------
    >>> unit_of_name("pm_g_mm"), unit_of_name("flywheel_kg_mm2"), unit_of_name("g"), unit_of_name("order")
    ('g·mm', 'kg·mm²', 'g', '')
    """
    whole = f"_{name}"
    return next((unit for ending, unit in UNIT_BY_ENDING.items() if whole.endswith(ending)), "")
