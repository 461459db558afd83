"""Tables of keys: what a TOML file may hold, declared once.

A file's reader lists its keys. Reading with defaults, the echo of the input in a report, the JSON Schema for
editors (``schema``), the job that ``init`` writes and the tables of the documentation come from that list.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin

from autobalance.declare import (
    FILLED,
    MIN_POSITIVE,
    POSITIVE,
    REQUIRED,
    Key,
    Large,
    Range,
    Values,
    names,
)
from autobalance.errors import JobError
from autobalance.toml_files.document import text_of, toml_of
from autobalance.toml_files.table import (
    LARGEST_OF_ALL,
    MAX_NUMBER,
    Faults,
    Table,
    point_for_comma,
    shown,
    tell,
    unknown_keys,
)
from autobalance.toml_files.typed_units import TYPED_UNITS, TypedUnit, in_base_units

T = TypeVar("T")


def read_document(
    source: str | Path | Mapping[str, Any],
    what: str,
    keys: tuple[Key, ...],
    maker: Callable[[Values], T],
    check: Callable[[Mapping[str, Any]], None] = lambda _: None,
) -> T:
    """Read a TOML file, or its structure, strictly and make something of its values.

    Parameters
    ----------
    source : path or mapping
        The file, or the structure it would have.
    what : str
        What the file is, for messages.
    keys : tuple of Key
        All that may be at its top level.
    maker : callable
        Takes the values, defaults filled in.
    check : callable
        Takes the structure as it is, and refuses it before anything else does.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, a key breaks its rules or ``maker`` refuses; the message begins with the
        file's name.
    """
    if isinstance(source, Mapping):
        check(source)
        return maker(read(in_base_units(source), keys))
    path = Path(source)
    raw = toml_of(text_of(path, what), path.name)
    with named_in(source):
        check(raw)
        return maker(read(in_base_units(raw), keys))


@contextmanager
def named_in(source: str | Path | Mapping[str, Any]) -> Iterator[None]:
    """Begin the message of an error about a file with its name; a structure has no name."""
    try:
        yield
    except JobError as error:
        if isinstance(source, Mapping):
            raise
        raise error.within(Path(source).name) from None


def read(raw: Mapping[str, Any], keys: tuple[Key, ...], path: str = "") -> Values:
    """Return the values of a table by key, defaults filled in; tables inside become dictionaries.

    Raises
    ------
    JobError
        If keys are unknown, missing, of another type or impossible; it names each, a line a key.
    """
    return _values(dict(raw), keys, path)


def _values(raw: object, keys: tuple[Key, ...], path: str) -> Values:
    """Return the values of a table; of one that is missing, its first missing key is named alone."""
    table = Table(raw, path, None)
    faults = Faults()
    below = {one.name: f"{key.name}.{one.name}" for key in keys if not key.many for one in key.keys}
    faults.lines += unknown_keys(table, names(keys), below)
    misspelt, alone = bool(faults.lines), not table.raw and bool(path)
    values: Values = {}
    for key in keys:
        before = len(faults.lines)
        with faults.gathered():
            values[key.name] = value_of(table, key)
        absent = key.name not in table
        if absent and len(faults.lines) > before and (misspelt or (alone and before)):
            del faults.lines[before:]  # the misspelt key is most likely the missing one
    faults.refuse()
    return values


def value_of(table: Table, key: Key) -> Any:
    """Return the value of one key of a table, its default where it is missing.

    Raises
    ------
    JobError
        If it is missing, of another type or impossible.
    """
    where, there = table.place(key.name), key.name in table
    if key.many:
        return _many(table, key)
    if key.instead and key.instead in table:
        if there:
            raise JobError(f"{where} and {_shown_name(table, key.instead)} are both given; leave one out")
        return None
    if not there and key.default is REQUIRED and (key.is_table or key.missing):
        bracketed = f"[{where}]" if key.is_table and key.hint is None else where
        raise JobError(f"{bracketed} is missing" + (f"; {key.missing}" if key.missing else ""))
    raw = table.raw.get(key.name)
    if key.is_table and (key.hint is None or isinstance(raw, dict)):
        return _table_value(raw if there else {}, key, where) if there or key.default is not None else None
    if not there and key.default is not REQUIRED:
        return key.default
    if key.hint is dict and there:
        return dict(Table(raw, where, None).raw)
    value = (
        _typed(table, key)
        if isinstance(raw, str | list) or key.or_one
        else table.value(key.name, key.hint, key.rule)
    )
    if key.not_empty and value in ("", ()):
        empty = "empty" if value == "" else "an empty list"
        raise JobError(f"{where} is {empty}; {key.not_empty}")
    return value


def _shown_name(table: Table, name: str) -> str:
    where = table.place(name)
    return f"[{where}]" if isinstance(table.raw[name], dict) else where


def _table_value(raw: object, key: Key, where: str) -> Values:
    return _values(raw, key.keys, where) if key.named is None else _named(Table(raw, where, None), key.named)


def _typed(table: Table, key: Key) -> Any:
    """Return a value whose numbers may be texts with their unit."""
    unit, raw = TYPED_UNITS.get(key.typed_unit), table.raw.get(key.name)
    number = raw if unit is None else _as_number(raw, unit, table.place(key.name))
    if key.or_one and _is_number(number):
        number = [number]
    try:
        return Table({key.name: number}, table.path, None).value(key.name, key.hint, key.rule)
    except JobError as error:
        fault = str(error)
        if unit is None or number is not raw or not isinstance(raw, str) or fault.endswith("?"):
            raise
        raise JobError(f'{fault}, or with its unit: "{unit.example}"') from None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _as_number(raw: object, unit: TypedUnit, where: str) -> object:
    if isinstance(raw, list):
        return [_as_number(item, unit, f"{where}[{place}]") for place, item in enumerate(raw, 1)]
    if not isinstance(raw, str):
        return raw
    pointed = point_for_comma(raw)
    if not unit.fits(pointed):
        return raw
    if pointed != raw:
        tell(where, raw)
    return unit.number(pointed, where)


def _many(table: Table, key: Key) -> Any:
    where = table.place(key.name)
    if key.name not in table and key.default is not REQUIRED:
        return None if key.default is None and key.not_empty else []
    raw = table.raw.get(key.name, [])
    if not isinstance(raw, list):
        raise JobError(f"{where} is {shown(raw)}; must be a list of tables: [[{where}]]")
    if not raw and key.default is REQUIRED:
        raise JobError(f"[[{where}]] is missing; expected at least one")
    if not raw and key.not_empty:
        raise JobError(f"{where} is an empty list; {key.not_empty}")
    faults = Faults()
    tables = []
    for place, item in enumerate(raw, 1):
        with faults.gathered():
            tables.append(_values(_read_of(item, key), key.keys, f"{where}[{place}]"))
    faults.refuse()
    return tables


def _read_of(item: object, key: Key) -> object:
    """Return a table of an array without the keys that are not read."""
    if not key.ignored or not isinstance(item, Mapping):
        return item
    return {name: value for name, value in item.items() if name not in key.ignored}


def _named(table: Table, each: Key) -> Values:
    """Return the values of a table whose keys are free names."""
    faults = Faults()
    values: Values = {}
    for name in table.raw:
        with faults.gathered():
            values[name] = value_of(table, replace(each, name=name, default=REQUIRED))
    faults.refuse()
    return values


def plain(value: Any) -> Any:
    """Return tuples as lists, as JSON and TOML have them."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    return [plain(each) for each in value] if isinstance(value, tuple | list) else value


# --- JSON Schema --------------------------------------------------------------------------------------------

DRAFT = "https://json-schema.org/draft/2020-12/schema"
JSON_TYPES = {
    float: "number",
    Large: "number",
    int: "integer",
    bool: "boolean",
    str: "string",
    dict: "object",
}


def json_schema(title: str, *forms: tuple[Key, ...]) -> Values:
    """Return the JSON Schema (draft 2020-12) of a file whose top level holds the keys of one of its forms."""
    tables = [_table_schema(keys) for keys in forms]
    return {"$schema": DRAFT, "title": title, **(tables[0] if len(tables) == 1 else {"anyOf": tables})}


def _table_schema(keys: tuple[Key, ...]) -> Values:
    schema: Values = {
        "type": "object",
        "additionalProperties": False,
        "properties": {key.name: _key_schema(key) for key in keys},
    }
    if required := [key.name for key in keys if _is_needed(key) and not key.instead]:
        schema["required"] = required
    either = [
        {"oneOf": [{"required": [key.name]}, {"required": [key.instead]}]}
        if _is_needed(key)
        else {"not": {"required": [key.name, key.instead]}}
        for key in keys
        if key.instead
    ]
    return {**schema, "allOf": either} if either else schema


def _is_needed(key: Key) -> bool:
    """Return whether a table must hold a key: one without a default, or a table with such a key."""
    if key.default is REQUIRED:
        return True
    return key.default is FILLED and not key.many and any(_is_needed(each) for each in key.keys)


def _key_schema(key: Key) -> Values:
    says = {"description": key.says} if key.says else {}
    default = {"default": plain(key.default)} if not key.is_table and _has_default(key) else {}
    return {**says, **_value_schema(key), **default, **key.shape}


def _has_default(key: Key) -> bool:
    return key.default is not REQUIRED and key.default is not None


def _value_schema(key: Key) -> Values:
    if key.many:
        least = 1 if key.default is REQUIRED or key.not_empty else 0
        items = _table_schema(key.keys)
        items["properties"] |= {name: {} for name in key.ignored}
        many: Values = {"type": "array", "items": items}
        return {**many, "minItems": least} if least else many
    if key.named is not None:
        free = {"type": "object", "additionalProperties": _key_schema(key.named)}
        if key.hint is None:
            return free
        plain_value = _hint_schema(key.hint, key.rule, key.typed_unit)
        return {"anyOf": [plain_value, free]}
    if not key.keys:
        schema = _filled(_hint_schema(key.hint, key.rule, key.typed_unit), key)
        return _with_one(schema) if key.or_one else schema
    tables = [_key_schema(form) for form in key.forms] or [_table_schema(key.keys)]
    arms = tables if key.hint is None else [_hint_schema(key.hint, key.rule, key.typed_unit), *tables]
    return arms[0] if len(arms) == 1 else {"anyOf": arms}


def _with_one(schema: Values) -> Values:
    """Return the schema of a list that takes one of its numbers too."""
    arms = schema.get("anyOf", [schema])
    items = next(arm["items"] for arm in arms if arm.get("type") == "array")
    return {"anyOf": [*items.get("anyOf", [items]), *arms]}


def _filled(schema: Values, key: Key) -> Values:
    """Return a schema that refuses an empty list or text where one may not be empty."""
    if not key.not_empty:
        return schema
    arms = [
        {**arm, **{"array": {"minItems": 1}, "string": {"minLength": 1}}.get(str(arm.get("type")), {})}
        for arm in schema.get("anyOf", [schema])
    ]
    return {"anyOf": arms} if "anyOf" in schema else arms[0]


def _hint_schema(hint: Any, rule: Range, unit: str = "") -> Values:
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Literal:
        return {"enum": list(inner)}
    if origin is None:
        return _number_schema(hint, rule, unit) if hint in (float, int, Large) else {"type": JSON_TYPES[hint]}
    arms = [_hint_schema(each, rule, unit) for each in inner if each not in (type(None), Ellipsis)]
    if origin is tuple and inner[-1] is Ellipsis:
        return {"type": "array", "items": arms[0]}
    if origin is tuple:
        return {"type": "array", "prefixItems": arms, "minItems": len(arms), "maxItems": len(arms)}
    every = [one for arm in arms for one in arm.get("anyOf", [arm])]
    return every[0] if len(every) == 1 else {"anyOf": every}


def _number_schema(hint: Any, rule: Range, unit: str) -> Values:
    number = {"type": JSON_TYPES[hint], **_range_schema(hint, rule)}
    typed = TYPED_UNITS.get(unit) if hint is float else None
    if typed is None:
        return number
    sign = r"(?!\s*-)" if rule.least == 0.0 or rule.above == 0.0 else ""
    return {"anyOf": [number, {"type": "string", "pattern": f"^{sign}{typed.pattern}$"}]}


def _range_schema(hint: Any, rule: Range) -> Values:
    """Return the range of a number, with the size that no number of a file may exceed."""
    if rule.one_of:
        return rule.schema()
    most = LARGEST_OF_ALL if hint is Large else MAX_NUMBER
    limits = {"minimum": MIN_POSITIVE if rule is POSITIVE else -most, "maximum": most, **rule.schema()}
    if "exclusiveMinimum" in limits and rule is not POSITIVE:
        del limits["minimum"]
    if "exclusiveMaximum" in limits:
        del limits["maximum"]
    return limits
