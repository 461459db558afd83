"""Planned depths set to the limit, step or common value that they stand for, to the last digit.

Solvers end a depth at a limit give or take some roundings, which differ from processor to processor. A cut
at 0.9999999999999991 mm beside one at 1 mm is another solid, whose faces no longer lie in one plane.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from autobalance.correction.contract import Cut
from autobalance.correction.kind import Candidates
from autobalance.planning.depths import SAME_MM, Plan, judged_plan
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.types import Array


def nominal_plan(residual: Unbalance, tolerance: Tolerance, candidates: Candidates, plan: Plan) -> Plan:
    """Return a plan with nominal depths and their residual; itself if it has them already."""
    depths = nominal_depths(candidates, plan.depths_mm)
    if np.array_equal(depths, plan.depths_mm):
        return plan
    return replace(judged_plan(residual, tolerance, candidates.cuts, depths), binding=plan.binding)


def nominal_depths(candidates: Candidates, depths_mm: Array) -> Array:
    """Return depths (n,), each set to the limit, step or common value within `SAME_MM` of it.

    Depths of one value are one, the least of the limits that they stand for, so that none is exceeded; two
    that share the metal between them end where that does.
    """
    depths = np.where(depths_mm <= SAME_MM, 0.0, depths_mm)
    chosen = np.flatnonzero(depths).tolist()
    ends = _neighbours_ends(candidates, chosen)
    marks = {k: _marks(candidates.cuts[k], float(depths[k]), ends.get(k, ())) for k in chosen}
    for group in _of_one_value(depths, chosen):
        stood_for = [mark for k in group for mark in marks[k]]
        depths[group] = min(stood_for, default=float(depths[group[0]]))
    for pair in candidates.shared:
        both = float(depths[pair.first] + depths[pair.second])
        if both != pair.most_mm and abs(both - pair.most_mm) <= SAME_MM and depths[pair.first] > 0.0:
            kept, other = (pair.second, pair.first) if marks.get(pair.second) else (pair.first, pair.second)
            if depths[other] > 0.0 and not marks[other]:
                depths[other] = pair.most_mm - depths[kept]
    return depths


def _neighbours_ends(candidates: Candidates, cut_now: Sequence[int]) -> dict[int, list[float]]:
    """Return the depths at which each chosen cut is limited by its chosen neighbours."""
    ends: dict[int, list[float]] = {}
    chosen = frozenset(cut_now)
    for pair in candidates.apart:
        if pair.first in chosen and pair.second in chosen:
            ends.setdefault(pair.first, []).append(pair.most_mm)
            ends.setdefault(pair.second, []).append(pair.most_mm)
    return ends


def _marks(cut: Cut, depth_mm: float, ends: Sequence[float]) -> list[float]:
    """Return the limits and the machine step within `SAME_MM` of a depth."""
    known = [cut.least_depth_mm, cut.max_depth_mm, *ends]
    if cut.depth_step_mm > 0.0:
        known.append(round(depth_mm / cut.depth_step_mm) * cut.depth_step_mm)
    return [mark for mark in known if abs(mark - depth_mm) <= SAME_MM]


def _of_one_value(depths: Array, chosen: Sequence[int]) -> Iterator[list[int]]:
    """Yield groups of cuts, by index, whose depths follow each other by no more than `SAME_MM`."""
    if not chosen:
        return
    by_depth = sorted(chosen, key=lambda k: (depths[k], k))
    group = [by_depth[0]]
    for k in by_depth[1:]:
        if depths[k] - depths[group[-1]] > SAME_MM:
            yield sorted(group)
            group = []
        group.append(k)
    yield sorted(group)
