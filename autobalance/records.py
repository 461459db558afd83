"""Records: frozen dataclasses whose fields declare how they are written and which values they may hold.

A field's name ends in its unit, and is the key that a report has for it. ``typing.Annotated`` holds the rest:
bounds of a number, a sentence of explanation, another unit outside (``Degrees``: ``angle_rad`` is written as
``angle_deg``). Whatever writes, describes or checks results reads this and nothing else, so that a new key is
one new field.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from types import UnionType
from typing import (
    Annotated,
    Any,
    Final,
    NamedTuple,
    TypeVar,
    Union,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

from autobalance.types import Array
from autobalance.units import BAR_PER_MPA, N_M_PER_N_MM, RAD_S_PER_RPM

T = TypeVar("T")
G_MM2_PER_KG_MM2 = 1e3
MRAD_PER_RAD = 1e3
PA_PER_MPA = 1e6


class Absent(Enum):
    """Mark of a key that a report lacks this time; ``None`` is a key with the value null."""

    ABSENT = "absent"


ABSENT: Final = Absent.ABSENT


@dataclass_transform(kw_only_default=True, frozen_default=True)
def record(of: type[T]) -> type[T]:
    """Make a class a record: frozen, its fields by keyword; compared by identity, for it may hold arrays."""
    return dataclass(frozen=True, eq=False, kw_only=True)(of)


@dataclass(frozen=True)
class Bound:
    """Bound on a value: a keyword of JSON Schema and its value, ``Bound("minimum", 0)``."""

    keyword: str
    value: Any


@dataclass(frozen=True)
class Written:
    """Another unit outside: the ending of a field's name, the ending of its key, and the conversion."""

    unit: str
    key_unit: str
    convert: Callable[[float], float]

    def key(self, name: str) -> str:
        """Return the key of a field: its name with the key's unit."""
        if not name.endswith(self.unit):
            raise TypeError(f"{name}: a field that is written in {self.key_unit} must end in {self.unit}")
        return name.removesuffix(self.unit) + self.key_unit


@dataclass(frozen=True)
class Key:
    """Key of a field whose name is a reserved word in Python: ``from``, ``with``."""

    name: str


@dataclass(frozen=True)
class Like:
    """Mark of a table that comes from elsewhere, as from a file: the record with the same keys."""

    record: Any


@dataclass(frozen=True)
class _Marker:
    name: str


INLINE: Final = _Marker("inline")
"""Mark of a record or mapping in a record: its keys stand among the others, none where it is None."""

NotNegative = Annotated[float, Bound("minimum", 0)]
Positive = Annotated[float, Bound("exclusiveMinimum", 0)]
Count = Annotated[int, Bound("minimum", 0)]
Ordinal = Annotated[int, Bound("minimum", 1)]
Angle = Annotated[float, Bound("minimum", 0), Bound("exclusiveMaximum", 360)]
Share = Annotated[float, Bound("minimum", 0), Bound("maximum", 1)]
Floats = Sequence[float] | Array
Pair = Annotated[Floats, Bound("minItems", 2), Bound("maxItems", 2)]
Triple = Annotated[Floats, Bound("minItems", 3), Bound("maxItems", 3)]
Matrix2 = Annotated[Sequence[Pair] | Array, Bound("minItems", 2), Bound("maxItems", 2)]
Matrix3 = Annotated[Sequence[Triple] | Array, Bound("minItems", 3), Bound("maxItems", 3)]
Sha256 = Annotated[str, Bound("pattern", "^[0-9a-f]{64}$")]

DEGREES: Final = Written("_rad", "_deg", math.degrees)
RPM: Final = Written("_rad_s", "_rpm", lambda speed: speed / RAD_S_PER_RPM)
KG_MM2: Final = Written("_g_mm2", "_kg_mm2", lambda inertia: inertia / G_MM2_PER_KG_MM2)
BAR: Final = Written("_mpa", "_bar", lambda pressure: pressure * BAR_PER_MPA)
JOULES: Final = Written("_n_mm", "_J", lambda work: work * N_M_PER_N_MM)
NEWTONS: Final = Written("_n", "_N", float)
NEWTON_METRES: Final = Written("_n_m", "_N_m", float)
HERTZ: Final = Written("_rad_s", "_hz", lambda frequency: frequency / (2.0 * math.pi))
MRAD: Final = Written("_rad", "_mrad", lambda angle: MRAD_PER_RAD * angle)
MPA: Final = Written("_pa", "_MPa", lambda stress: stress / PA_PER_MPA)

Degrees = Annotated[float, DEGREES]
Rpm = Annotated[float, RPM]
KgMm2 = Annotated[float, KG_MM2]
Bar = Annotated[float, BAR]
Joules = Annotated[float, JOULES]
Newtons = Annotated[float, NEWTONS]
NewtonMetres = Annotated[float, NEWTON_METRES]

_SEVERAL = (Union, UnionType, list, tuple, Sequence)


class Field(NamedTuple):
    """Field of a record as it is written."""

    name: str
    key: str
    hint: Any
    convert: Callable[[float], float] | None
    inline: bool
    required: bool


@cache
def fields_of(of: type) -> tuple[Field, ...]:
    """Return the fields of a record that are written, in their order."""
    hints = get_type_hints(of, include_extras=True)
    return tuple(_field(each, hints[each.name]) for each in dataclasses.fields(of))


def _field(field: dataclasses.Field[Any], hint: Any) -> Field:
    marks = list(_marks(hint))
    units = [each for each in marks if isinstance(each, Written)]
    keys = [each.name for each in marks if isinstance(each, Key)]
    key = units[0].key(field.name) if units else field.name
    convert = units[0].convert if units else None
    return Field(
        field.name,
        keys[0] if keys else key,
        hint,
        convert,
        INLINE in marks,
        Absent not in get_args(get_args(hint)[0] if get_origin(hint) is Annotated else hint),
    )


def _marks(hint: Any) -> list[Any]:
    """Return a field's ``Annotated`` marks, inside of unions and sequences too."""
    if get_origin(hint) is Annotated:
        inner, *marks = get_args(hint)
        return [*marks, *_marks(inner)]
    if get_origin(hint) in _SEVERAL:
        return [mark for each in get_args(hint) for mark in _marks(each)]
    return []
