"""Ways in which limits that fall short may be relaxed, and those that several kinds share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from autobalance.quantities import mm, said


@dataclass(frozen=True)
class MoreCuts:
    """Largest number of cuts, which may rise.

    Attributes
    ----------
    key : str
        Of the limits.
    now : int
        Present value.
    text : str
        Template of the description: ``{more}`` cuts, up to a number ``{to}``, and the plural's ``{s}``.
    """

    key: str
    now: int
    text: str

    def say(self, more: int) -> str:
        """Return the description of a number of further cuts."""
        return self.text.format(more=more, to=self.now + more, s="" if more == 1 else "s")


@dataclass(frozen=True)
class WiderLimits:
    """Limit on cuts, which may widen.

    Attributes
    ----------
    key : str
        Of the limits.
    now : float
        Present value.
    greatest_change : float
        Share of that by which it may change, negative where it shrinks.
    text : callable
        (new value, difference) → the description.
    """

    key: str
    now: float
    greatest_change: float
    text: Callable[[float, float], str]

    def changed(self, share: float) -> dict[str, float]:
        """Return the limit widened by a share 0 to 1 of the largest change."""
        return {self.key: self.now * (1.0 + share * self.greatest_change)}

    def say(self, changed: Mapping[str, float]) -> str:
        """Return the description of a widened limit."""
        to = changed[self.key]
        return self.text(to, to - self.now)


@dataclass(frozen=True)
class Otherwise:
    """Alternative limits: fields to replace, and a description."""

    changed: Mapping[str, Any]
    text: str


Relaxing = MoreCuts | WiderLimits | Otherwise

MAX_DEPTH_RATIO = 3.0
"""Largest multiple of a depth that is tried."""
MAX_WALL_REDUCTION = 0.5
"""Largest share of a wall that is given up."""


def deeper(max_depth_mm: float | None) -> tuple[WiderLimits, ...]:
    """Return the way to a larger ``max_depth_mm``; empty if it cannot grow."""
    if max_depth_mm is None:
        return ()

    def text(to: float, by: float) -> str:
        return said("deeper by {} (max_depth_mm = {})", mm(by, ".2g"), f"{to:.3g}")

    return (WiderLimits("max_depth_mm", max_depth_mm, MAX_DEPTH_RATIO - 1.0, text),)


def thinner(min_wall_mm: float | None) -> tuple[WiderLimits, ...]:
    """Return the way to a smaller ``min_wall_mm``; empty if it cannot shrink."""
    if not min_wall_mm:
        return ()

    def text(to: float, by: float) -> str:
        del by
        return said("a wall of {} (min_wall_mm)", mm(to, ".3g"))

    return (WiderLimits("min_wall_mm", min_wall_mm, -MAX_WALL_REDUCTION, text),)
