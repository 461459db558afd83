"""Widest hole that fits where the one in the job does not, and the limit at which it ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping

STEP_MM = 0.5
"""Step of the sizes tried."""


def widest_mm(fits: Callable[[float], bool], asked_mm: float) -> float | None:
    """Return the widest hole below ``asked_mm`` that fits, on whole and half millimetres; None: none."""
    low, high = 0, round(asked_mm / STEP_MM + 0.499999)
    if high < 2:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(middle * STEP_MM) else (low, middle)
    return low * STEP_MM if low else None


def ended_by(eased: Mapping[str, Callable[[], bool]], otherwise: str) -> str:
    """Return the first limit without which the hole in the job would fit; else ``otherwise``."""
    return next((name for name, fits in eased.items() if fits()), otherwise)
