"""The order in which corrections are made: set-up by set-up (side, then tool), web by web, by angle.

The angles of a web begin behind its largest gap: a row of holes across 0° is one sweep of the indexing head.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from autobalance.correction.contract import Correction, Cut, setting_of
from autobalance.correction.overlap import Overlap
from autobalance.correction.registry import KINDS
from autobalance.units import wrapped_deg

MIN_AXIAL_COMPONENT = 0.9
"""Component along the crank axis from which a tool comes from an end and not from the side."""
ANGLE_DIGITS = 6
"""Angles that differ by less than rounding are one."""
SAME_GAP_DEG = 0.5
"""Difference below which gaps are equal, and the first one counts."""
_Key = tuple[int, str, float, str, int, float]
ROUND_THE_RIM, FROM_BELOW, FROM_ABOVE, FROM_THE_SIDE = range(4)


def side_rank(correction: Correction) -> int:
    """Return the rank of a tool's side: all around (a lathe's work), −z, +z, or square to the axis."""
    kind = KINDS[correction.kind]
    if kind.is_round_the_rim:
        return ROUND_THE_RIM
    along = 0.0 if correction.axis is None else float(correction.axis[2])
    if kind.adds_metal:
        along = -along
    if abs(along) < MIN_AXIAL_COMPONENT:
        return FROM_THE_SIDE
    return FROM_ABOVE if along < 0.0 else FROM_BELOW


def setup_order(
    corrections: Sequence[Correction], cuts: Sequence[Cut], overlaps: Sequence[Overlap] = ()
) -> list[int]:
    """Return the indices of corrections (of ``cuts``, one each) in the order in which they are made.

    Of two with common metal the one that took it stays before the other.
    """
    key = _by_index([_key(*each) for each in zip(corrections, cuts, strict=True)])
    left = sorted(range(len(key)), key=key.__getitem__)
    before = {(pair.first, pair.second) for pair in overlaps}
    order: list[int] = []
    while left:
        free = (k for k in left if not any((other, k) in before for other in left))
        order.append(next(free, left[0]))
        left.remove(order[-1])
    return order


def _by_index(keys: Sequence[_Key]) -> list[_Key]:
    """Return keys whose angles count on beyond 360° behind the largest gap of their web."""
    rows: dict[tuple[Any, ...], list[float]] = {}
    for key in keys:
        rows.setdefault(key[:-1], []).append(key[-1])
    starts = {row: _start_deg(angles) for row, angles in rows.items()}
    return [(*key[:-1], key[-1] + 360.0 * (key[-1] < starts[key[:-1]])) for key in keys]


def _start_deg(angles: Sequence[float]) -> float:
    """Return the angle behind the largest gap; the smallest one where that gap is across 0°."""
    ordered = sorted(set(angles))
    gaps = [(ordered[0] - ordered[-1]) % 360.0 or 360.0, *(b - a for a, b in pairwise(ordered))]
    largest = max(gaps)
    return next(angle for angle, gap in zip(ordered, gaps, strict=True) if gap >= largest - SAME_GAP_DEG)


def _key(correction: Correction, cut: Cut) -> _Key:
    angle = wrapped_deg(math.degrees(math.atan2(correction.position_mm[1], correction.position_mm[0])))
    return (
        side_rank(correction),
        correction.kind,
        float(correction.details.get("diameter_mm", 0.0)),
        setting_of(cut),
        correction.web or 0,
        round(angle, ANGLE_DIGITS) % 360.0,
    )
