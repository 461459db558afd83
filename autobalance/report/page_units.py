"""Values of a report in the units of the page that is being written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextvars import ContextVar

from autobalance.report.display_units import KG_MM2_PER_LB_IN2, ON_SCREEN, DisplayUnits
from autobalance.wording import angle_deg, number

PAGE_UNITS: ContextVar[DisplayUnits] = ContextVar("PAGE_UNITS", default=ON_SCREEN["metric"])
"""The units of the page that is being written."""
PAGE_ZERO_DEG: ContextVar[float] = ContextVar("PAGE_ZERO_DEG", default=0.0)
"""The zero of its angles, counter-clockwise from crankpin 1: that of the sheet [°]."""


def unbalance(value_g_mm: float | None, digits: int = 2) -> str:
    """Return an unbalance in the page's units, without their name."""
    value, digits = shown(value_g_mm, "_g_mm", digits)
    return number(value, digits)


def heavy_at(vector_g_mm: Sequence[float], digits: int = 0) -> str:
    """Return the angle of an unbalance; a dash where the unbalance shows as zero."""
    return pointing(vector_g_mm, digits, "") or number(None)


def pointing(vector_g_mm: Sequence[float], digits: int = 0, before: str = " at ") -> str:
    """Return the angle of an unbalance after some text; empty where the unbalance shows as zero."""
    angle = (angle_deg(vector_g_mm) - PAGE_ZERO_DEG.get()) % 360.0
    return PAGE_UNITS.get().pointing(math.hypot(*vector_g_mm), angle, digits, before)


def length(value_mm: float | None, digits: int = 3) -> str:
    """Return a length in the page's units, without their name."""
    value, digits = shown(value_mm, "_mm", digits)
    return number(value, digits)


def mass(value_g: float | None, digits: int = 2) -> str:
    """Return a mass in the page's units, without their name."""
    value, digits = shown(value_g, "_g", digits)
    return number(value, digits)


def inertia_unit() -> str:
    return "kg·mm²" if PAGE_UNITS.get().is_metric else "lb·in²"


def shown(value: float | None, path: str, digits: int) -> tuple[float | None, int]:
    """Return a value in the page's units, chosen by the end of its key, and its decimals."""
    u = PAGE_UNITS.get()
    if u.is_metric or value is None:
        return value, digits
    ends = {
        "_kg_mm2": (KG_MM2_PER_LB_IN2, 4),
        "_g_mm": (u.g_mm_per_unbalance, u.unbalance_digits),
        "_mm": (u.mm_per_length, u.length_digits),
        "_g": (u.g_per_mass, u.mass_digits),
    }
    for end, (per, own) in ends.items():
        if path.endswith(end) or f"{end}." in path.rpartition(".")[0] + ".":
            return value / per, own
    return value, digits
