"""What fits where what was asked for does not: the widest hole, and the limit at which it ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping

STEP_MM = 0.5
"""Sizes that are named are multiples of it."""


def widest_mm(fits: Callable[[float], bool], asked_mm: float) -> float | None:
    """Return the widest hole below the one asked for that fits, on whole and half millimetres; None: none."""
    low, high = 0, round(asked_mm / STEP_MM + 0.499999)
    if high < 2:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(middle * STEP_MM) else (low, middle)
    return low * STEP_MM if low else None


def ended_by(eased: Mapping[str, Callable[[], bool]], otherwise: str) -> str:
    """Return the first limit without which what was asked for would fit; ``otherwise`` where none is."""
    return next((name for name, fits in eased.items() if fits()), otherwise)
