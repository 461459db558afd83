"""Fields of results, and their way to JSON values and back."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING
from enum import Enum
from functools import cache
from types import UnionType
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Final,
    Literal,
    NamedTuple,
    TypeVar,
    Union,
    dataclass_transform,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np

from autobalance.declare.ranges import (
    COUNTED,
    NOT_NEGATIVE,
    POSITIVE,
    SHARE,
    Pattern,
    Range,
    Size,
    Unit,
    converted,
)
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Fields of results: what ``typing.Annotated`` declares of a dataclass's fields, and their writing.


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


# From a result to JSON values and back: records, arrays and tables become what ``json`` writes.


Values = dict[str, Any]
_PLAIN = frozenset({float, int, str, bool, type(None)})


def encoded(result: Any) -> Any:
    """Return a record, or any part of one, as JSON values.

    Parameters
    ----------
    result : record, mapping, sequence, array, number, text or None
        Records become tables, with their fields in order, each in the unit of its annotation.

    Examples
    --------
    >>> import numpy as np
    >>> from autobalance.rigid_rotor.tolerance import Grade
    >>> encoded({"grades": (Grade(6.3, "general machinery"),), "unbalance_g_mm": np.array([0.0, 2.0])})
    {'grades': [{'grade_mm_s': 6.3, 'what': 'general machinery'}], 'unbalance_g_mm': [0.0, 2.0]}
    """
    if type(result) in _PLAIN:  # nearly all that there are: of a cycle's report 100 000 numbers
        return result
    if hasattr(result, "tolist"):  # an array, or one number of numpy's
        return result.tolist()
    if isinstance(result, str | int | float):
        return result
    if dataclasses.is_dataclass(result):
        return _table(result)
    if isinstance(result, Mapping):
        return {key: encoded(value) for key, value in result.items()}
    if isinstance(result, list | tuple):
        return [encoded(each) for each in result]
    raise TypeError(f"{type(result).__name__} has no place in a report")


def _table(result: Any) -> Values:
    table: Values = {}
    of: type = type(result)
    for each in fields_of(of):
        value = getattr(result, each.name, ABSENT)  # what was read partly may lack it
        if value is ABSENT or (each.omitted and value is None):
            continue
        if each.inline:
            table |= {} if value is None else encoded(value)
        else:
            table[each.key] = encoded(value if each.unit is None else converted(value, each.unit.written))
    return table


def decoded(of: type[T], value: Any, partly: bool = False) -> T:
    """Return a record from what a report has of it: the inverse of ``encoded``.

    Sequences become tuples. A derived value is the stored one, or derived again if it is missing. A record
    computed from values that no report has lacks them. Read ``partly``, as from a report of an earlier
    version, it also lacks what is missing there, or has its default: reading such a field is an
    AttributeError.

    Raises
    ------
    ValueError
        If a key is missing or of another type; the message begins with its place, as ``.planes[2].g_mm``.
    """
    result: T = _decoded(of, value, None, partly)
    return result


def _decoded(of: Any, value: Any, unit: Unit | None, partly: bool) -> Any:  # noqa: PLR0911 - one return a form
    origin, inner = get_origin(of), get_args(of)
    if origin is Annotated:
        own = next((mark for mark in inner[1:] if isinstance(mark, Unit)), unit)
        return _decoded(inner[0], value, own, partly)
    if dataclasses.is_dataclass(of):
        return _decoded_table(of, value, partly)
    if origin in (Union, UnionType):
        arms = [each for each in inner if each is not Absent]
        return None if value is None and type(None) in arms else _first_fitting(arms, value, unit, partly)
    if origin in (tuple, list, Sequence):
        if not isinstance(value, list):
            raise ValueError(f" is {value!r}; expected a list")
        each_of = inner if origin is tuple and inner[-1] is not Ellipsis else inner[:1] * len(value)
        if len(each_of) != len(value):
            raise ValueError(f" has {len(value)} entries; expected {len(each_of)}")
        pairs = enumerate(zip(each_of, value, strict=True), 1)
        return tuple(_at(f"[{place}]", one, each, unit, partly) for place, (one, each) in pairs)
    if origin is np.ndarray:
        array: Any = np.asarray(_decoded(Sequence[Any], value, None, partly), float)
        return array if unit is None else unit.read(array)
    if origin is Literal:
        if value not in inner:
            raise ValueError(f" is {value!r}; expected one of {', '.join(map(str, inner))}")
        return value
    if origin in (dict, Mapping) and isinstance(value, Mapping):
        return {key: _at(f".{key}", inner[1], each, unit, partly) for key, each in value.items()}
    if of is Any or of is object:
        return value
    return _plain(of if origin is None else origin, value, unit)


def _plain(of: Any, value: Any, unit: Unit | None) -> Any:
    """Return a number, text or table; what is neither of its type nor of JSON is refused."""
    if of is float and isinstance(value, int | float) and not isinstance(value, bool):
        return float(value) if unit is None else unit.read(float(value))
    wanted: Any = {Mapping: dict}.get(of, of)
    if wanted is float or not isinstance(wanted, type) or not isinstance(value, wanted):
        raise ValueError(f" is {value!r}; expected {getattr(of, '__name__', of)}")
    if isinstance(value, bool) and wanted is not bool:
        raise ValueError(f" is {value!r}; expected {wanted.__name__}")
    return value


def _first_fitting(arms: Sequence[Any], value: Any, unit: Unit | None, partly: bool) -> Any:
    refused = []
    for each in arms:
        try:
            return _decoded(each, value, unit, partly)
        except ValueError as error:
            refused.append(error)
    raise refused[0]


def _decoded_table(of: Any, value: Any, partly: bool) -> Any:
    if not isinstance(value, Mapping):
        raise ValueError(f" is {value!r}; expected a table")
    arguments: Values = {}
    derived: Values = {}
    for each in fields_of(of):
        if each.inline:
            arguments[each.name] = _decoded_inline(of, each, value, partly)
        elif each.key in value:
            found = _at(f".{each.key}", each.hint, value[each.key], each.unit, partly)
            (derived if each.derived else arguments)[each.name] = found
        elif partly:
            continue
        elif each.required and not (each.derived and _is_whole(of)):
            raise ValueError(f".{each.key} is missing")
        elif not each.derived:
            arguments[each.name] = None if each.omitted else ABSENT
    if _is_whole(of) and not partly:
        made = of(**arguments)
    else:
        made = object.__new__(of)
        vars(made).update(_made_defaults(of) | arguments)
    vars(made).update(derived)
    return made


def _made_defaults(of: Any) -> Values:
    """Return the defaults that each record makes for itself; plain defaults are attributes of its class."""
    factories = ((each.name, each.default_factory) for each in dataclasses.fields(of))
    return {name: make() for name, make in factories if make is not MISSING}


def changed(of: T, **values: Any) -> T:
    """Return a record with other values; what one that was read partly lacks, it lacks too."""
    made = copy.copy(of)
    vars(made).update(values)
    return made


@cache
def _is_whole(of: Any) -> bool:
    """Return whether all that a record is made of is written: then what is derived can be derived again."""
    written = {each.name for each in fields_of(of)}
    return all(
        each.name in written or each.default is not MISSING or each.default_factory is not MISSING
        for each in dataclasses.fields(of)
    )


def _decoded_inline(of: Any, field: Field, value: Mapping[str, Any], partly: bool) -> Any:
    """Return a record whose keys are among another's, or a mapping of the keys that no field has."""
    if field.registered is not None:
        types = field.registered()
        found = {key: hint for key, hint in types.items() if key in value}
        return {key: _at(f".{key}", hint, value[key], None, partly) for key, hint in found.items()}
    record = _record_in(field.hint)
    if record is None:
        return {key: each for key, each in value.items() if key not in set(_keys(of))}
    there = any(key in value for key in _keys(record))
    is_optional = type(None) in get_args(bare(field.hint))
    return None if is_optional and not there else _decoded_table(record, value, partly)


def _record_in(hint: Any) -> Any:
    """Return the record of a type, or of its union; None if it is not a record."""
    arms = get_args(bare(hint)) or (bare(hint),)
    return next((each for each in arms if dataclasses.is_dataclass(each)), None)


def _keys(of: Any) -> Iterator[str]:
    for each in fields_of(of):
        inner = _record_in(each.hint) if each.inline else None
        if not each.inline:
            yield each.key
        elif each.registered is not None:
            yield from each.registered()
        elif inner is not None:
            yield from _keys(inner)


def _at(place: str, of: Any, value: Any, unit: Unit | None, partly: bool) -> Any:
    try:
        return _decoded(of, value, unit, partly)
    except ValueError as error:
        raise ValueError(f"{place}{error}") from None
