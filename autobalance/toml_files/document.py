"""A TOML file as text and as tables, with limits on its size and depth."""

from __future__ import annotations

import copy
import json
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from autobalance.errors import JobError, file_errors, refuse_pipe
from autobalance.runtime import note_read
from autobalance.toml_files.table import COMMA_NUMBER, is_decimal, point_for_comma, tell

# A TOML file as text and as tables, with limits on its size and depth.


MAX_DEPTH = 32
"""Tables and lists inside each other at most: those that people write have four."""
NO_KEYS = re.compile(r"""\"{3}[\s\S]*?\"{3}|'{3}[\s\S]*?'{3}|"(?:\\.|[^"\\\n])*"|'[^'\n]*'|\#[^\n]*""")
"""Texts and comments, which may hold dots and brackets."""
KEY_ENDS = re.compile(r"[=,{}]")
"""Characters around a dotted key."""
LARGEST_BYTES = 1 << 20
"""Bytes of a job at most; those that people write have a few thousand."""


IN_TOML = re.compile(rf"(?<==)(\s*)({COMMA_NUMBER})(?=\s*(?:#.*)?$|\s*}}|\s*,\s*[A-Za-z_][\w-]*\s*=)")
"""Such a number as a whole value, alone in its line or in a table in braces, never in a list."""


def text_of(path: Path, what: str) -> str:
    """Return the text of a small file; ``what`` is its kind, for messages.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not text, or larger than any of its kind.
    """
    refuse_pipe(path)
    note_read(path)
    with file_errors(f"read the {what} {path}"), path.open("rb") as stream:
        data = stream.read(LARGEST_BYTES + 1)
    if len(data) > LARGEST_BYTES:
        raise JobError(f"{path.name} is larger than {LARGEST_BYTES} bytes; is it a {what}?")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise JobError(f"{path.name} is not UTF-8 text: {_odd_byte(data, error.start)}") from None


def toml_of(text: str, name: str) -> dict[str, Any]:
    """Return the tables of a TOML text; ``name`` is its file's, for messages.

    A decimal comma in a number that can be nothing else is read, with a warning.

    Raises
    ------
    JobError
        If it is not TOML, nests too deep, or holds a number of thousands of digits.
    """
    try:
        refuse_deep(text)
        table = tomllib.loads(text)
        if depth_of(table) > MAX_DEPTH:
            raise RecursionError(f"it nests deeper than {MAX_DEPTH} tables")
        return table
    except tomllib.TOMLDecodeError as error:
        pointed, commas = with_points(text)
        if commas:
            table = toml_of(pointed, name)
            for line, number in commas:
                tell(f"{name}, line {line}", number)
            return table
        raise JobError(f"{name} is not valid TOML: {_first_line(error)}{_slip(text, error)}") from None
    except (ValueError, RecursionError) as error:
        raise JobError(f"{name} is not usable TOML: {_first_line(error)}") from None


def refuse_deep(text: str) -> None:
    """Refuse a line of more dots and brackets than keys and lists of ``MAX_DEPTH`` levels have.

    The parser takes time and memory as the square of a key's parts: 40 kB of ``a.a.a`` take 1.6 GB. Texts and
    comments may hold as many dots as they like.

    Raises
    ------
    RecursionError
        With the line.
    """
    if all(_deepest(line) <= MAX_DEPTH for line in text.split("\n")):
        return
    bare = NO_KEYS.sub(lambda found: "\n" * found[0].count("\n"), text)
    for number, line in enumerate(bare.split("\n"), 1):
        if _deepest(line) > MAX_DEPTH:
            raise RecursionError(f"line {number} nests deeper than {MAX_DEPTH} tables")


def _deepest(line: str) -> int:
    """Return the largest nesting of a line: by the dots of a key, by brackets inside each other."""
    if line.count(".") + line.count("[") + line.count("{") <= MAX_DEPTH:
        return 0
    level = deepest = 0
    for each in line:
        level += (each in "[{") - (each in "]}")
        deepest = max(deepest, level)
    return max(deepest, *(part.count(".") for part in KEY_ENDS.split(line)))


def depth_of(values: Any) -> int:
    """Return the depth of nested tables and lists, without recursion."""
    level, depth = [values], 0
    while level:
        inner = [list(item.values()) if isinstance(item, dict) else item for item in level]
        level = [each for items in inner for each in items if isinstance(each, dict | list)]
        depth += 1
    return depth


def _odd_byte(data: bytes, place: int) -> str:
    """Return the first byte that is not UTF-8, its line, and what to do."""
    found = f"byte {place} is {data[place]:#x}"
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return f"{found}, as UTF-16 begins; save it as UTF-8"
    return f"{found}, in line {data.count(10, 0, place) + 1}; save it as UTF-8"


def _slip(text: str, error: tomllib.TOMLDecodeError) -> str:
    """Return the probable meaning of a line that is not TOML; empty if unknown."""
    found = re.search(r"at line (\d+)", str(error))
    lines = text.splitlines()
    if found is None or not 0 < int(found[1]) <= len(lines):
        return ""
    line = lines[int(found[1]) - 1]
    for slip, cure in WHOLE_LINE_SLIPS:
        if match := slip.search(line):
            return f"; {cure(match)}"
    outside = TEXTS_AND_COMMENTS.sub("", line)
    return next((f"; {cure(match)}" for slip, cure in SLIPS if (match := slip.search(outside))), "")


TEXTS_AND_COMMENTS = re.compile(r"\"[^\"]*\"|'[^']*'|#.*")
Cure = Callable[[re.Match[str]], str]
WHOLE_LINE_SLIPS: tuple[tuple[re.Pattern[str], Cure], ...] = (
    (re.compile(r'"[^"]*\\'), lambda _: "in paths write / for \\, or put the text in '...'"),
    (
        re.compile(r"=\s*([-+]?\d[\d.]*\s*(?:%|[A-Za-z][\w·/]*))\s*(?:#.*)?$"),
        lambda found: f'put a number and its unit in quotes: "{found[1]}"',
    ),
)
"""Words that users type that are not TOML, and their replacement."""
SLIPS: tuple[tuple[re.Pattern[str], Cure], ...] = (
    (
        re.compile(r"[-+]?\d+,\d{3}(?!\d)"),
        lambda found: f"write {found[0].replace(',', '.')} or {found[0].replace(',', '')}",
    ),
    (
        re.compile(r"[-+]?\d+,\d+"),
        lambda found: f"write a decimal point: {found[0].replace(',', '.')}",
    ),
    (re.compile(r"=\s*([-+]?\d{1,3}(?: \d{3})+)\s*$"), lambda found: f"write {found[1].replace(' ', '')}"),
    (re.compile(r"(?<![\d.])([-+]?)\.(\d+)"), lambda found: f"write {found[1]}0.{found[2]}"),
    (re.compile(r"(?<![\d.])([-+]?\d+)\.(?!\d)"), lambda found: f"write {found[1]}.0"),
)
"""The same outside of texts and comments."""


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [""])[0]


def with_points(text: str) -> tuple[str, list[tuple[int, str]]]:
    """Return a TOML text with points for decimal commas, and each such number with its line."""
    told: list[tuple[int, str]] = []
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):

        def point(found: re.Match[str], number: int = number) -> str:
            if not is_decimal(found[3], found[4]):
                return found[0]
            told.append((number, found[2]))
            return found[1] + found[2].replace(",", ".")

        lines[number - 1] = IN_TOML.sub(point, line)
    return "\n".join(lines), told


# Values as TOML text: what ``tomllib`` reads back to the same values.


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


# Single keys of a file set from outside: ``engine.throw[2].rods=2``.


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
