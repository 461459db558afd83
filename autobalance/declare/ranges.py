"""Ranges of numbers, sizes of lists and patterns of texts, for readers, schemas and messages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

MIN_POSITIVE = 1e-9
"""Smallest positive number where one is needed: dividing by less overflows."""


@dataclass(frozen=True)
class TypedIn:
    """Optional unit of a typed number, where the name of its key does not end in one."""

    unit: str


@dataclass(frozen=True)
class Size:
    """Smallest and largest number of entries of a list."""

    least: int = 0
    most: int | None = None

    def schema(self) -> dict[str, Any]:
        """Return the size as keywords of JSON Schema."""
        least = {"minItems": self.least} if self.least else {}
        return least if self.most is None else {**least, "maxItems": self.most}


@dataclass(frozen=True)
class Pattern:
    """Regular expression that a text follows, and its smallest length."""

    expression: str = ""
    least: int = 0

    def schema(self) -> dict[str, Any]:
        """Return them as keywords of JSON Schema."""
        pattern = {"pattern": self.expression} if self.expression else {}
        return {**pattern, "minLength": self.least} if self.least else pattern


@dataclass(frozen=True)
class Range:
    """Range of a number.

    ``text`` names it in a message. ``least`` and ``most`` may be reached, ``above`` and ``below`` may not.
    The absolute value must be above ``apart``. ``besides`` are numbers that are permitted in any case, and
    ``one_of`` the only permitted ones, if there are few.
    """

    text: str = ""
    least: float | None = None
    most: float | None = None
    above: float | None = None
    below: float | None = None
    apart: float | None = None
    besides: tuple[float, ...] = ()
    one_of: tuple[float, ...] = ()

    def holds(self, number: float) -> bool:
        if self.one_of:
            return number in self.one_of
        within = (
            (self.least is None or number >= self.least)
            and (self.most is None or number <= self.most)
            and (self.above is None or number > self.above)
            and (self.below is None or number < self.below)
            and (self.apart is None or abs(number) > self.apart)
        )
        return within or number in self.besides

    def schema(self) -> dict[str, Any]:
        """Return the range as keywords of JSON Schema."""
        if self.one_of:
            return {"enum": list(self.one_of)}
        named = {
            "minimum": self.least,
            "maximum": self.most,
            "exclusiveMinimum": self.above,
            "exclusiveMaximum": self.below,
        }
        limits: dict[str, Any] = {word: value for word, value in named.items() if value is not None}
        if self.apart is not None:
            limits["anyOf"] = [{"exclusiveMinimum": self.apart}, {"exclusiveMaximum": -self.apart}]
        if not self.besides:
            return limits
        return {"anyOf": [limits, {"enum": list(self.besides)}]}


ANY = Range()
POSITIVE = Range("must be > 0", above=0.0)
NOT_NEGATIVE = Range("must be ≥ 0", least=0.0)
SHARE = Range("must be 0 to 1", least=0.0, most=1.0)
COUNTED = Range("must be ≥ 1", least=1)
