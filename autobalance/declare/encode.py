"""From a result to JSON values and back: records, arrays and tables become what ``json`` writes."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING
from functools import cache
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

import numpy as np

from autobalance.declare.fields import ABSENT, Absent, Field, bare, fields_of
from autobalance.declare.units import Unit, converted

Values = dict[str, Any]
T = TypeVar("T")


def encoded(result: Any) -> Any:
    """Return a record, or any part of one, as JSON values.

    Parameters
    ----------
    result : record, mapping, sequence, array, number, text or None
        Records become tables, with their fields in order, each in the unit of its annotation.

    Examples
    --------
    >>> import numpy as np
    >>> from autobalance.rigid_rotor.grade import Grade
    >>> encoded({"grades": (Grade(6.3, "general machinery"),), "unbalance_g_mm": np.array([0.0, 2.0])})
    {'grades': [{'grade_mm_s': 6.3, 'what': 'general machinery'}], 'unbalance_g_mm': [0.0, 2.0]}
    """
    if hasattr(result, "tolist"):  # an array, or one number of numpy's
        return result.tolist()
    if result is None or isinstance(result, str | int | float):
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
        value = getattr(result, each.name)
        if value is ABSENT or (each.omitted and value is None):
            continue
        if each.inline:
            table |= {} if value is None else encoded(value)
        else:
            table[each.key] = encoded(value if each.unit is None else converted(value, each.unit.written))
    return table


def decoded(of: type[T], value: Any) -> T:
    """Return a record from what a report has of it: the inverse of ``encoded``.

    Sequences become tuples. A derived value is the stored one, or derived again if it is missing. A record
    computed from values that no report has lacks them.

    Raises
    ------
    ValueError
        If a key is missing or of another type; the message begins with its place, as ``.planes[2].g_mm``.
    """
    result: T = _decoded(of, value, None)
    return result


def _decoded(of: Any, value: Any, unit: Unit | None) -> Any:  # noqa: PLR0911 - one return a form
    origin, inner = get_origin(of), get_args(of)
    if origin is Annotated:
        return _decoded(inner[0], value, next((mark for mark in inner[1:] if isinstance(mark, Unit)), unit))
    if dataclasses.is_dataclass(of):
        return _decoded_table(of, value)
    if origin in (Union, UnionType):
        arms = [each for each in inner if each is not Absent]
        return None if value is None and type(None) in arms else _first_fitting(arms, value, unit)
    if origin in (tuple, list, Sequence):
        if not isinstance(value, list):
            raise ValueError(f" is {value!r}; expected a list")
        each_of = inner if origin is tuple and inner[-1] is not Ellipsis else inner[:1] * len(value)
        if len(each_of) != len(value):
            raise ValueError(f" has {len(value)} entries; expected {len(each_of)}")
        pairs = enumerate(zip(each_of, value, strict=True), 1)
        return tuple(_at(f"[{place}]", one, each, unit) for place, (one, each) in pairs)
    if origin is np.ndarray:
        array: Any = np.asarray(_decoded(Sequence[Any], value, None), float)
        return array if unit is None else unit.read(array)
    if origin is Literal:
        if value not in inner:
            raise ValueError(f" is {value!r}; expected one of {', '.join(map(str, inner))}")
        return value
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


def _first_fitting(arms: Sequence[Any], value: Any, unit: Unit | None) -> Any:
    refused = []
    for each in arms:
        try:
            return _decoded(each, value, unit)
        except ValueError as error:
            refused.append(error)
    raise refused[0]


def _decoded_table(of: Any, value: Any) -> Any:
    if not isinstance(value, Mapping):
        raise ValueError(f" is {value!r}; expected a table")
    arguments: Values = {}
    derived: Values = {}
    for each in fields_of(of):
        if each.inline:
            arguments[each.name] = _decoded_inline(of, each, value)
        elif each.key in value:
            found = _at(f".{each.key}", each.hint, value[each.key], each.unit)
            (derived if each.derived else arguments)[each.name] = found
        elif each.required and not (each.derived and _is_whole(of)):
            raise ValueError(f".{each.key} is missing")
        elif not each.derived:
            arguments[each.name] = None if each.omitted else ABSENT
    if _is_whole(of):
        made = of(**arguments)
    else:
        made = object.__new__(of)
        vars(made).update(arguments)
    vars(made).update(derived)
    return made


@cache
def _is_whole(of: Any) -> bool:
    """Return whether all that a record is made of is written: then what is derived can be derived again."""
    written = {each.name for each in fields_of(of)}
    return all(
        each.name in written or each.default is not MISSING or each.default_factory is not MISSING
        for each in dataclasses.fields(of)
    )


def _decoded_inline(of: Any, field: Field, value: Mapping[str, Any]) -> Any:
    """Return a record whose keys are among another's, or a mapping of the keys that no field has."""
    if field.registered is not None:
        types = field.registered()
        return {key: _at(f".{key}", hint, value[key], None) for key, hint in types.items() if key in value}
    record = _record_in(field.hint)
    if record is None:
        return {key: each for key, each in value.items() if key not in set(_keys(of))}
    there = any(key in value for key in _keys(record))
    return _decoded_table(record, value) if there or type(None) not in get_args(bare(field.hint)) else None


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


def _at(place: str, of: Any, value: Any, unit: Unit | None) -> Any:
    try:
        return _decoded(of, value, unit)
    except ValueError as error:
        raise ValueError(f"{place}{error}") from None
