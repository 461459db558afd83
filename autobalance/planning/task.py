"""Task of a planner: a residual, its tolerance, the candidates and a preference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from autobalance.correction.contract import Apart, Cut, Prefer, SharedDepth
from autobalance.correction.kind import Candidates
from autobalance.correction.overlap import Overlap
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance

_Pair = TypeVar("_Pair", Apart, SharedDepth, Overlap)


@dataclass(frozen=True, eq=False)
class Task:
    """Inputs of a choice; ``usual_g`` and ``usual_radius_mm`` are those of a usual correction, for scale."""

    residual: Unbalance
    tolerance: Tolerance
    candidates: Candidates
    prefer: Prefer
    aim: float
    usual_g: float
    usual_radius_mm: float

    @property
    def cuts(self) -> Sequence[Cut]:
        return self.candidates.cuts

    def cost(self, change: Moments) -> float:
        """Return the cost of a change of moments, linear in it as long as it keeps its sign."""
        if self.prefer == "most_inertia_removed":
            return change.polar_inertia_g_mm2
        if self.prefer == "least_inertia_change":
            return abs(change.polar_inertia_g_mm2)
        return abs(change.mass_g)


def usual(candidates: Candidates) -> tuple[float, float]:
    """Return the mass and the radius of a usual correction: four times the mean of the deepest cuts."""
    changes = [cut.effect(cut.max_depth_mm) for cut in candidates.cuts]
    mass = 4.0 * sum(abs(change.mass_g) for change in changes) / max(len(changes), 1)
    inertia = 4.0 * sum(abs(change.polar_inertia_g_mm2) for change in changes) / max(len(changes), 1)
    return (mass, math.sqrt(inertia / mass)) if mass > 0.0 else (1.0, 1.0)


def is_discrete(candidates: Candidates) -> bool:
    """Return whether whole numbers decide: cuts exclude each other, are counted, or come in steps."""
    return bool(candidates.counts or candidates.apart or candidates.varieties) or any(
        cut.least_depth_mm > 0.0 or cut.depth_step_mm > 0.0 for cut in candidates.cuts
    )


def part_of(task: Task, few: Sequence[int]) -> Task:
    """Return the task with only some of its cuts."""
    place = {k: n for n, k in enumerate(few)}
    candidates = task.candidates

    def both(pair: Apart | SharedDepth | Overlap) -> bool:
        return pair.first in place and pair.second in place

    def moved(pair: _Pair) -> _Pair:
        return replace(pair, first=place[pair.first], second=place[pair.second])

    part = Candidates(
        tuple(candidates.cuts[k] for k in few),
        tuple(moved(pair) for pair in candidates.shared if both(pair)),
        candidates.same_depth,
        tuple(moved(pair) for pair in candidates.apart if both(pair)),
        tuple(
            replace(rule, members=tuple(place[k] for k in rule.members if k in place))
            for rule in candidates.counts
        ),
        tuple(
            replace(rule, groups=tuple(tuple(place[k] for k in group if k in place) for group in rule.groups))
            for rule in candidates.varieties
        ),
        candidates.notes,
        tuple(moved(pair) for pair in candidates.overlaps if both(pair)),
        candidates.equal,
    )
    return replace(task, candidates=part)
