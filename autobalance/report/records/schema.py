"""From the typed records of a report to its JSON Schema: one place says what a report holds.

A record is a ``TypedDict``; a bound, a pattern or a sentence of explanation stands in ``Annotated``. Every
record becomes an entry of ``$defs``, named in snake case, and allows no other keys unless it is marked
``open_keys``.
"""

from __future__ import annotations

import re
import types
from collections.abc import Mapping
from dataclasses import dataclass
from typing import (
    Annotated,
    Any,
    Literal,
    NotRequired,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    is_typeddict,
)

Values = dict[str, Any]

NAMES: Mapping[Any, str] = {
    float: "number",
    int: "integer",
    str: "string",
    bool: "boolean",
    type(None): "null",
}


@dataclass(frozen=True)
class Bound:
    """A keyword of JSON Schema and its value: ``Bound("minimum", 0)``."""

    keyword: str
    value: Any


NotNegative = Annotated[float, Bound("minimum", 0)]
Positive = Annotated[float, Bound("exclusiveMinimum", 0)]
Count = Annotated[int, Bound("minimum", 0)]
Ordinal = Annotated[int, Bound("minimum", 1)]
Angle = Annotated[float, Bound("minimum", 0), Bound("exclusiveMaximum", 360)]
Share = Annotated[float, Bound("minimum", 0), Bound("maximum", 1)]
Pair = Annotated[list[float], Bound("minItems", 2), Bound("maxItems", 2)]
Triple = Annotated[list[float], Bound("minItems", 3), Bound("maxItems", 3)]
Sha256 = Annotated[str, Bound("pattern", "^[0-9a-f]{64}$")]


def open_keys(record: type) -> type:
    """Mark a record that may hold keys that it does not name."""
    record.open_keys = True  # type: ignore[attr-defined]
    return record


def schema_of(record: type, head: Mapping[str, Any], rules: list[Values]) -> Values:
    """Return the JSON Schema (draft 2020-12) of a report.

    Parameters
    ----------
    record : type
        A ``TypedDict``.
    head : mapping
        ``$schema``, ``$id``, ``title`` and the like.
    rules : list of dict
        What depends on the values themselves: the schema's ``allOf``.
    """
    found: dict[str, Values] = {}
    whole = _object(record, found)
    return {**head, **whole, **({"allOf": rules} if rules else {}), "$defs": dict(sorted(found.items()))}


def _object(record: type, found: dict[str, Values]) -> Values:
    hints = get_type_hints(record, include_extras=True)
    properties = {name: _schema(hint, found) for name, hint in hints.items()}
    required = [name for name in hints if name in record.__required_keys__]  # type: ignore[attr-defined]
    return {
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": getattr(record, "open_keys", False),
    }


def _schema(hint: Any, found: dict[str, Values]) -> Values:  # noqa: PLR0911 - one return a form
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is NotRequired:
        return _schema(arguments[0], found)
    if origin is Annotated:
        return _schema(arguments[0], found) | _extras(arguments[1:])
    if origin in (Union, types.UnionType):
        return _one_of([_schema(each, found) for each in arguments])
    if origin is Literal:
        return {"const": arguments[0]} if len(arguments) == 1 else {"enum": list(arguments)}
    if origin is list:
        return {"type": "array", "items": _schema(arguments[0], found)}
    if origin is dict:
        items = _schema(arguments[1], found)
        return {"type": "object", **({"additionalProperties": items} if items else {})}
    if is_typeddict(hint):
        name = re.sub(r"(?<!^)(?=[A-Z])", "_", hint.__name__).lower()
        if name not in found:
            found[name] = {}  # a record may hold its own kind
            found[name] = _object(hint, found)
        return {"$ref": f"#/$defs/{name}"}
    return {} if hint is Any or hint is object else {"type": NAMES[hint]}


def _extras(extras: tuple[Any, ...]) -> Values:
    bounds = {each.keyword: each.value for each in extras if isinstance(each, Bound)}
    words = [each for each in extras if isinstance(each, str)]
    return bounds | ({"description": words[0]} if words else {})


def _one_of(found: list[Values]) -> Values:
    """Return what allows any of these; a value or null keeps its bounds beside a list of types."""
    null = {"type": "null"}
    others = [each for each in found if each != null]
    if len(others) == 1 and null in found:
        only = others[0]
        if "enum" in only:
            return only | {"enum": [*only["enum"], None]}
        if isinstance(only.get("type"), str) and only["type"] != "object":
            return only | {"type": [only["type"], "null"]}
    if all(set(each) == {"type"} for each in found):
        return {"type": [each["type"] for each in found]}
    return {"anyOf": found}
