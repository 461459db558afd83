"""Depths of the chosen cuts: exact, then rounded together to the machines' steps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.planning.depths import Plan, judged_plan, judged_rows, plan_depths, resultant_and_moment
from autobalance.planning.task import Task, part_of
from autobalance.planning.ties import in_order, is_less
from autobalance.types import Array

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
