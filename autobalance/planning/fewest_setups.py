"""Simplest plan to make: fewest different cuts, then fewest cuts, then the least metal.

Cuts are equal if one setting of the machine makes them: the same tool to the same depth. Plans that reach the
aim are found by the other planners. Then depths of one tool are drawn together as long as the residual stays
small enough, and small sets of cuts of one common depth are searched directly (`equal_cut_search`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from autobalance.correction.contract import setting_of
from autobalance.correction.kind import Candidates
from autobalance.planning.common_depths import Groups, common_depths
from autobalance.planning.depths import Plan, plan_depths
from autobalance.planning.equal_cut_search import equal_cuts_everywhere, equal_cuts_on_each_web
from autobalance.planning.milp import least_share
from autobalance.planning.task import Task, is_discrete, part_of
from autobalance.planning.ties import key

WHOLE_CUTS_SHARE = 0.25
"""Share of the permissible value that plans of cuts in steps may leave, since these cannot reach the aim."""
MERGES = 40
"""Groups drawn together in a plan, tried at most."""
MOST_FACES = 6
"""Largest number of cuts of the lightest plan, of any depth, from which every choice of some is tried."""
NEAR_ENOUGH_RATIO = 2.0
"""Multiple of the enough share that the lightest plan may leave, for a few of its cuts to be tried."""

Rank = tuple[int, int, float]


def has_steps(candidates: Candidates) -> bool:
    """Return whether any cut has machine steps or one depth only."""
    return any(cut.depth_step_mm > 0.0 or cut.least_depth_mm == cut.max_depth_mm for cut in candidates.cuts)


def enough_share(task: Task) -> float:
    """Return the share of the permissible value below which less residual is worth no other cut."""
    return max(task.aim * (1.0 + 1e-6), WHOLE_CUTS_SHARE if has_steps(task.candidates) else 0.0)


def rank(task: Task, plan: Plan) -> Rank:
    """Return the number of different cuts of a plan, of all its cuts, and their metal [g]."""
    chosen = np.flatnonzero(plan.depths_mm > 0.0).tolist()
    different = {(setting_of(task.cuts[k]), round(float(plan.depths_mm[k]), 6)) for k in chosen}
    metal = sum(abs(task.cuts[k].effect(float(plan.depths_mm[k])).mass_g) for k in chosen)
    return len(different), len(chosen), round(float(metal), 6)


def simplest(task: Task, plans: Iterable[Plan], search: bool = True) -> Plan:
    """Return the simplest plan derived from some plans or, with ``search``, found beside them.

    Where none of them is good enough, the one of smallest residual is returned.
    """
    candidates = list(plans)
    least = min(candidates, key=lambda plan: key(plan.share))
    enough = enough_share(task)
    good = [plan for plan in candidates if plan.share <= enough]
    if search and is_discrete(task.candidates):
        good += [*equal_cuts_everywhere(task, enough), *equal_cuts_on_each_web(task, enough)]
    elif search and least.share <= NEAR_ENOUGH_RATIO * enough:  # else a few of its cuts leave more yet
        good += _fewest_of_any_depth(task, least, enough)
    good = [_merged(task, plan, enough) for plan in good if plan.share <= enough and _keeps_rules(task, plan)]
    if not good:
        return least
    return min(good, key=lambda plan: (*rank(task, plan), key(plan.share)))


def _keeps_rules(task: Task, plan: Plan) -> bool:
    depths, candidates = plan.depths_mm, task.candidates
    return (
        all(sum(depths[k] > 0.0 for k in rule.members) <= rule.most for rule in candidates.counts)
        and all(
            sum(any(depths[k] > 0.0 for k in group) for group in rule.groups) <= rule.most
            for rule in candidates.varieties
        )
        and all(
            min(depths[pair.first], depths[pair.second]) <= 0.0
            or max(depths[pair.first], depths[pair.second]) <= pair.most_mm + 1e-6
            for pair in candidates.apart
        )
    )


def _merged(task: Task, plan: Plan, enough: float) -> Plan:
    """Return a plan with as many depths of like tools merged as the residual allows."""
    groups = Groups.apart(task, plan.depths_mm)
    tried = 0
    while tried < MERGES:
        for joined in groups.joinings():
            tried += 1
            here = common_depths(task, joined, enough)
            if here is not None:
                plan, groups = here, joined.at(here.depths_mm)
                break
            if tried >= MERGES:
                return plan
        else:
            return plan
    return plan


def _fewest_of_any_depth(task: Task, least: Plan, enough: float) -> list[Plan]:
    """Return plans of the fewest cuts of the lightest plan that are enough: of one depth, and of any."""
    members = np.flatnonzero(least.depths_mm).tolist()
    if len(members) > MOST_FACES:
        return []
    plans_found: list[Plan] = []
    may_do: dict[tuple[int, ...], bool] = {}

    def reach(few: tuple[int, ...]) -> bool:
        """Return whether some cuts may be enough: to plan each choice of rims on a V8 took half a minute."""
        if few not in may_do:
            least = least_share(task.residual, task.tolerance, part_of(task, few).candidates)
            may_do[few] = least <= max(enough, 1.0)
        return may_do[few]

    for alike in (True, False):
        for count in range(1, len(members) + 1):
            here = [
                plan
                for few in combinations(members, count)
                if reach(few) and (plan := _of_these(task, few, alike)) is not None and plan.share <= enough
            ]
            if here:
                plans_found += here
                break
    return plans_found


def _of_these(task: Task, few: Sequence[int], alike: bool) -> Plan | None:
    if alike and len({setting_of(task.cuts[k]) for k in few}) > 1:
        return None
    place = {k: n for n, k in enumerate(few)}
    shared = [
        replace(pair, first=place[pair.first], second=place[pair.second])
        for pair in task.candidates.shared
        if pair.first in place and pair.second in place
    ]
    if alike and shared and not math.isfinite(min(pair.most_mm for pair in shared)):
        return None
    plan = plan_depths(
        task.residual,
        task.tolerance,
        [task.cuts[k] for k in few],
        same_depth=alike or task.candidates.same_depth,
        shared=shared,
        aim=task.aim,
        start_mm=np.array([0.5 * task.cuts[k].max_depth_mm for k in few]),
    )
    depths = np.zeros(len(task.cuts))
    depths[list(few)] = plan.depths_mm
    return replace(plan, depths_mm=depths) if (plan.depths_mm > 0.0).all() else None
