"""Tolerances of the cuts: usual workshop accuracies first, computed limits in small print beneath."""

from __future__ import annotations

import math
from collections.abc import Sequence

from reportlab.platypus import Flowable

from autobalance.paper.tables import Column, table
from autobalance.paper.tolerances import CARE_SHARE, ERROR_SHARE, USUAL_ACCURACY, Held, Tolerances
from autobalance.report.balance import kinds
from autobalance.report.display_units import DisplayUnits
from autobalance.types import Item
from autobalance.wording import NO_VALUE, listed_numbers

READING_ADVICE_SHARE = 0.5
"""Share of the remaining permissible value above which a reading is advised after machining."""


def held_words(held: Held, u: DisplayUnits) -> str:
    """Return the usual workshop accuracies, and the error of the resultant that they allow."""
    places, diameter = (_usual(USUAL_ACCURACY[key], u) for key in ("position_mm", "diameter_mm"))
    words = (
        f"Hold ±{places} and ±{USUAL_ACCURACY['angle_deg']:g}° (diameters ±{diameter}): then the crank"
        f" may be off by {u.of_unbalance(held.off_g_mm)}"
    )
    if held.left_g_mm > 0.0:
        words += f", of {u.of_unbalance(held.left_g_mm)} that the verdict leaves"
    return words + ("; finish by a reading (recut)." if held.share > READING_ADVICE_SHARE else ".")


def _usual(value_mm: float, u: DisplayUnits) -> str:
    """Return a usual accuracy in one digit: 0.1 mm, 0.004 in."""
    return f"{value_mm / u.mm_per_length:.1g} {u.length}"


def tolerance_table(
    tolerances: Tolerances, items: Sequence[Item], u: DisplayUnits, wide_mm: float
) -> Flowable:
    """List the tolerances of each kind's cuts."""
    columns = [
        Column("each", 22.0, "left"),
        Column("cuts", 72.0, "left"),
        Column("angle", 18.0),
        Column(f"position {u.length}", 20.0),
        Column(f"depth {u.length}", 20.0),
        Column(f"diameter {u.length}", 20.0),
    ]
    rows = []
    for kind, values in tolerances.by_kind.items():
        own = [item for item in items if item["kind"] == kind]
        rows.append(
            [
                kinds.noun(own[0]),
                f"No {listed_numbers(int(item['number']) for item in own)}",
                _plus_minus(values.get("angle_deg"), 3, "°"),
                *(
                    _plus_minus(
                        None if values.get(key) is None else values[key] / u.mm_per_length, u.length_digits
                    )
                    for key in ("position_mm", "depth_mm", "diameter_mm")
                ),
            ]
        )
    return table(wide_mm, columns, rows, row_mm=4.0)


def tolerance_words(tolerances: Tolerances) -> list[str]:
    """Return the share of the permissible value that the tolerances use, and advice where they are close."""
    lines = [
        f"± of each cut of a kind: usual workshop accuracy times {tolerances.factor:.2g}, from what each "
        f"error does to the unbalance. All errors of all cuts at their limits at once, the worst way round, "
        f"use {100.0 * tolerances.worst:.0f} % of what the verdict leaves (at most "
        f"{100.0 * ERROR_SHARE:.0f} % is given away); independent errors, as the root of the sum of squares, "
        f"{100.0 * tolerances.independent:.0f} %. "
        "Position: how far the axis may lie from its place, square to it; of a pocket, its outline."
    ]
    if tolerances.factor < CARE_SHARE:
        lines.append(
            "These are closer than a workshop usually holds: read the machined crank on the balancing "
            "machine, and finish by that reading (recut)."
        )
    return lines


def _plus_minus(value: float | None, digits: int, unit: str = "") -> str:
    """Return a tolerance cut to the decimals that it needs, at least ``digits``; never above its value."""
    if value is None:
        return NO_VALUE
    while digits < 7 and _cut(value, digits) < 0.95 * value:
        digits += 1
    return f"±{_cut(value, digits):.{digits}f}{unit}"


def _cut(value: float, digits: int) -> float:
    """Return a value cut after some decimals, safe from the rounding of binary fractions."""
    return math.floor(value * 10.0**digits + 1e-6) / 10.0**digits
