"""The keys of a job as the page's forms are made of them: what each is, its unit, its default."""

from __future__ import annotations

import re
from collections.abc import Iterator
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin

from autobalance.declare import FILLED, REQUIRED, UNIT_BY_ENDING, Key, unit_of_name
from autobalance.job.limits import correction_key
from autobalance.job.reading import forms_of
from autobalance.job.tables import job_tables
from autobalance.job.template import in_plain_text
from autobalance.profile_search.input import START_TABLES

BY_ITSELF = "correction"
"""The table that has separate forms, by the kinds of correction."""
Form = dict[str, Any]


def tables() -> list[Form]:
    """Return every table of a job with its keys; ``many`` marks a list of such tables."""
    declared = (table for table in job_tables() if table.name != BY_ITSELF)
    forms = (
        {
            "table": table.name,
            "says": _plain(table.says),
            "many": table.many,
            "verbs": list(table.read_by),
            "keys": list(_fields(table.keys, "")),
        }
        for table in declared
    )
    return [form for form in forms if form["keys"]]


def file_tables(schema: str) -> list[Form]:
    """Return the tables of a verb's own file, by the name of its schema; those of a job are not among them.

    Keys outside any table come first, in a table without a name. Where a file has several forms, it is all
    keys of them: one that differs between them has the choices of all, and ``of`` names its forms.
    """
    forms = forms_of(schema)
    declared: dict[str, dict[str, Key]] = {}
    for form, keys in forms.items():
        for key in keys:
            declared.setdefault(key.name, {})[form] = key
    loose: list[Form] = []
    tables: list[Form] = []
    for name, alike in declared.items():
        key = next(iter(alike.values()))
        if name in START_TABLES:
            continue
        if key.is_table and key.hint is None:
            head = {"table": name, "says": _plain(key.says), "many": key.many}
            tables.append({**head, "keys": list(_fields(key.keys, ""))})
        elif key.hint is not dict:
            choices = list(dict.fromkeys(choice for each in alike.values() for choice in _choices(each.hint)))
            some = (
                {"of": sorted({form.partition(",")[0] for form in alike})} if len(alike) < len(forms) else {}
            )
            words = _path_words(key, "")
            loose.append({**_field(key), **some, "key": name, "words": words, "choices": choices})
    general = {"table": "", "says": "", "many": False, "keys": loose}
    return [general, *tables] if loose else tables


def limits(kind: str) -> list[Form]:
    """Return the keys that limit one kind of correction."""
    (table,) = (each for each in correction_key().keys if each.name == kind)
    return list(_fields(table.keys, ""))


def _fields(keys: tuple[Key, ...], path: str) -> Iterator[Form]:
    for key in keys:
        if key.hint is dict:
            continue
        if key.keys and key.hint is None and not key.many:
            yield from _fields(key.keys, f"{path}{key.name}.")
            continue
        yield {**_field(key), "key": f"{path}{key.name}", "words": _path_words(key, path)}


def _field(key: Key) -> Form:
    """Return the form of one key: a plain value, rows of a table, or values by free names."""
    plain = key.default is not REQUIRED and key.default is not FILLED and key.default is not None
    says, verbs = _plain(key.says), list(key.read_by)
    form = {"unit": key.unit, "choices": [], "default": "", "says": says, "verbs": verbs}
    if key.many:
        return {**form, "kind": "rows", "fields": list(_fields(key.keys, ""))}
    if key.named is not None:
        return {**form, "kind": "named", "unit": key.unit or unit_of_name(key.name)}
    choices = _choices(key.hint)
    usual = _text(key.default) if plain else key.usual.replace("`", "")
    return {**form, "kind": "choice" if choices else _kind(key.hint), "choices": choices, "default": usual}


def _plain(says: str) -> str:
    """Return the meaning of a key without links into the documentation."""
    return in_plain_text(re.sub(r"[:;,]? see \[[^\]]*\]\([^)]*\)", "", says))


def _path_words(key: Key, path: str) -> str:
    return f"{path}{_words(key)}".replace(".", ": ").replace("_", " ")


def _words(key: Key) -> str:
    """Return a key's name without the unit that it ends in."""
    endings = (end for end in UNIT_BY_ENDING if key.name.endswith(end))
    return key.name.removesuffix(next(endings, ""))


def _choices(hint: Any) -> list[str]:
    """Return the words that a key takes, where it takes nothing else."""
    args = [each for each in get_args(hint) if each is not type(None)]
    if get_origin(hint) is Literal and all(isinstance(each, str) for each in args):
        return list(args)
    return _choices(args[0]) if get_origin(hint) in (Union, UnionType) and len(args) == 1 else []


def _kind(hint: Any) -> str:
    if hint is bool:
        return "bool"
    origin = get_origin(hint)
    if origin in (tuple, list):
        return "list"
    if origin in (Union, UnionType):
        kinds = {_kind(each) for each in get_args(hint) if each is not type(None)}
        ordered = ("list", "number", "text", "bool")
        return next((kind for kind in ordered if kind in kinds), "text")
    return "number" if hint in (int, float) else "text"


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple | list):
        return ", ".join(map(_text, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
