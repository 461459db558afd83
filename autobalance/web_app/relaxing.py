"""What a report proposes where the limits fall short, as changes of the job that a button can make."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any

Change = dict[str, Any]

FACTOR = re.compile(r"a balance factor of ([0-9.]+) can be reached as it is")
COUNT = re.compile(r"[^;,:]*\((max_holes|max_slugs) = (\d+)\)")
DEEPER = re.compile(r"deeper by [^;,(]*\((max_depth_mm) = ([0-9.]+)\)")
WALL = re.compile(r"a wall of ([0-9.]+) mm \((min_wall_mm)\)")
SLUG = re.compile(r"one axial slug of ([0-9.]+) × ([0-9.]+) mm \(([0-9.e+]+) kg/m³\)[^;,]*")
DIGITS = 3
"""To so many digits the limits are told; a button goes one step further, so that they suffice."""


def proposed(report: Mapping[str, Any]) -> list[Change]:
    """Return the relaxations of a report's ``reason``: ``text``, and ``changes``: dotted keys of the job.

    A limit is rounded to the side on which it still suffices.

    Examples
    --------
    >>> job = {"correction": {"method": ["drill"], "drill": {"max_depth_mm": 5.0}}}
    >>> reason = (
    ...     "...; enough would be: deeper by 1.2 mm (max_depth_mm = 6.24); "
    ...     "a balance factor of 0.3100 can be reached as it is"
    ... )
    >>> for each in proposed({"job": job, "reason": reason}):
    ...     print(each["changes"])
    {'correction.drill.max_depth_mm': 6.25}
    {'balance.factor': 0.31}
    """
    reason = report.get("reason") or ""
    found: list[Change] = []
    for pattern, changes in _PATTERNS:
        for match in pattern.finditer(reason):
            made = changes(match, report["job"]["correction"])
            if made:
                found.append({"text": match.group(0).strip().removeprefix("or "), "changes": made})
    return found


def _count(match: re.Match[str], correction: Mapping[str, Any]) -> Change:
    return _limit(correction, match.group(1), int(match.group(2)))


def _deeper(match: re.Match[str], correction: Mapping[str, Any]) -> Change:
    return _limit(correction, match.group(1), _beyond(float(match.group(2)), up=True))


def _wall(match: re.Match[str], correction: Mapping[str, Any]) -> Change:
    return _limit(correction, match.group(2), _beyond(float(match.group(1)), up=False))


def _factor(match: re.Match[str], _: Mapping[str, Any]) -> Change:
    return {"balance.factor": float(match.group(1))}


def _slug(match: re.Match[str], correction: Mapping[str, Any]) -> Change:
    diameter, length, density = (float(each) for each in match.groups())
    return {
        "correction.method": [*correction["method"], "slug"],
        "correction.slug.direction": "axial",
        "correction.slug.diameters_mm": [diameter],
        "correction.slug.lengths_mm": [length],
        "correction.slug.density_kg_m3": density,
    }


_PATTERNS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str], Mapping[str, Any]], Change]], ...] = (
    (COUNT, _count),
    (DEEPER, _deeper),
    (WALL, _wall),
    (SLUG, _slug),
    (FACTOR, _factor),
)


def _limit(correction: Mapping[str, Any], key: str, value: float) -> Change:
    """Return a limit of the methods that have it."""
    tables = {name: correction.get(name) for name in correction["method"]}
    return {
        f"correction.{name}.{key}": value
        for name, table in tables.items()
        if isinstance(table, Mapping) and table.get(key) is not None
    }


def _beyond(value: float, up: bool) -> float:
    step = 10.0 ** (math.floor(math.log10(abs(value))) - DIGITS + 1)
    return round(value + (step if up else -step), 9)
