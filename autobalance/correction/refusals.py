"""Limits that cannot be: what kinds of correction refuse in the same words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

from autobalance.crank.anatomy import Anatomy
from autobalance.errors import CorrectionError

Direction = Literal["radial", "axial"]
Sectors = tuple[tuple[float, float], ...]


def refuse_direction(kind: str, direction: str) -> None:
    """Refuse a direction that is none."""
    if direction not in ("radial", "axial"):
        raise CorrectionError(f"{kind}.direction is {direction!r}; must be 'radial' or 'axial'")


def refuse_below_zero(kind: str, limits: Any, *names: str) -> None:
    """Refuse lengths below zero or without end; None is none."""
    for name in names:
        value = getattr(limits, name)
        if value is not None and not 0.0 <= value < math.inf:
            raise CorrectionError(f"{kind}.{name} is {value:g}; must be ≥ 0")


def refuse_not_above_zero(kind: str, limits: Any, *names: str) -> None:
    """Refuse values that are not above zero or have no end; None is none."""
    for name in names:
        value = getattr(limits, name)
        if value is not None and not 0.0 < value < math.inf:
            raise CorrectionError(f"{kind}.{name} is {value:g}; must be > 0")


def refuse_none(kind: str, limits: Any, *names: str) -> None:
    """Refuse counts below one."""
    for name in names:
        if getattr(limits, name) < 1:
            raise CorrectionError(f"{kind}.{name} is {getattr(limits, name)}; must be ≥ 1")


def refuse_sizes(kind: str, key: str, one: str, sizes_mm: Sequence[float]) -> None:
    """Refuse a list of sizes that is empty or not positive; ``one`` is what at least one is needed of."""
    if not sizes_mm:
        raise CorrectionError(f"{kind}.{key} is empty; at least one {one} is needed")
    for size in sizes_mm:
        if not 0.0 < size < math.inf:
            raise CorrectionError(f"{kind}.{key} holds {size:g}; must be > 0")


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
    kind: str, diameters_mm: Sequence[float], wall_mm: float, anatomy: Anatomy, direction: Direction
) -> None:
    """Refuse diameters of which none fits between the faces of the thickest web."""
    if direction == "axial" or not anatomy.webs:
        return
    thickest = max(web.z_max_mm - web.z_min_mm for web in anatomy.webs)
    least = min(diameters_mm)
    if least + 2.0 * wall_mm > thickest + 1e-3:
        raise CorrectionError(
            f"{kind}: a hole of {least:g} mm with walls of {wall_mm:g} mm is larger than the counterweight, "
            f"whose web is {thickest:.4g} mm thick; a smaller diameters_mm or min_wall_mm is needed"
        )
