"""The task of planning: cuts as curves over their depth, in steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from itertools import product
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.contract import Apart, Cut, Prefer, SharedDepth
from autobalance.correction.kind import Candidates
from autobalance.correction.overlap import Overlap
from autobalance.planning.depths import (
    Plan,
    independent_rows,
    judged_plan,
    judged_rows,
    plan_depths,
    resultant_and_moment,
)
from autobalance.planning.ties import in_order, is_less
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Cuts as parabolas of judged vectors through three depths, and their sums over many sets.


MOST_LATE = 0.99
"""Largest lag of a curve: one that would run backwards at first is taken to start slowly."""


@dataclass(frozen=True, eq=False)
class CutCurves:
    """All cuts as curves of judged vectors, known at their least, middle and largest depths.

    Attributes
    ----------
    candidates : Candidates
    depth_mm : (n, 3) float
    effect : (n, d, 3) float
        d = 2 or 4: the judged vectors side by side, in units of the aim.
    weight : (n, 3) float
        Metal [g].
    wanted : (d,) float
        Target of the sum of effects.
    """

    candidates: Candidates
    depth_mm: Array
    effect: Array
    weight: Array
    wanted: Array

    @classmethod
    def of(cls, residual: Unbalance, tolerance: Tolerance, candidates: Candidates, aim: float) -> CutCurves:
        rows = independent_rows(tolerance) / aim
        depth = np.array([np.linspace(cut.least_depth_mm, cut.max_depth_mm, 3) for cut in candidates.cuts])
        changes = [
            [cut.effect(float(d)) for d in three] for cut, three in zip(candidates.cuts, depth, strict=True)
        ]
        effect = np.array([[resultant_and_moment(change) for change in three] for three in changes]) @ rows.T
        weight = np.array([[abs(change.mass_g) for change in three] for three in changes])
        now = residual.components
        return cls(candidates, depth, np.moveaxis(effect, 2, 1), weight, -rows @ now)

    @cached_property
    def least(self) -> Array:
        """The effects at the least depths (n, d)."""
        return np.ascontiguousarray(self.effect[:, :, 0])

    def at_least(self, sets: Indices) -> Array:
        """Return the sums (m, d) of the effects of sets of cuts (m, k) at their smallest depths."""
        total = np.zeros((len(sets), len(self.wanted)))
        for members in sets.T:
            total += self.least.take(members, axis=0)
        return total

    @cached_property
    def chord(self) -> Array:
        """Change of each effect from the least to the largest depth (n, d)."""
        return self.effect[:, :, 2] - self.effect[:, :, 0]

    @cached_property
    def bow(self) -> Array:
        """Progress of each curve along its chord at its middle depth beyond one half, times four (n,).

        Zero for a cut of one depth only, which has no chord.
        """
        middle = ((self.effect[:, :, 1] - self.effect[:, :, 0]) * self.chord).sum(axis=1)
        square = (self.chord**2).sum(axis=1)
        bow = np.where(square > 1e-30, 4.0 * middle / np.maximum(square, 1e-30) - 2.0, 0.0)
        return np.asarray(np.maximum(bow, -MOST_LATE))

    @cached_property
    def bend(self) -> Array:
        """Distance of each curve sideways from its chord at its middle depth (n,)."""
        middle = self.effect[:, :, 1] - self.effect[:, :, 0]
        return length(middle - (0.5 + 0.25 * self.bow)[:, None] * self.chord)

    @cached_property
    def reach(self) -> float:
        """Largest growth of the length of an effect per gram of metal."""
        gain, spent = length(np.moveaxis(slopes_of(self.effect), 2, 1)), slopes_of(self.weight)
        return max(float((gain / np.maximum(spent, 1e-12)).max(initial=0.0, where=spent > 1e-12)), 1e-12)

    @cached_property
    def deepest_beside(self) -> Array:
        """Largest depth, from 0 smallest to 1 largest, of the first of two cuts beside the second (n, n).

        Below 0: the two exclude each other.
        """
        most = np.full((len(self.weight), len(self.weight)), np.inf)
        least, span = self.depth_mm[:, 0], np.maximum(self.depth_mm[:, 2] - self.depth_mm[:, 0], 1e-9)
        for pair in self.candidates.apart:
            for i, j in ((pair.first, pair.second), (pair.second, pair.first)):
                never = pair.most_mm < max(least[i], least[j])
                most[i, j] = min(most[i, j], -1.0 if never else (pair.most_mm - least[i]) / span[i])
        return most

    @cached_property
    def never_both(self) -> NDArray[np.bool_]:
        """Pairs of cuts that exclude each other (n, n)."""
        return self.deepest_beside < 0.0

    def keeps_apart(self, first: Indices, last: Indices) -> NDArray[np.bool_]:
        """Return whether sets keep the rules (m,) whose first (m, j) and last members (m, k) each do."""
        good = np.ones(len(first), dtype=bool)
        for a, b in product(range(first.shape[1]), range(last.shape[1])):
            good &= ~self.never_both[first[:, a], last[:, b]]
        sets = np.vstack([first.T, last.T])  # numpy counts across long rows many times faster
        for rule in self.candidates.counts:
            if rule.most < len(sets):
                inside = np.zeros(len(self.weight), dtype=np.int64)
                inside[list(rule.members)] = 1
                good &= inside[sets].sum(axis=0) <= rule.most
        for groups, most in self._groups:
            if most < len(sets):
                own = groups[sets]
                used = np.zeros(len(first), dtype=np.int64)
                for each in range(groups.max() + 1):
                    used += (own == each).any(axis=0)
                good &= used <= most
        return good

    @cached_property
    def _groups(self) -> list[tuple[Indices, int]]:
        """Group of each cut (n,), −1 for none, and largest number of groups used, by rule of variety."""
        groups = []
        for rule in self.candidates.varieties:
            number = np.full(len(self.weight), -1, dtype=np.int64)
            for n, group in enumerate(rule.groups):
                number[list(group)] = n
            groups.append((number, rule.most))
        return groups


def length(vectors: Array) -> Array:
    """Return the sum of the lengths of the judged vectors that lie side by side."""
    return np.asarray(np.hypot(vectors[..., 0::2], vectors[..., 1::2]).sum(axis=-1))


def parabola(three: Array, at: Array | float) -> Array:
    """Return the values at ``at`` of parabolas through values at 0, ½ and 1."""
    first, middle, last = np.moveaxis(three, -1, 0)
    curve = 2.0 * (first - 2.0 * middle + last)
    return np.asarray(first + at * (last - first - curve) + at * at * curve)


def slopes_of(three: Array) -> Array:
    """Return the slopes at 0, ½ and 1 of parabolas through values there."""
    first, middle, last = np.moveaxis(three, -1, 0)
    return np.stack(
        [4.0 * middle - 3.0 * first - last, last - first, first + 3.0 * last - 4.0 * middle], axis=-1
    )


def least_of(three: Array) -> Array:
    """Return the least values, between 0 and 1, of parabolas through values at 0, ½ and 1."""
    first, middle, last = np.moveaxis(three, -1, 0)
    curve = 2.0 * (first - 2.0 * middle + last)
    inside = np.clip((curve - last + first) / np.where(curve > 0.0, 2.0 * curve, 1.0), 0.0, 1.0)
    return parabola(three, np.where(curve > 0.0, inside, last < first))


# Task of a planner: a residual, its tolerance, the candidates and a preference.


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


# Depths of the chosen cuts: exact, then rounded together to the machines' steps.


WORTH_SHARE = 1e-4
"""Share of the cost that another step of the depths must save."""
COMBINATIONS = 50_000
"""Roundings tried, at most."""
STEPS_ASIDE = 3
EXACT_COMBINATIONS = 12
"""Combinations of steps that are tried on the exact curves."""


def settled(task: Task, depths: Array) -> Plan:
    """Return the plan of the cuts used in ``depths`` at exact depths within their limits."""
    cut_now = [int(k) for k in np.flatnonzero(depths > 0.0)]
    part = part_of(task, cut_now)
    plan = plan_depths(
        task.residual,
        task.tolerance,
        part.cuts,
        start_mm=depths[cut_now],
        shared=part.candidates.shared,
        aim=task.aim,
        bounds_mm=bounds_of(task, cut_now),
        cost=task.cost,
        worth=WORTH_SHARE,
    )
    whole = np.zeros(len(depths))
    whole[cut_now] = plan.depths_mm
    return replace(plan, depths_mm=whole)


def bounds_of(task: Task, chosen: Sequence[int]) -> tuple[Array, Array]:
    """Return the least and largest depths of chosen cuts beside their chosen neighbours."""
    least = np.array([task.cuts[k].least_depth_mm for k in chosen])
    most = np.array([task.cuts[k].max_depth_mm for k in chosen])
    place = {k: n for n, k in enumerate(chosen)}
    for pair in task.candidates.apart:
        if pair.first in place and pair.second in place:
            for k in (place[pair.first], place[pair.second]):
                most[k] = max(min(most[k], pair.most_mm), least[k])
    return least, most


def finished(task: Task, plan: Plan) -> Plan:
    """Return the plan with depths rounded to machine steps, and its binding limits."""
    rounded = _rounded(task, plan)
    limits = [
        cut.limit
        for cut, d in zip(task.cuts, rounded.depths_mm, strict=True)
        if d >= cut.max_depth_mm - 1e-6 and cut.max_depth_mm > cut.least_depth_mm
    ]
    for rule in task.candidates.counts:
        if sum(rounded.depths_mm[k] > 0.0 for k in rule.members) >= rule.most:
            limits.append(rule.limit)
    binding = tuple(dict.fromkeys(limits)) if rounded.share > max(task.aim, 1.0) else ()
    return replace(rounded, binding=binding)


def rounding_share(task: Task, depths: Array) -> float:
    """Return the largest share of a permissible value that half a depth step of a cut changes."""
    total = 0.0
    rows = judged_rows(task.tolerance)
    for k in np.flatnonzero(depths).tolist():
        cut = task.cuts[k]
        total = max(
            total,
            float(np.abs(rows @ resultant_and_moment(cut.rate(float(depths[k])))).max())
            * 0.5
            * cut.depth_step_mm,
        )
    return total


def _rounded(task: Task, plan: Plan) -> Plan:
    """Return the plan of smallest residual among those on the nearest machine steps."""
    chosen = [k for k in np.flatnonzero(plan.depths_mm).tolist() if task.cuts[k].depth_step_mm > 0.0]
    if not chosen:
        return plan
    least, most = bounds_of(task, chosen)
    room = COMBINATIONS
    choices = []
    count = len(chosen)
    for n, k in enumerate(chosen):
        step = task.cuts[k].depth_step_mm
        aside = max(0, min(STEPS_ASIDE, int(room ** (1.0 / (count - n)) / 2.0 - 0.5)))
        middle = plan.depths_mm[k] / step
        low, high = math.floor(middle) - aside, math.floor(middle) + 1 + aside
        steps = np.arange(low, high + 1) * step
        steps = steps[(steps >= least[n] - 1e-9) & (steps <= most[n] + 1e-9)]
        if not len(steps):
            steps = np.array([min(max(round(middle) * step, least[n]), most[n])])
        if len(steps) > room:
            steps = steps[[int(np.argmin(np.abs(steps - plan.depths_mm[k])))]]
        room = max(room // len(steps), 1)
        choices.append(steps)
    return _best_combination(task, plan, chosen, choices)


def _best_combination(task: Task, plan: Plan, chosen: Sequence[int], choices: Sequence[Array]) -> Plan:
    """Try all combinations on the tangent, then the best of them on the exact curves."""
    rows = judged_rows(task.tolerance)
    slopes = (
        np.array([resultant_and_moment(task.cuts[k].rate(float(plan.depths_mm[k]))) for k in chosen]) @ rows.T
    )
    judged = rows @ plan.predicted.components
    for k, steps, slope in zip(chosen, choices, slopes, strict=True):
        judged = (judged[..., None, :] + (steps - plan.depths_mm[k])[:, None] * slope).reshape(-1, len(rows))
    shares = np.hypot(judged[:, 0::2], judged[:, 1::2]).max(axis=1)
    best: Plan | None = None
    for place in in_order(shares)[:EXACT_COMBINATIONS].tolist():
        depths = plan.depths_mm.copy()
        depths[list(chosen)] = _combination(choices, place)
        here = judged_plan(task.residual, task.tolerance, task.cuts, depths)
        if best is None or is_less(here.share, best.share):
            best = here
    assert best is not None
    return best


def _combination(choices: Sequence[Array], place: int) -> list[float]:
    """Return the depths of one combination by its index; the last choice runs fastest."""
    steps_of = []
    for steps in reversed(choices):
        place, at = divmod(place, len(steps))
        steps_of.append(float(steps[at]))
    return steps_of[::-1]
