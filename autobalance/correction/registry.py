"""Registry of the kinds of correction, and the order in which corrections are made."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np

from autobalance.correction.contract import Correction, Cut, Limits, setting_of
from autobalance.correction.kind import Kind, Workpiece
from autobalance.correction.overlap import Overlap
from autobalance.crank.anatomy import Anatomy, Face
from autobalance.solid.csg.solid import Solid
from autobalance.units import wrapped_deg

# Registry of the kinds of correction, by their names and their limits.


_KINDS: dict[str, Kind[Any]] = {}
KINDS: Mapping[str, Kind[Any]] = MappingProxyType(_KINDS)
"""Every kind by its name, in the order of registration."""


def register(kind: Kind[Any]) -> None:
    """Register a kind of correction.

    Raises
    ------
    TypeError
        If it lacks an attribute of `Kind`, or its name or limits are taken.
    """
    for fault in _faults(kind):
        raise TypeError(f"{type(kind).__name__} is not a kind of correction: {fault}")
    _KINDS[kind.name] = kind


def _faults(kind: Kind[Any]) -> Iterator[str]:
    for text in ("name", "verb", "noun", "datum"):
        value = getattr(kind, text, None)
        if not isinstance(value, str) or not value.strip():
            yield f"its {text} is {value!r}; expected a text"
            return
    if not kind.name.isidentifier() or kind.name != kind.name.lower():
        yield f"its name is {kind.name!r}; expected a key of lower-case letters"
    if kind.name in _KINDS:
        yield f"the name {kind.name!r} is taken"
    limits = getattr(kind, "limits", None)
    if not (isinstance(limits, type) and issubclass(limits, Limits) and limits is not Limits):
        yield f"its limits are {limits!r}; expected a class derived from Limits"
        return
    if any(other.limits is limits for other in _KINDS.values()):
        yield f"the limits {limits.__name__} are another kind's"
    if not is_dataclass(limits) or "__dataclass_fields__" not in vars(limits):
        yield f"its limits {limits.__name__} are not a dataclass"
        return
    for each in fields(limits):
        if each.default is MISSING and each.default_factory is MISSING:
            yield f"{limits.__name__}.{each.name} has no default; expected one: method alone is enough"
    if kind.search_levels < 1:
        yield f"search_levels is {kind.search_levels}; expected 1 or more"
    if kind.remedy is not None and not isinstance(kind.remedy, limits):
        yield f"its remedy is {kind.remedy!r}; expected {limits.__name__}"


def kind_of(limits: Limits) -> Kind[Any]:
    return next(kind for kind in _KINDS.values() if type(limits) is kind.limits)


def finishing(methods: Sequence[Limits]) -> Limits:
    """Return the limits of a kind that makes the last cuts on the machine: a job's own, else the defaults."""
    for limits in methods:
        if kind_of(limits).finishes:
            return limits
    return next(kind for kind in _KINDS.values() if kind.finishes).limits()


def face_depths_mm(
    solid: Solid, anatomy: Anatomy, density_g_mm3: float, faces: tuple[Face, ...], rims: Sequence[Face]
) -> dict[str, float]:
    """Return the largest default depths of faces and rims, by their ids, where metal limits them."""
    nowhere = (0.0, np.zeros(2))
    work = Workpiece(solid, anatomy, faces, density_g_mm3, (nowhere, nowhere))
    depths: dict[str, float] = {}
    for kind in _KINDS.values():
        depths |= kind.face_depths_mm(work, rims)
    return depths


def mixes() -> tuple[tuple[str, ...], ...]:
    """Return the names of the kinds that ``compare`` tries: each alone, then with those it is mixed with."""
    alone = [(name,) for name in _KINDS]
    return (*alone, *((name, other) for name, kind in _KINDS.items() for other in kind.mixed_with))


# The order in which corrections are made: set-up by set-up (side, then tool), web by web, by angle.
#
# The angles of a web begin behind its largest gap: a row of holes across 0° is one sweep of the indexing
# head.


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
