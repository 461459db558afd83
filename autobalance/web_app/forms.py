"""The keys of a job as the page's forms are made of them: what each is, its unit, its default."""

from __future__ import annotations

from collections.abc import Iterator
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin

from autobalance.job.tables import job_tables
from autobalance.job.toml.keys import FILLED, REQUIRED, Key
from autobalance.job.toml.typed_values import UNIT_BY_ENDING

BY_ITSELF = "correction"
"""The table that has forms of its own, by the kinds of correction."""


def tables() -> list[dict[str, Any]]:
    """Return every table of a job that is no list, with those of its keys that hold plain values.

    What is a list of tables, or has names of a user's own, is for the job's text.
    """
    forms = (
        {"table": table.name, "says": table.says, "keys": list(_fields(table.keys, ""))}
        for table in job_tables()
        if table.name != BY_ITSELF and not table.many
    )
    return [form for form in forms if form["keys"]]


def _fields(keys: tuple[Key, ...], path: str) -> Iterator[dict[str, Any]]:
    for key in keys:
        if key.many or key.named is not None or key.hint is dict:
            continue
        if key.keys and key.hint is None:
            yield from _fields(key.keys, f"{path}{key.name}.")
            continue
        plain = key.default is not REQUIRED and key.default is not FILLED and key.default is not None
        choices = _choices(key.hint)
        yield {
            "key": f"{path}{key.name}",
            "words": f"{path}{_words(key)}".replace(".", ": ").replace("_", " "),
            "unit": key.unit,
            "kind": "choice" if choices else _kind(key.hint),
            "choices": choices,
            "default": _text(key.default) if plain else key.usual,
            "says": key.says,
        }


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
        return "list" if "list" in kinds else "number" if "number" in kinds else "text"
    return "number" if hint in (int, float) else "text"


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, tuple | list):
        return ", ".join(map(_text, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
