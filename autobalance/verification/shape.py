"""Whether a report is shaped as reports are: every key there, of its type, within its bounds.

A JSON Schema says how. Of draft 2020-12 this knows what the schemas in this package use, but for ``allOf``:
rules among values are checked with the values. Keys that a schema does not name are no fault here, they end
up among what was not checked.
"""

from __future__ import annotations

import re
import reprlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from autobalance.errors import FormatError

Schema = Mapping[str, Any]

TYPES: Mapping[str, Callable[[Any], bool]] = {
    "object": lambda value: isinstance(value, Mapping),
    "array": lambda value: isinstance(value, list),
    "string": lambda value: isinstance(value, str),
    "boolean": lambda value: isinstance(value, bool),
    "null": lambda value: value is None,
    "number": lambda value: isinstance(value, int | float) and not isinstance(value, bool),
    "integer": lambda value: isinstance(value, int) and not isinstance(value, bool),
}
BOUNDS: Mapping[str, tuple[Callable[[Any, Any], bool], str]] = {
    "minimum": (lambda value, bound: value >= bound, "at least {}"),
    "maximum": (lambda value, bound: value <= bound, "at most {}"),
    "exclusiveMinimum": (lambda value, bound: value > bound, "more than {}"),
    "exclusiveMaximum": (lambda value, bound: value < bound, "less than {}"),
    "minItems": (lambda value, bound: len(value) >= bound, "{} entries at least"),
    "maxItems": (lambda value, bound: len(value) <= bound, "{} entries at most"),
    "minLength": (lambda value, bound: len(value) >= bound, "{} letters at least"),
    "pattern": (lambda value, bound: re.search(bound, value) is not None, "text like {}"),
    "enum": (lambda value, allowed: value in allowed, "one of {}"),
    "const": (lambda value, wanted: value == wanted and type(value) is type(wanted), "{}"),
}


@dataclass(frozen=True)
class Fault:
    """A value that is not as its schema wants it; ``found`` is None where it is missing."""

    place: str
    found: str | None
    needed: str


def refuse_shape(name: str, values: Mapping[str, Any], schema: Schema) -> None:
    """Refuse a report that is not shaped as its schema says.

    Parameters
    ----------
    name : str
        Of the report, for the message.
    values : mapping
        Its JSON.
    schema : mapping
        JSON Schema.

    Raises
    ------
    FormatError
        At the first fault.
    """
    for fault in _faults("", values, schema, schema):
        if fault.found is None:
            raise FormatError(f"{name}: {fault.place} is missing; is this a report of autobalance balance?")
        raise FormatError(f"{name}: {fault.place} is {fault.found}; needed {fault.needed}")


def _faults(place: str, value: Any, schema: Schema, whole: Schema) -> Iterator[Fault]:
    """Yield what is wrong with a value, outermost first."""
    if "$ref" in schema:
        yield from _faults(place, value, whole["$defs"][schema["$ref"].rsplit("/", 1)[1]], whole)
    wanted = schema.get("type", ())
    types = [wanted] if isinstance(wanted, str) else list(wanted)
    if types and not any(TYPES[each](value) for each in types):
        yield Fault(place, f"of the wrong type: {reprlib.repr(value)}", " or ".join(types))
        return
    if value is not None or not types:
        yield from _out_of_bounds(place, value, schema)
    if "anyOf" in schema:
        yield from _of_none(place, value, schema["anyOf"], whole)
    if isinstance(value, Mapping):
        yield from _within_object(place, value, schema, whole)
    elif isinstance(value, list) and "items" in schema:
        for number, each in enumerate(value, 1):
            yield from _faults(f"{place}[{number}]", each, schema["items"], whole)


def _out_of_bounds(place: str, value: Any, schema: Schema) -> Iterator[Fault]:
    for key, (holds, words) in BOUNDS.items():
        if key in schema and not holds(value, schema[key]):
            listed = schema[key] if isinstance(schema[key], list) else [schema[key]]
            yield Fault(place, reprlib.repr(value), words.format(", ".join(map(str, listed))))


def _of_none(place: str, value: Any, branches: list[Schema], whole: Schema) -> Iterator[Fault]:
    """Yield the faults by the branch that is meant most likely: the first that is not for null."""
    if not any(not any(_faults(place, value, branch, whole)) for branch in branches):
        meant = next((branch for branch in branches if branch.get("type") != "null"), branches[0])
        yield from _faults(place, value, meant, whole)


def _within_object(place: str, value: Mapping[str, Any], schema: Schema, whole: Schema) -> Iterator[Fault]:
    inner = f"{place}." if place else ""
    for key in schema.get("required", ()):
        if key not in value:
            yield Fault(f"{inner}{key}", None, "")
    others = schema.get("additionalProperties")
    for key, each in value.items():
        rule = schema.get("properties", {}).get(key, others)
        if isinstance(rule, Mapping):
            yield from _faults(f"{inner}{key}", each, rule, whole)
