"""Tables of keys: what a TOML file may hold, said once, read strictly from it and turned into a JSON Schema.

A file's reader lists its keys; reading with defaults, the echo of the input in a report, and the schema for
editors all come from that one list.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

from autobalance.errors import JobError
from autobalance.job.toml.convert import Large
from autobalance.job.toml.document import text_of, toml_of
from autobalance.job.toml.table import ANY, COUNTED, NOT_NEGATIVE, POSITIVE, SHARE, Rule, Table
from autobalance.job.toml.typed_units import in_base_units

Values = dict[str, Any]
T = TypeVar("T")


class _Required:
    """Mark of a key that has no default."""

    def __repr__(self) -> str:
        return "REQUIRED"


REQUIRED = _Required()
FILLED: Any = ()


@dataclass(frozen=True)
class Key:
    """One key of a table: its name, type, rule and default, and what it means.

    ``keys`` makes it a table of its own; with ``many``, an array of tables. A table that may be missing has
    the default None, or ``FILLED``: then it is there with the defaults of its keys.
    """

    name: str
    hint: Any = None
    says: str = ""
    rule: Rule = ANY
    default: Any = REQUIRED
    keys: tuple[Key, ...] = ()
    many: bool = False


def names(keys: tuple[Key, ...]) -> tuple[str, ...]:
    """Return the names of keys, in their order."""
    return tuple(key.name for key in keys)


def read_document(
    source: str | Path | Mapping[str, Any], what: str, keys: tuple[Key, ...], made: Callable[[Values], T]
) -> T:
    """Read a TOML file, or its structure, strictly and make something of its values.

    Parameters
    ----------
    source : path or mapping
        The file, or the structure it would have.
    what : str
        What the file is, for messages.
    keys : tuple of Key
        All that may stand at its top level.
    made : callable
        Takes the values, defaults filled in.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, a key breaks its rules or ``made`` refuses; the message begins with the
        file's name.
    """
    if isinstance(source, Mapping):
        return made(read(in_base_units(source), keys))
    path = Path(source)
    raw = toml_of(text_of(path, what), path.name)
    with named_in(source):
        return made(read(in_base_units(raw), keys))


@contextmanager
def named_in(source: str | Path | Mapping[str, Any]) -> Iterator[None]:
    """Begin the message of an error about a file with its name; a structure has none."""
    try:
        yield
    except JobError as error:
        if isinstance(source, Mapping):
            raise
        raise JobError(f"{Path(source).name}: {error}") from None


def read(raw: Mapping[str, Any], keys: tuple[Key, ...], path: str = "") -> Values:
    """Return the values of a table by key, defaults filled in; tables inside become dictionaries.

    Raises
    ------
    JobError
        If a key is unknown, missing, of another type or impossible; the message names it.
    """
    return _values(Table(dict(raw), path, names(keys)), keys)


def _values(table: Table, keys: tuple[Key, ...]) -> Values:
    return {key.name: _value(table, key) for key in keys}


def _value(table: Table, key: Key) -> Any:
    if key.keys and key.many:
        found = table.tables(key.name, names(key.keys))
        if key.default is REQUIRED and not found:
            raise JobError(f"[[{table.place(key.name)}]] is missing; at least one is needed")
        return [_values(each, key.keys) for each in found]
    if key.keys:
        if key.name not in table and key.default is REQUIRED:
            raise JobError(f"[{table.place(key.name)}] is missing")
        if key.name not in table and key.default is None:
            return None
        return _values(table.table(key.name, names(key.keys)), key.keys)
    if key.hint is dict:
        return dict(table.table(key.name, None).raw) if key.name in table else key.default
    if key.default is REQUIRED:
        return table.value(key.name, key.hint, key.rule)
    return table.optional(key.name, key.hint, key.rule, key.default)


# --- JSON Schema --------------------------------------------------------------------------------------------

DRAFT = "https://json-schema.org/draft/2020-12/schema"
LIMITS: Mapping[str, Mapping[str, float]] = {
    POSITIVE.text: {"exclusiveMinimum": 0},
    NOT_NEGATIVE.text: {"minimum": 0},
    SHARE.text: {"minimum": 0, "maximum": 1},
    COUNTED.text: {"minimum": 1},
}
SIMPLE = {
    float: "number",
    Large: "number",
    int: "integer",
    bool: "boolean",
    str: "string",
    dict: "object",
}


def json_schema(title: str, keys: tuple[Key, ...]) -> Values:
    """Return the JSON Schema (draft 2020-12) of a file whose top level holds these keys."""
    return {"$schema": DRAFT, "title": title, **_table_schema(keys)}


def _table_schema(keys: tuple[Key, ...]) -> Values:
    schema: Values = {
        "type": "object",
        "additionalProperties": False,
        "properties": {key.name: _key_schema(key) for key in keys},
    }
    required = [key.name for key in keys if key.default is REQUIRED]
    return {**schema, "required": required} if required else schema


def _key_schema(key: Key) -> Values:
    says = {"description": key.says} if key.says else {}
    if key.keys:
        table = _table_schema(key.keys)
        many: Values = {"type": "array", "items": table}
        if key.default is REQUIRED:
            many["minItems"] = 1
        return {**says, **(many if key.many else table)}
    default = {} if key.default is REQUIRED or key.default is None else {"default": _plain(key.default)}
    found = _hint_schema(key.hint, key.rule)
    typed = key.name.endswith("_mm") and not key.name.endswith("_n_mm")
    return {**says, **(_or_text(found) if typed else found), **default}


def _or_text(schema: Values) -> Values:
    """Return a schema in which numbers may be texts with their unit too."""
    return {
        key: ["number", "string"] if key == "type" and value == "number" else _or_text_in(value)
        for key, value in schema.items()
    }


def _or_text_in(value: Any) -> Any:
    if isinstance(value, list):
        return [_or_text_in(each) for each in value]
    return _or_text(value) if isinstance(value, dict) else value


def _hint_schema(hint: Any, rule: Rule) -> Values:
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Literal:
        return {"enum": list(inner)}
    if origin in (Union, UnionType):
        return {"anyOf": [_hint_schema(each, rule) for each in inner if each is not type(None)]}
    if origin is tuple and inner[-1] is Ellipsis:
        return {"type": "array", "items": _hint_schema(inner[0], rule)}
    if origin is tuple:
        items = [_hint_schema(each, rule) for each in inner]
        return {"type": "array", "prefixItems": items, "minItems": len(items), "maxItems": len(items)}
    limits = LIMITS.get(rule.text, {}) if hint in (float, int) else {}
    return {"type": SIMPLE[hint], **limits}


def _plain(value: Any) -> Any:
    """Return tuples as lists, as JSON has them."""
    return [_plain(each) for each in value] if isinstance(value, tuple | list) else value
