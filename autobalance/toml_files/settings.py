"""Single keys of a file set from outside: ``engine.throw[2].rods=2``."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.errors import JobError
from autobalance.toml_files.convert import point_for_comma, tell
from autobalance.toml_files.document import refuse_deep

PART = re.compile(r"([A-Za-z0-9_\-·°]+)((?:\[\d+\])*)")


def with_settings(values: Mapping[str, Any], settings: Sequence[str]) -> dict[str, Any]:
    """Return the tables of a file with keys set; missing tables are made.

    Parameters
    ----------
    values : mapping
        As ``tomllib`` read them.
    settings : sequence of str
        ``KEY=VALUE``: a dotted path, places in lists from 1, and a value of TOML, or else text.

    Raises
    ------
    JobError
        If a setting is not ``KEY=VALUE``, or its path leads into something that is not a table.

    Examples
    --------
    >>> with_settings({"balance": {"factor": 0.5}}, ["balance.factor=0.28", "engine.throw[1].rods=2"])
    {'balance': {'factor': 0.28}, 'engine': {'throw': [{'rods': 2}]}}
    """
    changed: dict[str, Any] = copy.deepcopy(dict(values))
    for setting in settings:
        key, value = setting_of(setting)
        set_key(changed, key, value)
    return changed


def setting_of(setting: str) -> tuple[str, Any]:
    """Return the key and the value of ``KEY=VALUE``; a decimal comma is read, with a warning."""
    key, equals, text = setting.partition("=")
    if not equals or not key.strip():
        raise JobError(f"--set {setting!r} is not KEY=VALUE, such as balance.factor=0.5")
    pointed = point_for_comma(text)
    if pointed != text:
        tell(f"--set {key.strip()}", text)
    return key.strip(), value_of(pointed)


def value_of(text: str) -> Any:
    """Return a text's TOML value, or the text if it is not TOML."""
    try:
        refuse_deep(text)
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):  # TOMLDecodeError is a ValueError
        return text.strip()


def set_key(values: dict[str, Any], key: str, value: Any) -> None:
    """Set one dotted key of nested tables in place.

    Raises
    ------
    JobError If the path is invalid, leads into something that is not a table, or leaves out places of a list.
    """
    steps = _steps(key)
    place: Any = values
    for number, step in enumerate(steps):
        last = number == len(steps) - 1
        if isinstance(step, str):
            if not isinstance(place, dict):
                raise JobError(f"{key}: {_path(steps[:number])} is not a table")
            if last:
                place[step] = value
                return
            place = place.setdefault(step, [] if isinstance(steps[number + 1], int) else {})
            continue
        if not isinstance(place, list):
            raise JobError(f"{key}: {_path(steps[:number])} is not a list")
        if step > len(place) + 1 or step < 1:
            raise JobError(
                f"{key}: {_path(steps[:number])} has {len(place)} entries; the next is [{len(place) + 1}]"
            )
        if step > len(place):
            place.append({})
        if last:
            place[step - 1] = value
            return
        place = place[step - 1]


def _steps(key: str) -> list[str | int]:
    steps: list[str | int] = []
    for part in key.split("."):
        match = PART.fullmatch(part)
        if match is None:
            raise JobError(f"{key!r} is not a dotted key, such as engine.throw[2].rods")
        steps.append(match[1])
        steps += [int(number) for number in re.findall(r"\[(\d+)\]", match[2])]
    return steps


def _path(steps: Sequence[str | int]) -> str:
    text = ""
    for step in steps:
        text += f"[{step}]" if isinstance(step, int) else (f".{step}" if text else step)
    return text
