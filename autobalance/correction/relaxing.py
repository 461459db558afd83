"""Refusals of impossible limits, and ways in which limits that fall short may be relaxed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, get_type_hints

from autobalance.crank.anatomy import Anatomy
from autobalance.declare import Range
from autobalance.errors import CorrectionError
from autobalance.quantities import mm, said
from autobalance.value_classes import dataclass

# Ways in which limits that fall short may be relaxed, and those that several kinds share.


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


# Refusals of impossible limits that kinds of correction share.


Direction = Literal["radial", "axial"]
Sectors = tuple[tuple[float, float], ...]
ALL_AROUND: Sectors = ((0.0, 360.0),)


def refuse_direction(kind: str, direction: str) -> None:
    if direction not in ("radial", "axial"):
        raise CorrectionError(f"{kind}.direction is {direction!r}; must be 'radial' or 'axial'")


FINEST_STEP_MM = 1e-6
"""Finest step of a machine; with a finer one the number of steps is not a number any more."""
STEP = Range(f"must be 0 or ≥ {FINEST_STEP_MM:g}", least=FINEST_STEP_MM, besides=(0.0,))
"""Range of a machine's step; 0: any depth."""


def refuse_out_of_range(kind: str, limits: Any) -> None:
    """Refuse numbers outside of the ranges that fields declare in ``Annotated``, or infinite; None passes."""
    for name, rule in ranges_of(type(limits)).items():
        value = getattr(limits, name)
        for number in value if isinstance(value, tuple) else (value,):
            if isinstance(number, str):  # a word in a number's place
                continue
            if number is not None and not (rule.holds(number) and math.isfinite(number)):
                verb = "holds" if isinstance(value, tuple) else "is"
                raise CorrectionError(f"{kind}.{name} {verb} {number:g}; {rule.text}")


def ranges_of(limits: type[Any]) -> Mapping[str, Range]:
    """Return the range of each field of a class of limits that declares one."""
    if limits not in _RANGES:
        hints = get_type_hints(limits, include_extras=True)
        _RANGES[limits] = {
            name: mark
            for name, hint in hints.items()
            for mark in getattr(hint, "__metadata__", ())
            if isinstance(mark, Range)
        }
    return _RANGES[limits]


_RANGES: dict[type[Any], Mapping[str, Range]] = {}


def refuse_sizes(kind: str, key: str, one: str, sizes_mm: Sequence[object]) -> None:
    """Refuse an empty list of sizes; ``one`` names a missing one in the message."""
    if not sizes_mm:
        raise CorrectionError(f"{kind}.{key} is empty; expected at least one {one}")


def refuse_sectors(kind: str, sectors_deg: Sectors) -> None:
    """Refuse angle sectors that exclude everything."""
    if not sectors_deg:
        raise CorrectionError(f"{kind}.sectors_deg is empty: it excludes every angle")
    for start, end in sectors_deg:
        if not (math.isfinite(start) and math.isfinite(end)) or start == end:
            raise CorrectionError(
                f"{kind}.sectors_deg holds [{start:g}, {end:g}], which excludes every angle; "
                "all around is [0, 360]"
            )


def refuse_wide(
    kind: str,
    diameters_mm: Sequence[float],
    wall_mm: float,
    anatomy: Anatomy,
    direction: Direction,
    *,
    are_chosen: bool = True,
) -> None:
    """Refuse diameters if no hole fits between the faces of the thickest web.

    ``are_chosen``: the job names them, so that others may be chosen.
    """
    if direction == "axial" or not anatomy.webs:
        return
    thickest = max(web.z_max_mm - web.z_min_mm for web in anatomy.webs)
    least = min(diameters_mm)
    if least + 2.0 * wall_mm > thickest + 1e-3:
        raise CorrectionError(
            f"{kind}: a hole of {least:g} mm with walls of {wall_mm:g} mm is larger than the counterweight, "
            f"whose web is {thickest:.4g} mm thick; choose a smaller "
            f"{'diameters_mm or ' if are_chosen else ''}min_wall_mm"
        )


def wall_missed(wall_mm: float, least_mm: float) -> str:
    """Return the amount by which a wall misses its limit, in words."""
    short = least_mm - wall_mm
    return f"it leaves a wall of {wall_mm:.3f} mm here, {short:.3f} mm less than min_wall_mm = {least_mm:g}"
