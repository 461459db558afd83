"""One table of a TOML file, read strictly: every key is known, typed and possible, or named in an error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from autobalance.declare import ANY, MIN_POSITIVE, POSITIVE, Range
from autobalance.errors import JobError
from autobalance.toml_files.convert import convert, did_you_mean, shown


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
