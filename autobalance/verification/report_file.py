"""Strict reader of a report's JSON: known version, no key twice, no number out of bounds."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from autobalance.errors import FileError, FormatError, file_errors, refuse_pipe
from autobalance.runtime import note_read
from autobalance.solid.formats.table import endings

MAX_NUMBER = 1e30
"""Largest size of a number: no report holds a larger one, and products stay finite."""
VERSIONS = (1,)
"""Readable versions of reports."""

Number = TypeVar("Number", int, float)


def read_report(path: Path) -> Mapping[str, Any]:
    """Return the values of a report's JSON.

    Raises
    ------
    FileError
        If it cannot be read.
    FormatError
        If it is not a JSON object, has a key twice or a number that cannot be, or is of an unknown version.
    """
    if path.is_dir():
        inside = path / "report.json"
        raise FileError(f"{path} is a folder; expected a report" + f", such as {inside}" * inside.is_file())
    if path.suffix.lower() in endings() and path.is_file():
        raise FormatError(f"{path} is a solid, not a report; expected the report.json beside it")
    with file_errors(f"read the report {path}"):
        refuse_pipe(path)
        note_read(path)
        data = path.read_bytes()
    try:
        values = json.loads(
            data,
            parse_float=lambda text: _limited(float(text)),
            parse_int=lambda text: _limited(int(text)),
            parse_constant=_not_a_number,
            object_pairs_hook=_each_once,
        )
    except UnicodeDecodeError:
        raise FormatError(f"{path} is not JSON, not even text; expected the report.json of a run") from None
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path} is not JSON: {str(error).splitlines()[0]}") from None
    if not isinstance(values, dict):
        raise FormatError(f"{path} is not a report: its JSON is not an object")
    if "command" in values:
        refuse_version(path.name, values)
    return values


def refuse_version(name: str, values: Mapping[str, Any]) -> None:
    """Refuse a report of an unknown version: its keys may mean something else.

    Raises
    ------
    FormatError
        If it is of such a version, or of none.
    """
    version = values.get("schema_version")
    if isinstance(version, bool) or version not in VERSIONS:
        known = ", ".join(map(str, VERSIONS))
        raise FormatError(f"{name}: schema_version is {version!r}; expected one that is known here: {known}")


def _limited(number: Number) -> Number:
    if abs(number) > MAX_NUMBER:
        raise ValueError(f"it holds a number beyond {MAX_NUMBER:g}")
    return number


def _not_a_number(word: str) -> float:
    raise ValueError(f"it holds the number {word}")


def _each_once(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    entries: dict[str, Any] = {}
    for key, value in pairs:
        if key in entries:
            raise ValueError(f"it has the key {key!r} twice in one object")
        entries[key] = value
    return entries
