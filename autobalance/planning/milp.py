"""Solve the programme of whole cuts with HiGHS: relaxed for bounds, by branch and bound for cuts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from copy import copy
from typing import Any

import numpy as np

from autobalance.correction.kind import Candidates
from autobalance.integer_program import IntegerProgram, solution
from autobalance.planning.cut_curves import Task, part_of, usual
from autobalance.planning.depths import AIM_SHARE
from autobalance.planning.dual_simplex import least_cost
from autobalance.planning.milp_model import EXCESS_WEIGHT, POINTS, MilpModel, breakpoints, effects_at
from autobalance.planning.ties import in_order, rounded
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.types import Array

GAP = 0.03, 0.1
"""Gap to its bound at which the programme may stop, as a share: half of a smallest cut, within these; less
where several cuts are offered for one place. Below 3 %, plans of many holes took half as long again for 0.2 %
of their metal."""
NODES = 100
"""Branches looked at, at most: a limit that gives the same answer on every machine, unlike seconds."""
NEAR_BOUND_SHARE = 0.06
"""Distance from the bound over all cuts within which an answer from a quarter of them is final, as a share.

Looks at more cuts took most of the time and found nothing lighter by more than 0.4 %.
"""
CUT_COUNTS = (56, 100, 250)
"""Numbers of cuts in the integer programme: the best few, then those that could still be better."""
OUT_OF_REACH = 1.0
"""Cost above the bound, in usual corrections, that only excess residual causes: then most cuts are tried."""
MANY_NODES = 10
"""Branches looked at among most cuts: each takes a hundred times as long as among the best few. A cross-plane
V8 with four drills and four holes a web took 35 s for them, and still left 37 times the permissible value."""
STEPS_SHARE = 0.02
"""Excess residual, as a share of the permissible value, that is lost in rounding to machine steps."""
LITTLE_GAIN = 0.03
"""Share by which a look at more cuts must lower a cost that is out of reach, for another to be worth it."""
HOPELESS_SHARE = 10.0
"""Multiple of the permissible value, left by the best few and by a dive over all cuts, beyond which no look
at more cuts reaches it."""
STUCK_SHARE = 2.0
"""The same where neither a look at more cuts nor the dive lowers it."""
DIVE_STEPS = 24
"""Relaxations solved in one dive, at most; it ends after some six."""


def solve(
    task: Task, tables: Sequence[Array], least_count: int, sizes: Sequence[int], nodes: int = NODES
) -> tuple[Array, float]:
    """Return depths by the integer programme over the cuts that look best in its relaxation, and its bound.

    The relaxation's value is a bound for the whole programme: where the few come near it, the rest need not
    be looked at.
    """
    count = len(task.cuts)
    effects = effects_at(task, tables)
    relaxed = MilpModel(task, tables, effects, least_count)
    answer = relaxed_solution(relaxed)
    if answer.x is None:  # more cuts asked for than the counts allow
        return np.zeros(count), math.inf
    best, value = np.zeros(count), math.inf
    bound = float(answer.fun or 0.0)
    slack = _slack(task, relaxed, bound)
    looked_at: set[int] = set()
    is_little = False
    for size in sizes:
        few = sorted(_promising(relaxed, answer, value - bound)[:size])
        if looked_at.issuperset(few):
            break
        if size == CUT_COUNTS[-1]:
            if value - bound < _out_of_reach(task):
                break
            if _left_share(task, value) > (STUCK_SHARE if is_little else HOPELESS_SHARE):
                depths_mm, here = _dive(task, relaxed, answer)
                is_little = is_little and here >= (1.0 - LITTLE_GAIN) * value
                best, value = (depths_mm, here) if here < value else (best, value)
                if is_little or _left_share(task, value) > HOPELESS_SHARE:
                    break
        looked_at.update(few)
        depths_mm, here = _solve_few(
            part_of(task, few),
            [tables[k] for k in few],
            [effects[k] for k in few],
            least_count,
            slack,
            min(nodes, MANY_NODES) if size == CUT_COUNTS[-1] else nodes,
        )
        is_little = here >= (1.0 - LITTLE_GAIN) * value
        if here < value:
            value = here
            best = np.zeros(count)
            best[few] = depths_mm
        near = NEAR_BOUND_SHARE if 4 * len(looked_at) >= count else 0.0
        if (is_little and _left_share(task, bound) > 1.0) or value - bound <= max(2.0 * slack, near) * abs(
            value
        ) + 1e-6:
            break
    return best, bound


def _left_share(task: Task, cost: float) -> float:
    """Return the share of the permissible value that a cost stands for where it is all excess residual."""
    return task.aim * cost / EXCESS_WEIGHT


def _out_of_reach(task: Task) -> float:
    """Return the cost above the bound from which most cuts are tried; machine steps hide a little more."""
    has_steps = task.prefer == "least_metal" and all(cut.depth_step_mm > 0.0 for cut in task.cuts)
    return OUT_OF_REACH + (EXCESS_WEIGHT * STEPS_SHARE / task.aim if has_steps else 0.0)


def _dive(task: Task, relaxed: MilpModel, answer: Any) -> tuple[Array, float]:
    """Return depths by the relaxation alone, and their cost: ever more cuts are fixed, the fullest first.

    Of each rule of count the fullest cut that is on in part is fixed, and all is relaxed again around it.
    """
    rules, count = _with_own_bounds(relaxed), len(task.cuts)
    switches = slice(rules.switch, rules.switch + count)
    groups = [np.array(rule.members, dtype=np.int64) for rule in task.candidates.counts]
    groups = groups or [np.arange(count)]
    _keep_fullest_kinds(task, rules, answer.x[switches])
    for _ in range(DIVE_STEPS):
        answer = relaxed_solution(rules)
        if answer.x is None:
            return np.zeros(count), math.inf
        on = rounded(answer.x[switches])
        part = (on > ON_SHARE) & (on < 1.0 - ON_SHARE)
        if not part.any():
            break
        rules.lower[rules.switch + np.flatnonzero(on >= 1.0 - ON_SHARE)] = 1.0
        for group in groups:
            among = group[part[group]]
            if len(among):
                rules.lower[rules.switch + among[int(np.argmax(on[among]))]] = 1.0
    depths = np.zeros(count)
    for k in np.flatnonzero(answer.x[switches] > 0.5).tolist():
        depth = float(answer.x[rules.first[k] : rules.first[k + 1]] @ rules.tables[k])
        depths[k] = min(max(depth, task.cuts[k].least_depth_mm), task.cuts[k].max_depth_mm)
    return depths, float(answer.fun)


ON_SHARE = 1e-6
"""Distance of a switch from off or on that is rounding."""


def _keep_fullest_kinds(task: Task, rules: MilpModel, on: Array) -> None:
    """Allow only the cuts of the groups that the relaxation uses most, where few may be used."""
    for rule in task.candidates.varieties:
        use = [float(on[list(group)].sum()) for group in rule.groups]
        for place in in_order(-np.array(use))[rule.most :].tolist():
            rules.upper[[rules.switch + k for k in rule.groups[place]]] = 0.0


def _with_own_bounds(rules: MilpModel) -> MilpModel:
    """Return a programme with separate bounds that can be changed."""
    own = copy(rules)
    own.lower, own.upper = rules.lower.copy(), rules.upper.copy()
    return own


def _slack(task: Task, relaxed: MilpModel, bound: float) -> float:
    """Return the gap to its bound at which the programme may stop, as a share; of holes, below half of one.

    The bound ignores that cuts are whole, so the best of few cuts is off it by about half a smallest cut. To
    prove that took most of the time, and the first answer was mostly within 1 % of the best. Cuts of several
    sizes for one place come nearer.
    """
    if task.prefer == "fewest_holes":
        return min(0.45 / (bound + 1.0), 0.2)
    least = float(np.abs(relaxed.cost[relaxed.first[:-1]]).min())
    share = 0.5 * least / max(abs(bound), 1e-12)
    floor = 0.5 * GAP[0] if task.prefer == "most_inertia_removed" else GAP[0]  # there every cut counts
    return min(max(share, floor), GAP[1]) * relaxed.places / len(relaxed.tables)


def least_share(residual: Unbalance, tolerance: Tolerance, candidates: Candidates) -> float:
    """Return a lower bound of the share of the permissible value that plans leave (to about 1 %).

    Cuts need not be whole here, so that a plan may well not reach it; but none is better.
    """
    if not candidates.cuts:
        return tolerance.used_share(residual)
    rules = _unpriced(residual, tolerance, candidates)
    rules.cost[rules.excess] = 1.0
    excess = _least_cost(rules)
    return 0.0 if excess <= 1e-6 else math.cos(math.pi / BOUND_SIDES) * AIM_SHARE * (0.5 + excess)


BOUND_SIDES = 24
"""Sides of the polygon of bounds. With the 6 of choosing, a crank on which no cut acts was reported at 201
times its permissible value, with no plan below 174 times."""
MAX_OWN_ENTRIES = 10_000
"""Number of entries up to which a programme is solved here, without loading scipy."""


def _least_cost(rules: MilpModel) -> float:
    """Return the least cost of the programme with switches anywhere between off and on."""
    if math.prod(rules.shape) <= MAX_OWN_ENTRIES:
        rows, most = rules.without_residual()
        size = np.maximum(np.abs(rows).max(axis=1, initial=0.0), 1e-300)[:, None]
        box, cost = (rules.lower[: rules.left], rules.upper[: rules.left]), rules.cost[: rules.left]
        with suppress(ArithmeticError):
            answer = least_cost(cost, rows / size, most / size[:, 0], box)
            if answer is not None:
                return float(cost @ answer)
    return float(relaxed_solution(rules).fun or 0.0)


def greatest_multiple(
    residual: Unbalance, tolerance: Tolerance, candidates: Candidates, most: float
) -> float:
    """Return the largest multiple of an unbalance, up to ``most``, that cuts correct (whole or not).

    The programme's own rows with the multiple in the place of the excess: residual · multiple + effects ≤ 1.
    """
    if not candidates.cuts:
        return 0.0
    rules = _unpriced(residual, tolerance, candidates)
    judged = np.flatnonzero(rules.matrix[:, [rules.excess]].toarray())
    equal = np.flatnonzero(rules.upper_rows == rules.lower_rows)
    matrix = rules.matrix.tolil()
    matrix[judged, rules.excess] = 0.0
    matrix[equal, rules.excess] = -rules.upper_rows[equal][:, None]
    rules.matrix = matrix.tocsr()
    rules.upper_rows[judged] = 1.0 / AIM_SHARE
    rules.upper_rows[equal] = rules.lower_rows[equal] = 0.0
    rules.upper[rules.excess] = most
    rules.cost[rules.excess] = -1.0
    return float(-relaxed_solution(rules).fun)


def _unpriced(residual: Unbalance, tolerance: Tolerance, candidates: Candidates) -> MilpModel:
    """Return the programme over all cuts at no cost yet, with more breakpoints than for choosing."""
    task = Task(residual, tolerance, candidates, "least_metal", AIM_SHARE, *usual(candidates))
    tables = breakpoints(task, 2 * POINTS - 1)
    rules = MilpModel(task, tables, effects_at(task, tables), 0, BOUND_SIDES)
    rules.cost[:] = 0.0
    return rules


def relaxed_solution(rules: MilpModel) -> Any:
    """Return scipy's solution of the programme with switches anywhere between off and on."""
    from scipy.optimize import linprog

    equal = rules.upper_rows == rules.lower_rows
    upper, lower = np.isfinite(rules.upper_rows) & ~equal, np.isfinite(rules.lower_rows) & ~equal
    matrix: Any = vstack_rows(rules.matrix[upper], -rules.matrix[lower])
    return linprog(
        rules.cost,
        A_ub=matrix,
        b_ub=np.concatenate([rules.upper_rows[upper], -rules.lower_rows[lower]]),
        A_eq=rules.matrix[equal],
        b_eq=rules.upper_rows[equal],
        bounds=[*zip(rules.lower.tolist(), rules.upper.tolist(), strict=True)],
        method="highs",
        options={"presolve": False},
    )


def _promising(relaxed: MilpModel, answer: Any, gap: float) -> list[int]:
    """Return the cuts, best first, that can belong to a plan within ``gap`` of the bound.

    By their reduced costs: making a cut worsens the relaxation by at least that.
    """
    prices = answer.lower.marginals + answer.upper.marginals
    count = len(relaxed.tables)
    price = np.array(
        [
            prices[relaxed.first[k] : relaxed.first[k + 1]].min() + prices[relaxed.switch + k]
            for k in range(count)
        ]
    )
    order = in_order(price)
    return [int(k) for k in order if price[k] < gap]


def vstack_rows(*blocks: Any) -> Any:
    from scipy.sparse import vstack

    return vstack(blocks).tocsr()


def _solve_few(
    task: Task,
    tables: Sequence[Array],
    effects: Sequence[Sequence[Moments]],
    least_count: int,
    slack: float,
    nodes: int,
) -> tuple[Array, float]:
    """Solve the mixed-integer programme: λ for each breakpoint, a switch for each cut, the excess share."""
    rules = MilpModel(task, tables, effects, least_count)
    answer = solution(
        IntegerProgram(
            rules.cost,
            rules.integrality,
            rules.lower,
            rules.upper,
            rules.matrix,
            rules.lower_rows,
            rules.upper_rows,
            {"mip_rel_gap": slack, "node_limit": nodes, "presolve": False, "disp": False},
        )
    )
    depths = np.zeros(len(task.cuts))
    if answer.x is None:
        return depths, math.inf
    for k, cut in enumerate(task.cuts):
        if answer.x[rules.switch + k] > 0.5:
            depth = float(answer.x[rules.first[k] : rules.first[k + 1]] @ tables[k])
            depths[k] = min(max(depth, cut.least_depth_mm), cut.max_depth_mm)
    return depths, answer.cost
