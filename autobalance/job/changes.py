"""Differences between two jobs, key by key, in words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple


class Difference(NamedTuple):
    """A value that two jobs have differently; None where one of them lacks it."""

    key: str
    was: Any
    now: Any

    def words(self) -> str:
        """Return both values in words.

        Examples
        --------
        >>> Difference("engine.stroke_mm", 50.0, None).words()
        'engine.stroke_mm was 50.0, is not set now'
        """

        def shown(value: Any) -> str:
            return "not set" if value is None else repr(value)

        return f"{self.key} was {shown(self.was)}, is {shown(self.now)} now"


def differences(was: Any, now: Any, key: str = "") -> Iterator[Difference]:
    """Yield the differences between two jobs, or two tables at a key; an empty table counts as missing."""
    if isinstance(was, dict | None) and isinstance(now, dict | None) and was != now:
        was, now = was or {}, now or {}
        for name in [*now, *(each for each in was if each not in now)]:
            yield from differences(was.get(name), now.get(name), f"{key}.{name}" if key else name)
    elif _are_tables(was) and _are_tables(now) and len(was) == len(now):
        for number, (one, other) in enumerate(zip(was, now, strict=True), 1):
            yield from differences(one, other, f"{key}[{number}]")
    elif was != now:
        yield Difference(key, was, now)


def _are_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(each, dict) for each in value)
