"""Fields of results: what ``typing.Annotated`` declares of a dataclass's fields, and their writing."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from types import UnionType
from typing import (
    TYPE_CHECKING,
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

from autobalance.declare.ranges import COUNTED, NOT_NEGATIVE, POSITIVE, SHARE, Pattern, Range, Size
from autobalance.declare.units import Unit
from autobalance.types import Array

T = TypeVar("T")


class Absent(Enum):
    """Mark of a key that a report lacks this time; ``None`` is a key with the value null."""

    ABSENT = "absent"


ABSENT: Final = Absent.ABSENT


def present(value: T | Absent | None) -> T | None:
    """Return a value, None where its key is absent."""
    return None if value is ABSENT else value


@dataclass_transform(kw_only_default=True, frozen_default=True)
def record(of: type[T]) -> type[T]:
    """Make a class a record: frozen, its fields by keyword; compared by identity, for it may hold arrays."""
    return dataclass(frozen=True, eq=False, kw_only=True)(of)


@dataclass(frozen=True)
class Named:
    """Key of a field that has another name, as where the key is a reserved word: ``from``, ``with``."""

    name: str


@dataclass(frozen=True)
class Like:
    """Mark of a table that comes from elsewhere, as from a file: the record with the same keys."""

    record: Any


@dataclass(frozen=True)
class Registered:
    """Mark of a mapping inline whose keys others register: their types by key, requested when needed."""

    types: Callable[[], Mapping[str, Any]]


@dataclass(frozen=True)
class _Marker:
    name: str


INLINE: Final = _Marker("inline")
"""Mark of a record or mapping in a record: its keys are among the others, none where it is None."""
OMITTED: Final = _Marker("omitted")
"""Mark of a field that has no key where it is None."""
UNWRITTEN: Final = _Marker("unwritten")
"""Mark of a field that no report has."""
LOOSE: Final = _Marker("loose")
"""Mark of a record whose keys its schema leaves open."""
LAST: Final = _Marker("last")
"""Mark of a field that is written behind what is derived."""

NotNegative = Annotated[float, NOT_NEGATIVE]
Positive = Annotated[float, POSITIVE]
StandardError = Annotated[float | None, NOT_NEGATIVE, OMITTED]
"""Standard error of a measured value; absent for a drawn crank."""
Count = Annotated[int, Range(least=0)]
Ordinal = Annotated[int, COUNTED]
Angle = Annotated[float, Range(least=0, below=360)]
Share = Annotated[float, SHARE]
Floats = Sequence[float] | Array
Pair = Annotated[Floats, Size(2, 2)]
Triple = Annotated[Floats, Size(3, 3)]
Matrix2 = Annotated[Sequence[Pair] | Array, Size(2, 2)]
Matrix3 = Annotated[Sequence[Triple] | Array, Size(3, 3)]
Sha256 = Annotated[str, Pattern("^[0-9a-f]{64}$")]

_SEVERAL = (Union, UnionType, list, tuple, Sequence)


class Field(NamedTuple):
    """Field of a record as it is written; ``unit`` is another outside, if there is one.

    ``registered`` are the types of keys that others register, of a mapping that is inline.
    """

    name: str
    key: str
    hint: Any
    unit: Unit | None
    inline: bool
    required: bool
    omitted: bool
    registered: Callable[[], Mapping[str, Any]] | None
    derived: bool = False


class _Derived(property):
    """Property of a record that is one of its keys; for a record that was read, the stored value."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, instance: Any, owner: type | None = None) -> Any:
        if instance is not None and self.name in vars(instance):
            return vars(instance)[self.name]
        return super().__get__(instance, owner)


if TYPE_CHECKING:
    derived = property
else:

    def derived(method: Callable[[Any], T]) -> property:
        """Make a method a property of its record that is written behind the fields."""
        return _Derived(method)


@cache
def fields_of(of: type) -> tuple[Field, ...]:
    """Return the fields of a record that are written, in their order; what is derived is behind them."""
    hints = get_type_hints(of, include_extras=True)
    fields = [_field(each.name, hints[each.name]) for each in dataclasses.fields(of)]
    found = {name: each for base in reversed(of.__mro__) for name, each in vars(base).items()}
    for name, each in found.items():
        if isinstance(each, _Derived):
            hint = get_type_hints(each.fget, include_extras=True)["return"]
            fields.append(_field(name, hint)._replace(derived=True))
    fields.sort(key=lambda each: LAST in marks_of(each.hint))
    return tuple(each for each in fields if UNWRITTEN not in marks_of(each.hint))


def _field(name: str, hint: Any) -> Field:
    marks = marks_of(hint)
    unit = next((each for each in marks if isinstance(each, Unit)), None)
    names = [each.name for each in marks if isinstance(each, Named)]
    key = names[0] if names else name if unit is None else unit.key(name)
    may_lack = OMITTED in marks or Absent in get_args(bare(hint))
    registered = next((each.types for each in marks if isinstance(each, Registered)), None)
    return Field(name, key, hint, unit, INLINE in marks, not may_lack, OMITTED in marks, registered)


def described(hint: Any, meaning: str) -> Any:
    """Return a type with its meaning, as ``Annotated`` has it."""
    annotated: Any = Annotated
    return annotated[(hint, meaning)]


def bare(hint: Any) -> Any:
    """Return a type without its ``Annotated`` marks."""
    return get_args(hint)[0] if get_origin(hint) is Annotated else hint


def marks_of(hint: Any) -> list[Any]:
    """Return the ``Annotated`` marks of a field's type, inside of unions and sequences too."""
    if get_origin(hint) is Annotated:
        inner, *marks = get_args(hint)
        return [*marks, *marks_of(inner)]
    if get_origin(hint) in _SEVERAL:
        return [mark for each in get_args(hint) for mark in marks_of(each)]
    return []
