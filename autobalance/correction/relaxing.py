"""Ways in which limits that fall short may be relaxed, and those that several kinds share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class MoreCuts:
    """A count of limits that may rise: its key, what it is now, and what to say of ``more``."""

    key: str
    now: int
    say: Callable[[int], str]


@dataclass(frozen=True)
class WiderLimits:
    """Limits that may widen: fields to replace for a share 0 to 1 of the widest, and what to say of them."""

    changed: Callable[[float], dict[str, float]]
    say: Callable[[dict[str, float]], str]


@dataclass(frozen=True)
class Otherwise:
    """Limits that may be chosen otherwise: fields to replace, and what to say of it."""

    changed: Mapping[str, Any]
    text: str


Relaxing = MoreCuts | WiderLimits | Otherwise

DEEPER = 3.0
"""How many times deeper is tried, at most."""
THINNER = 0.5
"""Share of a wall that is given up, at most."""


def deeper(max_depth_mm: float | None) -> tuple[WiderLimits, ...]:
    """Return a greater ``max_depth_mm``, where there is one."""
    if max_depth_mm is None:
        return ()
    now = max_depth_mm

    def changed(share: float) -> dict[str, float]:
        return {"max_depth_mm": now * (1.0 + share * (DEEPER - 1.0))}

    def say(to: dict[str, float]) -> str:
        return f"deeper by {to['max_depth_mm'] - now:.2g} mm (max_depth_mm = {to['max_depth_mm']:.3g})"

    return (WiderLimits(changed, say),)


def thinner(min_wall_mm: float | None) -> tuple[WiderLimits, ...]:
    """Return a smaller ``min_wall_mm``, where there is one."""
    if not min_wall_mm:
        return ()
    now = min_wall_mm

    def changed(share: float) -> dict[str, float]:
        return {"min_wall_mm": now * (1.0 - share * THINNER)}

    return (WiderLimits(changed, lambda to: f"a wall of {to['min_wall_mm']:.3g} mm (min_wall_mm)"),)
