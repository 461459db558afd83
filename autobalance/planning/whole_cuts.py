"""Choice of cuts where whole numbers decide: holes, drills, slugs, machine steps.

Where few cuts suffice, `enumeration` finds the lightest set; elsewhere a mixed-integer programme (`milp`)
picks the cuts on piecewise linear effects. `depths` finds their depths on the exact curves, and `depth_steps`
rounds them to the machine's steps together, so that the residual stays least.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalance.correction.contract import Prefer
from autobalance.correction.kind import Candidates
from autobalance.planning.common_depths import Groups, common_depths
from autobalance.planning.depth_steps import finished, rounding_share, settled
from autobalance.planning.depths import AIM_SHARE, Plan, judged_plan, plan_depths
from autobalance.planning.enumeration import lightest_set
from autobalance.planning.equal_cut_search import equal_cuts_everywhere
from autobalance.planning.fewest_setups import WHOLE_CUTS_SHARE, enough_share, has_steps, rank, simplest
from autobalance.planning.milp import CUT_COUNTS, NODES, solve
from autobalance.planning.milp_model import EXCESS_WEIGHT, add_points, breakpoints
from autobalance.planning.nominal_depths import nominal_plan
from autobalance.planning.task import Task, is_discrete, usual
from autobalance.planning.ties import key
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.types import Array

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
