"""Values as TOML text: what ``tomllib`` reads back to the same values."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.errors import JobError

UNITS_OF_MASS = {"g", "kg", "oz", "lb"}
BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_value(value: Any) -> str:
    r"""Return a value as TOML, tables inline.

    Raises
    ------
    JobError
        If it is, or holds, None: TOML has no word for it.

    Examples
    --------
    >>> toml_value([8.0, {"g": 158.0, "pm": 0.5}]), toml_value(True), toml_value('3/8"')
    ('[8.0, { g = 158.0, pm = 0.5 }]', 'true', '"3/8\\""')
    """
    if value is None:
        raise JobError("found null where a job has a value; expected a number, a text, a list or a table")
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{toml_key(key)} = {toml_value(item)}" for key, item in value.items())
        return f"{{ {pairs} }}" if pairs else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(toml_value(item) for item in value)}]"
    return repr(value)


def toml_key(key: str) -> str:
    """Return a key as TOML, quoted where it must be."""
    return key if BARE_KEY.fullmatch(key) else json.dumps(key, ensure_ascii=False)


def toml_text(values: Mapping[str, Any]) -> str:
    """Return tables as a TOML document; tables without plain values have no heading."""
    lines: list[str] = []
    _table(values, (), lines)
    return "\n".join(lines).strip() + "\n"


def _table(values: Mapping[str, Any], path: Sequence[str], lines: list[str]) -> None:
    plain = {key: value for key, value in values.items() if not _is_table(value) and not _is_tables(value)}
    lines += [f"{toml_key(key)} = {toml_value(value)}" for key, value in plain.items()]
    for key, value in values.items():
        if _is_table(value):
            here = (*path, key)
            if not value or any(not _is_table(item) and not _is_tables(item) for item in value.values()):
                lines += ["", f"[{'.'.join(toml_key(each) for each in here)}]"]
            _table(value, here, lines)
        elif _is_tables(value):
            for item in value:
                lines += ["", f"[[{'.'.join(toml_key(each) for each in (*path, key))}]]"]
                _table(item, (*path, key), lines)


def _is_table(value: Any) -> bool:
    """Return whether a value gets a heading; a weight with its unit stays in line."""
    return isinstance(value, Mapping) and not UNITS_OF_MASS & set(value)


def _is_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, Mapping) for item in value)
