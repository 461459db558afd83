"""Whole cuts: fewest cuts, set-ups and steps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from autobalance.correction.contract import Cut, Prefer, setting_of
from autobalance.correction.kind import Candidates
from autobalance.planning.cut_curves import (
    Task,
    finished,
    is_discrete,
    part_of,
    rounding_share,
    settled,
    usual,
)
from autobalance.planning.depths import AIM_SHARE, Plan, judged_plan, nominal_plan, plan_depths
from autobalance.planning.enumeration import lightest_set
from autobalance.planning.equal_cuts import (
    Groups,
    common_depths,
    equal_cuts_everywhere,
    equal_cuts_on_each_web,
)
from autobalance.planning.milp import CUT_COUNTS, NODES, least_share, solve
from autobalance.planning.milp_model import EXCESS_WEIGHT, add_points, breakpoints
from autobalance.planning.ties import key
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.types import Array

# Simplest plan to make: fewest different cuts, then fewest cuts, then the least metal.
#
# Cuts are equal if one setting of the machine makes them: the same tool to the same depth. Plans that reach
# the aim are found by the other planners. Then depths of one tool are drawn together as long as the residual
# stays small enough, and small sets of cuts of one common depth are searched directly (`equal_cut_search`).


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


# Choice of cuts where whole numbers decide: holes, drills, slugs, machine steps.
#
# Where few cuts suffice, `enumeration` finds the lightest set; elsewhere a mixed-integer programme (`milp`)
# picks the cuts on piecewise linear effects. `depths` finds their depths on the exact curves, and
# `depth_steps` rounds them to the machine's steps together, so that the residual stays least.


EQUAL_CUTS_SHARE = 0.75
"""Share of the permissible value that cuts of one tool and one depth may leave, for being equal."""
MOST_EQUAL = 16
"""Cuts of one tool and one depth, at most."""
ROUNDS = 4
MIN_REFINEMENT_GAIN = 0.9
"""Share of the former residual below which another look at the exact curves is worth its time, unless the
programme's bound shows that no choice comes near the aim."""
HOPELESS_RESIDUAL_SHARE = 3.0
"""Share of the permissible value that no better look at the exact curves, or at other sets, makes up."""
ROUNDING_SHARE = 0.5
"""Share of the permissible value that rounding to machine steps may leave before more cuts are tried."""
FEW_DIFFERENT = 2
"""Different cuts of a simple plan beyond which a plan of the fewest cuts, simplified, may be simpler."""
ANY_NODES = 20
"""Branches looked at where any plan within the tolerance will do."""
FEW_AIM, FEW_NODES = 0.1, 10
"""Share of the permissible value, and branches, for that plan: it takes longest of all."""
UNTRIED_WEIGHT_SHARE = 0.03
"""Excess over the least weight of untried sets up to which the lightest few cuts are final, as a share."""


def choose(
    residual: Unbalance,
    tolerance: Tolerance,
    candidates: Candidates,
    *,
    prefer: Prefer = "least_metal",
    start_mm: Array | None = None,
    aim: float = AIM_SHARE,
    any_will_do: bool = False,
) -> Plan:
    """Return the cuts to make and their depths.

    Parameters
    ----------
    residual : Unbalance
        With no cut made, as judged.
    tolerance : Tolerance
    candidates : Candidates
        The cuts available and their rules.
    prefer : Prefer
        Preference among plans that reach the aim.
    start_mm : (n,) float, optional
        An earlier plan: its choice of cuts is kept if it still serves.
    aim : float
        Share of the permissible value below which less residual is worth nothing.
    any_will_do : bool
        Whether any plan that reaches the tolerance serves, however heavy: only the best few cuts are tried.

    Returns
    -------
    Plan
        With nominal depths: each the limit, step or common value that it stands for.
    """
    chosen = (
        _any_plan(Task(residual, tolerance, candidates, "least_metal", aim, *usual(candidates)), start_mm)
        if any_will_do and candidates.cuts and is_discrete(candidates)
        else _chosen_plan(residual, tolerance, candidates, prefer, start_mm, aim)
    )
    return nominal_plan(residual, tolerance, candidates, chosen)


def _any_plan(task: Task, start_mm: Array | None) -> Plan:
    """Return an earlier plan if it still serves, else the first that does among ever more cuts."""
    if start_mm is not None and start_mm.any():
        kept = finished(task, settled(task, start_mm))
        if kept.share <= 1.0:
            return kept
    best: Plan | None = None
    for size in CUT_COUNTS[:2]:
        plan = finished(task, _chosen(task, 0, (size,), rounds=1, nodes=ANY_NODES))
        best = plan if best is None or plan.share < best.share else best
        if best.share <= 1.0 or size >= len(task.cuts):
            break
    assert best is not None
    return best


def _chosen_plan(
    residual: Unbalance,
    tolerance: Tolerance,
    candidates: Candidates,
    prefer: Prefer,
    start_mm: Array | None,
    aim: float,
) -> Plan:
    """Return the plan of `choose` with depths as the solvers leave them."""
    if candidates.equal:
        equal = _equal(Task(residual, tolerance, candidates, "simple", aim, *usual(candidates)), start_mm)
        if equal is not None:
            return equal
        prefer, candidates = "simple", replace(candidates, equal=False)
    if prefer == "same_setup":
        prefer = "simple"  # which tools and places go first was decided with the candidates
    if prefer == "simple" and candidates.cuts:
        return _simplest(Task(residual, tolerance, candidates, prefer, aim, *usual(candidates)), start_mm)
    if not candidates.cuts or (not is_discrete(candidates) and prefer == "least_metal"):
        return plan_depths(
            residual,
            tolerance,
            candidates.cuts,
            start_mm=start_mm,
            same_depth=candidates.same_depth,
            shared=candidates.shared,
            aim=aim,
        )
    task = Task(residual, tolerance, candidates, prefer, aim, *usual(candidates))
    if start_mm is not None and start_mm.any():
        kept = finished(task, settled(task, start_mm))
        if kept.share <= max(aim, rounding_share(task, start_mm)):
            return kept
    first = _first(task)
    plan = finished(task, first)
    for extra in (1, 2):
        if first.share > ROUNDING_SHARE or plan.share <= ROUNDING_SHARE:
            break
        again = finished(task, _chosen(task, int(np.count_nonzero(plan.depths_mm)) + extra, CUT_COUNTS))
        plan = again if again.share < plan.share * (1.0 - aim) else plan
    return plan


def _equal(task: Task, start_mm: Array | None) -> Plan | None:
    """Return the fewest cuts of one tool and one depth that keep the tolerance; None: no such cuts do."""
    if start_mm is not None and start_mm.any():
        groups = Groups.apart(task, start_mm)
        kept = common_depths(task, groups, EQUAL_CUTS_SHARE) if len(groups.members) == 1 else None
        if kept is not None:
            return kept
    plans = [*equal_cuts_everywhere(task, EQUAL_CUTS_SHARE, MOST_EQUAL)]
    return min(plans, key=lambda plan: (rank(task, plan)[1], key(plan.share)), default=None)


def _simplest(task: Task, start_mm: Array | None) -> Plan:
    """Return the simplest plan; an earlier one's cuts and common depths are kept if they still serve."""
    if start_mm is not None and start_mm.any():
        groups = Groups.apart(task, start_mm)
        kept = common_depths(task, groups, max(enough_share(task), rounding_share(task, start_mm)))
        if kept is not None:
            return kept
    light = choose(task.residual, task.tolerance, task.candidates, aim=task.aim)
    plan = simplest(task, [light], search=light.share <= HOPELESS_RESIDUAL_SHARE)
    is_simple = plan.share <= enough_share(task) and rank(task, plan)[0] <= FEW_DIFFERENT
    if not is_discrete(task.candidates) or plan.share > HOPELESS_RESIDUAL_SHARE or is_simple:
        return plan
    sparing = replace(task, prefer="fewest_holes", aim=FEW_AIM)
    few = finished(sparing, _chosen(sparing, 0, CUT_COUNTS[:1], rounds=1, nodes=FEW_NODES))
    return simplest(task, [plan, few], search=False)


def is_enough(plan: Plan, candidates: Candidates) -> bool:
    """Return whether a plan leaves so little that a search for other cuts is not worth it."""
    if candidates.equal and plan.share <= EQUAL_CUTS_SHARE:
        return True
    return plan.share <= (WHOLE_CUTS_SHARE if has_steps(candidates) else AIM_SHARE * (1.0 + 1e-6))


def _first(task: Task) -> Plan:
    """Return the plan of the lightest few cuts or, where others may be lighter, of the integer programme."""
    few, unseen_g = _few(task)
    if few is not None and _weight(task, few) <= (1.0 + UNTRIED_WEIGHT_SHARE) * unseen_g:
        return few
    plan = _chosen(task, 0, CUT_COUNTS) if few is None else _chosen(task, 0, CUT_COUNTS[:1], rounds=1)
    if few is None or max(plan.share, few.share) > task.aim * (1.0 + 1e-6):
        return few if few is not None and few.share < plan.share else plan
    return few if _weight(task, few) < _weight(task, plan) else plan


def _few(task: Task) -> tuple[Plan | None, float]:
    """Return the plan of the lightest few cuts, if any, and the least weight of others [g]."""
    candidates = task.candidates
    if (
        task.prefer != "least_metal"
        or candidates.shared
        or any(cut.least_depth_mm <= 0.0 for cut in task.cuts)
    ):
        return None, 0.0
    enough = task.aim * (1.0 + 1e-6)

    def serves(depths: Array) -> bool:
        here = judged_plan(task.residual, task.tolerance, task.cuts, depths)
        return here.share <= enough or settled(task, depths).share <= enough

    depths, unseen_g = lightest_set(task.residual, task.tolerance, candidates, task.aim, serves)
    return (None if depths is None else settled(task, depths)), unseen_g


def _weight(task: Task, plan: Plan) -> float:
    return sum(task.cost(cut.effect(float(d))) for cut, d in zip(task.cuts, plan.depths_mm, strict=True) if d)


def _chosen(
    task: Task, least_count: int, sizes: Sequence[int], rounds: int = ROUNDS, nodes: int = NODES
) -> Plan:
    """Return depths by the mixed-integer programme, refined until they hold on the exact curves."""
    tables = breakpoints(task)
    best = settled(task, np.zeros(len(task.cuts)))
    for number in range(rounds):
        depths, bound = solve(task, tables, least_count, sizes if not number else sizes[:2], nodes)
        here = settled(task, depths)
        is_new = here.share < MIN_REFINEMENT_GAIN * best.share and bound < EXCESS_WEIGHT
        if here.share < best.share:
            best = here
        if not is_new or not task.aim * (1.0 + 1e-6) < here.share <= HOPELESS_RESIDUAL_SHARE:
            break
        if not add_points(tables, depths, here.depths_mm):
            break
    return best


# Plans without cuts so shallow that no machine can be set to them.


ROUNDING_MM = 1e-9


def least_step_mm(cut: Cut) -> float:
    """Return the machine's smallest step of depth; 0 for a kind without one."""
    own = getattr(cut, "min_step_mm", None)
    return float(getattr(getattr(cut, "limits", None), "min_step_mm", 0.0) if own is None else own)


def settable(residual: Unbalance, tolerance: Tolerance, candidates: Candidates, plan: Plan) -> Plan:
    """Return a plan without cuts below the least step of the machine.

    The others are planned again, and so on; where a job wants one depth for all cuts, all go.
    """
    steps = np.array([least_step_mm(cut) for cut in candidates.cuts])
    while True:
        depths = plan.depths_mm
        fine = (depths > 0.0) & (depths < steps - ROUNDING_MM)
        if not fine.any():
            return plan
        keep = [] if candidates.same_depth else np.flatnonzero((depths > 0.0) & ~fine).tolist()
        without = np.zeros(len(candidates.cuts))
        if keep:
            task = Task(residual, tolerance, candidates, "least_metal", AIM_SHARE, *usual(candidates))
            part = part_of(task, keep).candidates
            without[keep] = choose(residual, tolerance, part, start_mm=depths[keep]).depths_mm
        plan = replace(judged_plan(residual, tolerance, candidates.cuts, without), binding=plan.binding)
