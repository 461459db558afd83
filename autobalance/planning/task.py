"""What is to be chosen: a residual, what is judged, the cuts at hand and what to spare."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from autobalance.correction.contract import Apart, Cut, Prefer, SharedDepth
from autobalance.correction.kind import Offer
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance

_Pair = TypeVar("_Pair", Apart, SharedDepth)


@dataclass(frozen=True, eq=False)
class Task:
    """What to choose from; ``usual_g`` and ``usual_radius_mm`` are those of a usual correction, for scale."""

    residual: Unbalance
    tolerance: Tolerance
    offer: Offer
    prefer: Prefer
    aim: float
    usual_g: float
    usual_radius_mm: float

    @property
    def cuts(self) -> Sequence[Cut]:
        """The cuts at hand."""
        return self.offer.cuts

    def cost(self, change: Moments) -> float:
        """Return what a change of moments costs; linear in it as long as it keeps its sign."""
        if self.prefer == "most_inertia_removed":
            return change.polar_inertia_g_mm2
        if self.prefer == "least_inertia_change":
            return abs(change.polar_inertia_g_mm2)
        return abs(change.mass_g)


def usual(offer: Offer) -> tuple[float, float]:
    """Return the mass and the radius of a usual correction: four times the mean of the deepest cuts."""
    changes = [cut.effect(cut.max_depth_mm) for cut in offer.cuts]
    mass = 4.0 * sum(abs(change.mass_g) for change in changes) / max(len(changes), 1)
    inertia = 4.0 * sum(abs(change.polar_inertia_g_mm2) for change in changes) / max(len(changes), 1)
    return (mass, math.sqrt(inertia / mass)) if mass > 0.0 else (1.0, 1.0)


def is_discrete(offer: Offer) -> bool:
    """Return whether whole numbers decide: of cuts that exclude each other, are counted, or come in steps."""
    return bool(offer.counts or offer.apart or offer.varieties) or any(
        cut.least_depth_mm > 0.0 or cut.depth_step_mm > 0.0 for cut in offer.cuts
    )


def part_of(task: Task, few: Sequence[int]) -> Task:
    """Return the task with only some of its cuts."""
    place = {k: n for n, k in enumerate(few)}
    offer = task.offer

    def both(pair: Apart | SharedDepth) -> bool:
        return pair.first in place and pair.second in place

    def moved(pair: _Pair) -> _Pair:
        return replace(pair, first=place[pair.first], second=place[pair.second])

    part = Offer(
        tuple(offer.cuts[k] for k in few),
        tuple(moved(pair) for pair in offer.shared if both(pair)),
        offer.same_depth,
        tuple(moved(pair) for pair in offer.apart if both(pair)),
        tuple(
            replace(rule, members=tuple(place[k] for k in rule.members if k in place))
            for rule in offer.counts
        ),
        tuple(
            replace(rule, groups=tuple(tuple(place[k] for k in group if k in place) for group in rule.groups))
            for rule in offer.varieties
        ),
        offer.notes,
    )
    return replace(task, offer=part)
