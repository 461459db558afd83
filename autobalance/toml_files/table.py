"""One table of a TOML file, read strictly: every key is known, typed and possible, or named in an error."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from types import UnionType
from typing import Any, Final, Literal, Union, get_args, get_origin

from autobalance.declare import ANY, MIN_POSITIVE, POSITIVE, Large, Range
from autobalance.errors import DecimalCommaWarning, JobError

# A value of a TOML file, checked against a Python type; nothing is coerced but whole numbers to floats.


MAX_NUMBER = 1e9
"""Size of a number at most: beyond is not a mass, length or speed of a crankshaft, and squares overflow."""

LARGEST_OF_ALL = 1e15


def convert(value: object, hint: Any, where: str) -> Any:
    """Return a TOML value as the type ``hint`` asks.

    Parameters
    ----------
    value : object
        As ``tomllib`` read it.
    hint : type
        ``float``, ``int``, ``bool``, ``str``, a ``Literal``, ``tuple[T, ...]``, ``tuple[T, T]`` or a union.
    where : str
        The key with its table path, for messages.

    Returns
    -------
    object
        Lists become tuples, whole numbers floats where a float is asked.

    Raises
    ------
    JobError
        If the type is another, or a number is not finite.

    Examples
    --------
    >>> convert([1, 2.5], tuple[float, float], "balance.tolerance_planes_mm")
    (1.0, 2.5)
    """
    origin = get_origin(hint)
    if origin is Literal:
        return _one_of(value, get_args(hint), where)
    if origin in (Union, UnionType):
        return _either(value, get_args(hint), where)
    if origin is tuple:
        return _listed(value, hint, where)
    if hint is float:
        return _number(value, where)
    if hint is Large:
        return _number(value, where, LARGEST_OF_ALL)
    if not isinstance(value, hint) or (hint is int and isinstance(value, bool)):
        raise JobError(f"{where} is {shown(value)}; must be {needed(hint)}")
    if isinstance(value, str) and "\0" in value:  # the system takes no such name of a file
        raise JobError(f"{where} is {shown(value)}; must have no NUL character")
    if hint is int and abs(value) > MAX_NUMBER:
        raise JobError(f"{where} is {shown(value)}; must be at most {MAX_NUMBER:g} in size")
    return value


def _number(value: object, where: str, largest: float = MAX_NUMBER) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise JobError(f"{where} is {shown(value)}; must be a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise JobError(f"{where} is {number}; must be a finite number")
    if abs(number) > largest:
        raise JobError(f"{where} is {number:g}; must be at most {largest:g} in size")
    return number


def _one_of(value: object, choices: Sequence[object], where: str) -> object:
    if isinstance(value, str) and value in choices:
        return value
    listed = ", ".join(repr(choice) for choice in choices)
    text = f"{where} is {shown(value)}; must be {'one of ' if len(choices) > 1 else ''}{listed}"
    raise JobError(text + did_you_mean(value, choices))


def _either(value: object, hints: Sequence[Any], where: str) -> Any:
    """Return the value as the alternative whose outer kind fits; its inner errors name the place."""
    hints = [hint for hint in hints if hint is not type(None)]
    if len(hints) == 1:
        return convert(value, hints[0], where)
    for hint in hints:
        if _fits(value, hint):
            return convert(value, hint, where)
    words = [word for hint in hints if get_origin(hint) is Literal for word in get_args(hint)]
    close = did_you_mean(value, words) if isinstance(value, str) else ""
    ways = [
        "a list of them" if get_origin(each) is tuple and get_args(each)[0] in hints[:place] else needed(each)
        for place, each in enumerate(hints)
    ]
    raise JobError(f"{where} is {shown(value)}; must be {' or '.join(ways)}{close}")


def _fits(value: object, hint: Any) -> bool:
    origin = get_origin(hint)
    if origin is Literal:
        return value in get_args(hint)
    if origin is tuple:
        return isinstance(value, list)
    if hint in (float, Large):
        return isinstance(value, int | float) and not isinstance(value, bool)
    return isinstance(value, hint) and not (hint is int and isinstance(value, bool))


def _listed(value: object, hint: Any, where: str) -> tuple[Any, ...]:
    inner = get_args(hint)
    if not isinstance(value, list):
        example = f": [{shown(value)}]" if inner[-1] is Ellipsis and _fits(value, inner[0]) else ""
        raise JobError(f"{where} is {shown(value)}; must be {needed(hint)}{example}")
    if inner[-1] is Ellipsis:
        inner = (inner[0],) * len(value)
    if len(value) != len(inner):
        raise JobError(f"{where} has {len(value)} entries; must be {needed(hint)}")
    return tuple(
        convert(item, kind, f"{where}[{place}]")
        for place, (item, kind) in enumerate(zip(value, inner, strict=True), 1)
    )


EXPECTED_TYPES = {
    float: "a number",
    Large: "a number",
    int: "a whole number",
    bool: "true or false",
    str: "a text",
}


def needed(hint: Any) -> str:
    """Return a type hint's requirement in words."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin is Literal:
        return " or ".join(repr(choice) for choice in inner)
    if origin in (Union, UnionType):
        return " or ".join(needed(each) for each in inner if each is not type(None))
    if origin is tuple and inner[-1] is Ellipsis:
        return f"a list, each entry {needed(inner[0])}"
    if origin is tuple:
        return f"a list of {len(inner)} entries, each {needed(inner[0])}"
    return EXPECTED_TYPES[hint]


def shown(value: object) -> str:
    """Return a value as the TOML file has it, shortened."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, str):
        return repr(value if len(value) <= 60 else value[:57] + "...")
    if isinstance(value, list):
        return "a list"
    if isinstance(value, int) and value.bit_length() > 64:
        return "a very large number"
    return str(value)


def did_you_mean(word: object, known: Sequence[object]) -> str:
    """Return ``; did you mean ...?`` where a known word is close, else nothing."""
    close = get_close_matches(str(word), [str(each) for each in known], n=1, cutoff=0.6)
    return f"; did you mean {close[0]!r}?" if close else ""


# --- decimal commas: a comma separates in TOML, but 221,5 can be nothing else than 221.5 ---


COMMA_NUMBER: Final = r"[+-]?(\d+),(\d+)"
"""A number with one comma: its digits before and after it."""
TYPED = re.compile(rf"{COMMA_NUMBER}(?![.,\d])")
THOUSANDS: Final = 3
"""Digits of a group of thousands."""


def is_decimal(whole: str, fraction: str) -> bool:
    """Return whether the comma between digits can be nothing but a decimal point.

    Examples
    --------
    >>> is_decimal("221", "5"), is_decimal("15", "200"), is_decimal("0", "284"), is_decimal("1234", "567")
    (True, False, True, True)
    """
    return len(fraction) != THOUSANDS or whole.startswith("0") or len(whole) > THOUSANDS


def point_for_comma(text: str) -> str:
    """Return a typed number with its unit with a point for a decimal comma; other texts as they are.

    Examples
    --------
    >>> point_for_comma("221,5 g"), point_for_comma("15,200"), point_for_comma("8, 5"), point_for_comma("0.5")
    ('221.5 g', '15,200', '8, 5', '0.5')
    """
    found = TYPED.match(text.strip())
    if found is None or not is_decimal(found[1], found[2]):
        return text
    return text.replace(",", ".", 1)


def tell(where: str, typed: str) -> None:
    """Warn of a number that was read with its comma as the decimal point."""
    read = typed.strip().replace(",", ".", 1)
    words = f"{where}: {typed.strip()} is read as {read}; the comma is a decimal point"
    warnings.warn(words, DecimalCommaWarning, stacklevel=2)


class Table:
    """A TOML table and its path in the file.

    Raises
    ------
    JobError
        On construction, if ``raw`` is not a table or holds a key that is not ``known`` (None: any).
    """

    def __init__(self, raw: object, path: str, known: Sequence[str] | None) -> None:
        if not isinstance(raw, dict):
            raise JobError(f"{path} is {shown(raw)}; must be a table: [{path}]")
        self.raw: dict[str, object] = raw
        self.path = path
        if known is not None and (unknown := unknown_keys(self, known)):
            raise JobError(*unknown)

    def place(self, key: str) -> str:
        """Return a key with its table path."""
        return f"{self.path}.{key}" if self.path else key

    def __contains__(self, key: str) -> bool:
        return key in self.raw

    def value(self, key: str, hint: Any, rule: Range = ANY) -> Any:
        """Return a required value as the type ``hint`` asks.

        Raises
        ------
        JobError
            If it is missing, of another type, or breaks the rule (each number of it, where it is a list).
        """
        if key not in self.raw:
            raise JobError(f"{self.place(key)} is missing" + (f"; it {rule.text}" if rule.text else ""))
        value = convert(self.raw[key], hint, self.place(key))
        for number in _numbers(value):
            if not rule.holds(number):
                raise JobError(f"{self.place(key)} is {number:g}; {rule.text}")
            if rule is POSITIVE and number < MIN_POSITIVE:
                raise JobError(f"{self.place(key)} is {number:g}; must be at least {MIN_POSITIVE:g}")
        return value

    def table(self, key: str, known: Sequence[str] | None) -> Table:
        """Return a table inside this one; empty where it is absent."""
        return Table(self.raw.get(key, {}), self.place(key), known)

    def tables(self, key: str, known: Sequence[str]) -> list[Table]:
        """Return the tables of an array of tables; none where it is absent."""
        raw = self.raw.get(key, [])
        if not isinstance(raw, list):
            path = self.place(key)
            raise JobError(f"{path} is {shown(raw)}; must be a list of tables: [[{path}]]")
        return [Table(item, f"{self.place(key)}[{place}]", known) for place, item in enumerate(raw, 1)]


def unknown_keys(table: Table, known: Sequence[str], below: Mapping[str, str] | None = None) -> list[str]:
    """Return a message for each unknown key of a table; the first lists the known keys.

    ``below`` are keys of tables inside, each with its path from here: one that is a level too high.
    """
    lines, listed = [], f"; known here: {', '.join(known)}"
    for key in table.raw:
        if key not in known:
            path = (below or {}).get(key)
            close = f"; did you mean {table.place(path)}?" if path else did_you_mean(key, known)
            lines.append(f"{table.place(key)} is an unknown key{close or listed}")
            listed = listed if close else ""
    return lines


def _numbers(value: object) -> list[float]:
    if isinstance(value, tuple):
        return [number for item in value for number in _numbers(item)]
    return [value] if isinstance(value, int | float) and not isinstance(value, bool) else []


# Faults of a file, gathered so that all of them are reported at once.


class Faults:
    """Errors so far, a line each."""

    def __init__(self, *lines: str) -> None:
        self.lines = list(lines)

    @contextmanager
    def gathered(self) -> Iterator[None]:
        """Keep an error for later and continue behind the block."""
        try:
            yield
        except JobError as error:
            self.lines += error.lines

    def with_more(self, later: Faults) -> Faults:
        """Return these faults and later ones of other keys."""
        known = [line.split(maxsplit=1)[0] for line in self.lines]
        return Faults(*self.lines, *(line for line in later.lines if not _is_about(line, known)))

    def refuse(self) -> None:
        """Raise all that was gathered, in its order.

        Raises
        ------
        JobError
            If there is anything.
        """
        if self.lines:
            raise JobError(*dict.fromkeys(self.lines))


def _is_about(line: str, keys: list[str]) -> bool:
    """Return whether a line begins with a key, or a key in it; a density's material may be there."""
    name = line.split(maxsplit=1)[0].rstrip(":,;")
    return any(name == key or name.startswith((f"{key}.", f"{key}[", f"{key}_kg_m3")) for key in keys)
