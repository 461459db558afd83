"""From typed records to JSON Schema: one declaration of the content of a report.

A record is a frozen dataclass (``autobalance.declare``); a bound, a unit or a sentence of explanation is in
``Annotated``. Every record becomes an entry of ``$defs``, named in snake case, and allows no other keys
unless it is marked ``open_keys`` or holds a table among its own keys.
"""

from __future__ import annotations

import dataclasses
import re
import types
from collections.abc import Mapping, Sequence
from typing import (
    Annotated,
    Any,
    Literal,
    Union,
    cast,
    get_args,
    get_origin,
)

import numpy as np

from autobalance.declare.fields import (
    LOOSE,
    Absent,
    Field,
    Like,
    bare,
    fields_of,
)
from autobalance.declare.ranges import Pattern, Range, Size

Values = dict[str, Any]

NAMES: Mapping[Any, str] = {
    float: "number",
    int: "integer",
    str: "string",
    bool: "boolean",
    type(None): "null",
}


class Definitions(dict[str, Values]):
    """The schema of each record by its name, and whose name it is."""

    def __init__(self) -> None:
        super().__init__()
        self.records: dict[str, type] = {}

    def name_of(self, record: type) -> str:
        """Return the name of a record in a schema: that of its class, or its own.

        Raises
        ------
        TypeError
            If another record of this report has that name.
        """
        own = vars(record).get("schema_name", record.__name__)
        name = re.sub(r"(?<!^)(?=[A-Z])", "_", own).lower()
        if self.records.setdefault(name, record) is not record:
            raise TypeError(f"two records of a report are called {name}; rename one")
        return name


def open_keys(record: type) -> type:
    """Mark a record that may hold keys that it does not name."""
    record.open_keys = True  # type: ignore[attr-defined]
    return record


def schema_of(record: type, head: Mapping[str, Any], rules: list[Values]) -> Values:
    """Return the JSON Schema (draft 2020-12) of a report.

    Parameters
    ----------
    record : type
    head : mapping
        ``$schema``, ``$id``, ``title`` and the like.
    rules : list of dict
        What depends on the values themselves: the schema's ``allOf``.
    """
    definitions = Definitions()
    whole = _object(record, definitions)
    return {
        **head,
        **whole,
        **({"allOf": rules} if rules else {}),
        "$defs": dict(sorted(definitions.items())),
    }


def _object(record: type, definitions: Definitions) -> Values:
    properties, required, opened = _fields(fields_of(record), definitions)
    return {
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": opened or getattr(record, "open_keys", False),
    }


def _fields(fields: Sequence[Field], definitions: Definitions) -> tuple[Values, list[str], bool]:
    """Return the properties of a dataclass, those required, and whether there may be others."""
    properties: Values = {}
    required: list[str] = []
    opened = False
    for each in fields:
        if not each.inline:
            properties[each.key] = _schema(_hint_where_written(each), definitions)
            required += [each.key] if each.required else []
            continue
        if each.registered is not None:
            properties |= {key: _schema(hint, definitions) for key, hint in each.registered().items()}
            continue
        record = _record_in(each.hint)
        inner, inner_required, open_inside = (
            ({}, [], True) if record is None else _fields(fields_of(record), definitions)
        )
        properties |= inner
        required += [] if _may_lack(each.hint) else inner_required
        opened |= open_inside or getattr(record, "open_keys", False)
    return properties, required, opened


def _hint_where_written(field: Field) -> Any:
    """Return the type of a field if it has a key: one that is left out without a value is never null."""
    if not field.omitted:
        return field.hint
    hint, *marks = get_args(field.hint)
    arms = tuple(each for each in get_args(hint) if each is not type(None)) or (hint,)
    union, annotated = cast(Any, Union), cast(Any, Annotated)
    return annotated[(union[arms], *marks)]


def _record_in(hint: Any) -> type | None:
    if get_origin(hint) is Annotated:
        inner, *marks = get_args(hint)
        return _record_in(next((each.record for each in marks if isinstance(each, Like)), inner))
    if get_origin(hint) in (Union, types.UnionType):
        return next((each for each in map(_record_in, get_args(hint)) if each is not None), None)
    return hint if dataclasses.is_dataclass(hint) and isinstance(hint, type) else None


def _may_lack(hint: Any) -> bool:
    """Return whether a record that is inline may be None."""
    return type(None) in get_args(bare(hint))


def _schema(hint: Any, definitions: Definitions) -> Values:  # noqa: PLR0911 - one return a form
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        if LOOSE in arguments[1:]:
            return {"type": "object"} | _extras(arguments[1:])
        like = next((each.record for each in arguments[1:] if isinstance(each, Like)), arguments[0])
        return _schema(_as_list(like, arguments[1:]), definitions) | _extras(arguments[1:])
    if origin in (Union, types.UnionType):
        return _one_of(_branches(arguments, definitions))
    if origin is Literal:
        return {"const": arguments[0]} if len(arguments) == 1 else {"enum": list(arguments)}
    if origin is tuple and arguments[-1] is not Ellipsis:
        return {
            "type": "array",
            "prefixItems": [_schema(each, definitions) for each in arguments],
            "items": False,
        }
    if origin in ITERABLE:
        return {"type": "array", "items": _schema(arguments[0], definitions)}
    if origin is np.ndarray:
        return {"type": "array", "items": {"type": "number"}}
    if origin in MAPPINGS:
        items = _schema(arguments[1], definitions)
        return {"type": "object", **({"additionalProperties": items} if items else {})}
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        name = definitions.name_of(hint)
        if name not in definitions:
            definitions[name] = {}  # a record may hold its own kind
            definitions[name] = _object(hint, definitions)
        return {"$ref": f"#/$defs/{name}"}
    return {} if hint is Any or hint is object else {"type": NAMES[hint]}


def _as_list(hint: Any, marks: Sequence[Any]) -> Any:
    """Return a tuple of a size that is marked as a list of what it holds."""
    is_sized = get_origin(hint) is tuple and any(isinstance(each, Size) for each in marks)
    return cast(Any, Sequence)[get_args(hint)[0]] if is_sized else hint


ITERABLE = (list, tuple, Sequence)
MAPPINGS = (dict, Mapping)


def _branches(arguments: Sequence[Any], definitions: Definitions) -> list[Values]:
    """Return the schemas of a union: an array is a way to hold the sequence beside it, or a plain one."""
    hints = [each for each in arguments if each is not Absent]
    sequences = [each for each in hints if get_origin(each) in ITERABLE]
    hints = [each for each in hints if not (sequences and get_origin(each) is np.ndarray)]
    return [_schema(each, definitions) for each in hints]


def _extras(extras: tuple[Any, ...]) -> Values:
    bounds: Values = {}
    for each in extras:
        if isinstance(each, Range | Size | Pattern):
            bounds |= each.schema()
    words = [each for each in extras if isinstance(each, str)]
    return bounds | ({"description": words[0]} if words else {})


def _one_of(schemas: list[Values]) -> Values:
    """Return a schema that allows any of these; a value or null keeps its bounds beside a list of types."""
    if len(schemas) == 1:
        return schemas[0]
    null = {"type": "null"}
    others = [each for each in schemas if each != null]
    if len(others) == 1 and null in schemas:
        only = others[0]
        if "enum" in only:
            return only | {"enum": [*only["enum"], None]}
        if isinstance(only.get("type"), str) and only["type"] != "object":
            return only | {"type": [only["type"], "null"]}
    if all(set(each) == {"type"} for each in schemas):
        return {"type": [each["type"] for each in schemas]}
    return {"anyOf": schemas}
