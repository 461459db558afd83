"""Pairs of cuts with some metal in common, as at the edge between two faces that are lowered.

Where that is much of either, not both are made; where it is little, the one that is listed first takes it.
"""

# Needed by a cheek and a flank of one web lowered together: within tolerance, but both listed the edge
# between them, and verify refused the report (tests/geometry/test_overlap.py).

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol, cast

import numpy as np

from autobalance.correction.contract import Apart, Correction, Cut
from autobalance.correction.cut import Made, as_taken
from autobalance.crank.anatomy import Anatomy
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid, union
from autobalance.value_classes import dataclass

MAX_OVERLAP_SHARE = 0.3
"""Share of the lesser of two cuts up to which both may want the same metal. Plans count that twice at first;
each pass of cutting and planning again leaves about that share of the error."""
ROUNDING_SHARE = 1e-6
"""Share of it that is not metal, but the rounding of two outlines that touch."""
STEPS = 5
"""Halvings of the interval for the depth that two cuts may both have: to 3 % of the deeper one."""
RATE_STEP_SHARE = 1e-3
"""Share of the depth by which a cut is made shallower to measure its rate."""


@dataclass(frozen=True)
class Overlap:
    """Two cuts with some metal in common that may both be made: the first one takes it."""

    first: int
    second: int


class Lowered(Cut, Protocol):
    """Cut with a body around the metal that it takes."""

    def taken(self, depth_mm: float) -> Solid:
        """Return a body around the removed metal, rotor frame [mm]."""
        ...

    def outline_beside(self, depth_mm: float, earlier: Solid) -> tuple[dict[str, Any], float]:
        """Return the outline of the new face without what earlier tools (rotor frame) took, and its area."""
        ...


def overlaps(
    cuts: Sequence[Lowered], pairs: Sequence[tuple[int, int]]
) -> tuple[tuple[Apart, ...], tuple[Overlap, ...]]:
    """Return depth limits of pairs of cuts with much metal in common, and all pairs with any in common.

    Parameters
    ----------
    cuts : sequence of Lowered
    pairs : sequence of (int, int)
        Indices into ``cuts``, the lesser first.
    """
    apart, both = [], []
    for first, second in pairs:
        one, other = cuts[first], cuts[second]
        deepest = max(one.max_depth_mm, other.max_depth_mm)
        share = _shared(one, other, deepest)
        if share <= ROUNDING_SHARE:
            continue
        both.append(Overlap(first, second))
        if share > MAX_OVERLAP_SHARE:
            low, high = 0.0, deepest
            for _ in range(STEPS):
                middle = 0.5 * (low + high)
                low, high = (
                    (middle, high) if _shared(one, other, middle) <= MAX_OVERLAP_SHARE else (low, middle)
                )
            apart.append(Apart(first, second, low if low > 0.0 else -1.0))
    return tuple(apart), tuple(both)


def _shared(one: Lowered, other: Lowered, depth_mm: float) -> float:
    """Return the common metal of two cuts at a depth, as a share of the lesser."""
    depths = [min(depth_mm, cut.max_depth_mm) for cut in (one, other)]
    bodies = [cut.taken(depth) for cut, depth in zip((one, other), depths, strict=True)]
    low, high = (np.array([body.bounds[end] for body in bodies]) for end in (0, 1))
    if np.any(low.max(axis=0) >= high.min(axis=0)):
        return 0.0
    return (bodies[0] & bodies[1]).volume_mm3 / min(body.volume_mm3 for body in bodies)


# --- what each takes ----------------------------------------------------------------------------------------


def taken_in_turn(
    solid: Solid,
    anatomy: Anatomy,
    density_g_mm3: float,
    cut_depths: Made,
    corrections: Sequence[Correction],
    overlapping: Sequence[Overlap],
) -> tuple[Correction, ...]:
    """Return corrections, each listed without the metal that an earlier one took.

    Parameters
    ----------
    solid : Solid
        The crank before, in file coordinates [mm].
    anatomy : Anatomy
    density_g_mm3 : float
    cut_depths : sequence of (Cut, float)
    corrections : sequence of Correction
        Each as on the untouched crank, in the order of ``cut_depths``.
    overlapping : sequence of Overlap
        Pairs of ``cut_depths``.
    """
    in_turn = list(corrections)
    for second in sorted({pair.second for pair in overlapping}):
        cut, depth = cut_depths[second]
        before = [cut_depths[pair.first] for pair in overlapping if pair.second == second]
        earlier = union([each.tool(mm) for each, mm in before])

        both = (cut.tool(depth) & earlier).moved(anatomy.rotor_to_file) & solid
        if both.is_empty:
            continue
        step = RATE_STEP_SHARE * depth
        over = both & cut.tool(depth - step).moved(anatomy.rotor_to_file)
        metal, sooner = (part.moments(density_g_mm3, anatomy.file_to_rotor) for part in (both, over))
        per_mm = (metal - sooner).scaled(1.0 / step)
        less = _less(in_turn[second], cut.rate(depth), metal, per_mm, density_g_mm3)
        lowered = cast("Lowered", cut)  # no other kind overlaps
        outline, area = lowered.outline_beside(depth, earlier)
        details = {**less.details, **outline}
        in_turn[second] = replace(less, details=details, tool_volume_mm3=depth * area)
    return tuple(in_turn)


def _less(
    correction: Correction, rate: Moments, metal: Moments, gone_per_mm: Moments, density_g_mm3: float
) -> Correction:
    """Return a correction less the metal that is gone already, and its rate less that metal's."""
    area = correction.details.get("new_face_area_mm2", 0.0) - gone_per_mm.mass_g / density_g_mm3
    own = rate if correction.rate is None else correction.rate
    return as_taken(correction, correction.change + metal, own + gone_per_mm, area)
