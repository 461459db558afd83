"""Numbers and names as people read them: fixed digits, real minus signs, escaped text."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Mapping
from typing import Any

from autobalance.units import wrapped_deg

OUTCOMES = {
    "within_tolerance": "Within tolerance",
    "already_within_tolerance": "Already within tolerance",
    "above_tolerance": "Above tolerance",
}
NOT_PROVEN = ", not proven"
NO_VALUE = "–"


def escape(text: object) -> str:
    """Return text escaped for HTML, quotes too."""
    return html.escape(str(text), quote=True)


def number(value: float | None, digits: int = 2) -> str:
    """Return a number with fixed decimals and thin spaces between thousands; a dash for None.

    Examples
    --------
    >>> number(12445.664, 1), number(-0.001), number(None)
    ('12\u202f445.7', '0.00', '–')
    """
    if value is None or not math.isfinite(value):
        return "–"
    text = f"{abs(value):,.{digits}f}".replace(",", "\u202f")
    negative = value < 0.0 and any(c in "123456789" for c in text)
    return f"−{text}" if negative else text


def bare(value: float) -> str:
    """Return a number with three decimals at most, without zeros at its end.

    Examples
    --------
    >>> bare(11.90625), bare(12.0)
    ('11.906', '12')
    """
    return f"{value:.3f}".rstrip("0").rstrip(".")


def percent(share: float) -> str:
    """Return a share in percent, to three digits; whole from 100 % on.

    Examples
    --------
    >>> percent(0.0421), percent(0.977), percent(159.3)
    ('4.21 %', '97.7 %', '15\u202f930 %')
    """
    value = 100.0 * share
    return f"{number(value, 0 if value >= 99.95 else 1 if value >= 9.995 else 2)} %"


def signed(value: float | None, digits: int = 2) -> str:
    """Return a number with its sign, plus too; zero without a sign."""
    text = number(value, digits)
    positive = value is not None and value > 0.0 and any(c in "123456789" for c in text)
    return f"+{text}" if positive else text


def angle_deg(vector: Any) -> float:
    """Return the direction of a vector in the xy plane, 0 to below 360 [deg]."""
    return wrapped_deg(math.degrees(math.atan2(vector[1], vector[0])))


def degrees(value_deg: float, digits: int = 1) -> str:
    """Return an angle with fixed decimals, from 0 to below 360 as it is shown.

    Examples
    --------
    >>> degrees(359.97), degrees(-0.5)
    ('0.0°', '359.5°')
    """
    return f"{round(value_deg % 360.0, digits) % 360.0:.{digits}f}°"


def listed_numbers(numbers: Iterable[int]) -> str:
    """Return numbers in runs.

    Examples
    --------
    >>> listed_numbers([1, 2, 3, 7])
    '1-3, 7'
    """
    runs: list[list[int]] = []
    for each in sorted(numbers):
        if runs and each == runs[-1][1] + 1:
            runs[-1][1] = each
        else:
            runs.append([each, each])
    return ", ".join(f"{first}" if first == last else f"{first}-{last}" for first, last in runs)


def at(report: Mapping[str, Any], path: str) -> Any:
    """Return the value at a dotted path, ``planes.0.z_mm``; None where the path ends early."""
    here: Any = report
    for key in path.split("."):
        if isinstance(here, list):
            here = here[int(key)] if int(key) < len(here) else None
        else:
            here = here.get(key) if isinstance(here, Mapping) else None
    return here
