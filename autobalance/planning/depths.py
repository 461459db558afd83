"""Depths of chosen cuts: found, rounded to nominal ones, negligible cuts dropped."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from autobalance.correction.contract import Cut, SharedDepth
from autobalance.correction.kind import Candidates
from autobalance.errors import CorrectionError
from autobalance.planning.dual_simplex import least_cost
from autobalance.planning.ties import is_less
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Moments, Unbalance
from autobalance.types import Array
from autobalance.value_classes import dataclass

# Choice of the depths of cuts; pure numbers.
#
# The judged residual is a smooth function of the depths, known exactly with its derivative. Each step solves
# the linear programme of its tangent (`dual_simplex`, or HiGHS through scipy); a few steps reach the exact
# curves, as Newton's method does.


AIM_SHARE = 0.01
"""Share of the permissible value that a plan aims to stay within; well inside, not just passing."""
SIDES = 32
"""Sides of the polygon that stands for a circle in the linear programme; inscribed, so it never flatters."""
STEPS = 40
FEW_DEPTHS = 16
"""Number of depths up to which the programme is solved here, without scipy."""
SETTLED_MM = 1e-7
SAME_MM = 1e-9
"""Distance within which depths are equal to each other, or to a limit or step."""
EVENNESS_WEIGHT = 1e-4
"""Weight of the largest depth beside the removed mass: between equals, even depths win."""


def metal_g(change: Moments) -> float:
    """Return the mass that a change of moments removes or adds [g]."""
    return abs(change.mass_g)


@dataclass(frozen=True, eq=False)
class Plan:
    """Depths for a list of cuts and the predicted residual.

    Attributes
    ----------
    depths_mm : (n,) float
    predicted : Unbalance
        The residual, as judged.
    share : float
        Its largest judged magnitude ÷ the permissible value.
    binding : tuple of str
        The limits that keep the plan from less, where ``share`` is above the aim.
    """

    depths_mm: Array
    predicted: Unbalance
    share: float
    binding: tuple[str, ...]


def plan_depths(
    residual: Unbalance,
    tolerance: Tolerance,
    cuts: Sequence[Cut],
    *,
    start_mm: Array | None = None,
    same_depth: bool = False,
    shared: Sequence[SharedDepth] = (),
    aim: float = AIM_SHARE,
    bounds_mm: tuple[Array, Array] | None = None,
    cost: Callable[[Moments], float] = metal_g,
    worth: float = 0.0,
) -> Plan:
    """Return the depths of smallest judged residual, down to ``aim``, and then of the least metal.

    Parameters
    ----------
    residual : Unbalance
        With every cut at depth zero, as judged.
    tolerance : Tolerance
        Judged values and their limits.
    cuts : sequence of Cut
    start_mm : (n,) float, optional
        Start of the search; default zero.
    same_depth : bool
        One depth for all cuts.
    shared : sequence of SharedDepth
    aim : float
        Share of the permissible value below which less residual is worth no metal.
    bounds_mm : ((n,) float, (n,) float), optional
        Smallest and largest depths; default from zero to what the cuts allow.
    cost : callable
        Cost of a change of moments, linear in it; default the metal.
    worth : float
        Share of the cost that one more step must save, once the aim is reached.

    Returns
    -------
    Plan
    """
    count = len(cuts)
    least, most = bounds_mm or (np.zeros(count), np.array([cut.max_depth_mm for cut in cuts]))
    depths = least if start_mm is None else np.clip(start_mm, least, most)
    if same_depth and count:
        depths = np.full(count, min(depths.mean(), most.min()))
    best, spent = _looked_at(residual, tolerance, cuts, depths, cost)
    trust = math.inf
    for _ in range(STEPS if count else 0):
        near = np.maximum(least, depths - trust), np.minimum(most, depths + trust)
        target = _tangent_step(best, tolerance, cuts, near, same_depth, shared, aim, cost)
        target = _at_ends(target, least, most)
        here, spends = _looked_at(residual, tolerance, cuts, target, cost)
        moved = float(np.abs(target - depths).max())
        enough = aim * (1.0 + 1e-6)
        good = worth > 0.0 and best.share <= enough
        if (
            is_less(spends, spent)
            if max(here.share, best.share) <= enough
            else is_less(here.share, best.share)
        ):
            done = good and spent - spends <= worth * spends
            best, spent, depths = here, spends, target
        else:  # the curves bend away from the tangent: look nearer
            done = good and moved <= ONLY_MM
            trust = 0.25 * min(trust, moved)
        if done or moved <= SETTLED_MM:
            break
    binding = tuple(
        dict.fromkeys(
            cut.limit
            for cut, depth in zip(cuts, best.depths_mm, strict=True)
            if depth >= cut.max_depth_mm - 1e-6
        )
    )
    return Plan(best.depths_mm, best.predicted, best.share, binding if best.share > aim else ())


def _at_ends(depths: Array, least: Array, most: Array) -> Array:
    """Return depths with those that are a bound except for rounding set to it."""
    deep: Array = np.where(np.abs(depths - most) <= SAME_MM, most, depths)
    return np.where(np.abs(deep - least) <= SAME_MM, least, deep)


def judged_plan(residual: Unbalance, tolerance: Tolerance, cuts: Sequence[Cut], depths: Array) -> Plan:
    """Return the plan of some depths, its residual from the exact curves."""
    return _looked_at(residual, tolerance, cuts, depths, metal_g)[0]


def _looked_at(
    residual: Unbalance,
    tolerance: Tolerance,
    cuts: Sequence[Cut],
    depths: Array,
    cost: Callable[[Moments], float],
) -> tuple[Plan, float]:
    """Return the plan of some depths, its residual from the exact curves, and its cost."""
    total = 0.0
    for cut, depth in zip(cuts, depths.tolist(), strict=True):
        if depth > 0.0:
            change = cut.effect(depth)
            residual = residual + Unbalance.of(change)
            total += cost(change)
    return Plan(depths, residual, tolerance.used_share(residual), ()), total


def resultant_and_moment(change: Moments) -> Array:
    """Return the change of (U, P) (4,) by a change of moments, in the order of `judged_rows`' columns."""
    return np.array([*change.first_g_mm[:2], *change.second_g_mm2[:2, 2]])


def judged_rows(tolerance: Tolerance) -> Array:
    """Return the matrix (k, 4) that takes (U, P) to the judged vectors ÷ their permissible values.

    Two rows each: the resultant; with a dynamic verdict planes A and B.
    """
    eye = np.eye(2)
    blocks = [np.hstack([eye, 0.0 * eye]) / tolerance.permissible_g_mm]
    if tolerance.judge == "dynamic":
        a, b = tolerance.planes
        span = b.z_mm - a.z_mm
        blocks.append(np.hstack([b.z_mm * eye, -eye]) / span / a.permissible_g_mm)
        blocks.append(np.hstack([-a.z_mm * eye, eye]) / span / b.permissible_g_mm)
    return np.vstack(blocks)


def independent_rows(tolerance: Tolerance) -> Array:
    """Return the rows of `judged_rows` that imply the others: both planes', or the resultant's alone."""
    return judged_rows(tolerance)[-4 if tolerance.judge == "dynamic" else -2 :]


def _tangent_step(
    here: Plan,
    tolerance: Tolerance,
    cuts: Sequence[Cut],
    bounds: tuple[Array, Array],
    same_depth: bool,
    shared: Sequence[SharedDepth],
    aim: float,
    cost_of: Callable[[Moments], float],
) -> Array:
    """Solve the linear programme of the tangent at a plan for (depths, excess share, largest depth)."""
    count = len(cuts)
    least, most = bounds
    depths, now = here.depths_mm, here.predicted.components
    rates = [cut.rate(float(depth)) for cut, depth in zip(cuts, depths, strict=True)]
    slopes = np.array([resultant_and_moment(rate) for rate in rates]).T
    rows = judged_rows(tolerance)
    matrix, at_zero = rows @ slopes, rows @ (now - slopes @ depths)
    if not shared:
        only = _only_answer(matrix, at_zero, bounds, same_depth, aim)
        if only is not None:
            return only
    angle = np.arange(SIDES) * (2.0 * math.pi / SIDES)
    directions = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inner = math.cos(math.pi / SIDES)
    # direction · (at_zero + matrix d) <= inner (aim + excess), in units of the aim to keep numbers near 1
    a_ub, b_ub = [], []
    for k in range(0, len(rows), 2):
        a_ub.append(
            np.hstack(
                [directions @ matrix[k : k + 2] / aim, np.full((SIDES, 1), -inner), np.zeros((SIDES, 1))]
            )
        )
        b_ub.append(inner * 0.5 - directions @ at_zero[k : k + 2] / aim)
    costs = np.array([cost_of(rate) for rate in rates])
    worst = float(np.abs(costs) @ most) or 1.0
    evenness = EVENNESS_WEIGHT / max(float(most.max()), 1e-9)
    a_ub.append(np.hstack([np.eye(count), np.zeros((count, 1)), -np.ones((count, 1))]))
    b_ub.append(np.zeros(count))
    for pair in shared:
        row = np.zeros(count + 2)
        row[[pair.first, pair.second]] = 1.0
        a_ub.append(row[None])
        b_ub.append(np.array([pair.most_mm]))
    cost = np.concatenate([costs / worst, [EXCESS_COST], [evenness]])
    box = np.append(least, [0.0, 0.0]), np.append(most, [math.inf, math.inf])
    answer = _least_cost(cost, np.vstack(a_ub), np.concatenate(b_ub), box, same_depth)
    if answer is None:  # the depths at hand are always feasible: the excess is free
        raise CorrectionError(
            f"the planner cannot compute with a permissible {tolerance.permissible_g_mm:.3g} g·mm and "
            f"{here.predicted.magnitude_g_mm:.3g} g·mm to correct; check masses, speed and grade"
        )
    return np.clip(answer[:count], least, most)


def _least_cost(
    cost: Array, rows: Array, most: Array, bounds: tuple[Array, Array], same_depth: bool
) -> Array | None:
    """Return the solution of a linear programme whose last two unknowns are not depths; None without one.

    Few depths are solved without loading scipy, which solves the others; depths that must be the same are one
    unknown.
    """
    count = len(cost) - 2
    if same_depth and count > 1:
        (low, high), others = (bounds[0][:count].max(), bounds[1][:count].min()), slice(count, None)
        if low > high:
            return None
        answer = _least_cost(
            np.append(cost[:count].sum(), cost[others]),
            np.column_stack([rows[:, :count].sum(axis=1), rows[:, others]]),
            most,
            (np.append(low, bounds[0][others]), np.append(high, bounds[1][others])),
            same_depth=False,
        )
        return None if answer is None else np.append(np.full(count, answer[0]), answer[1:])
    if count <= FEW_DEPTHS:
        with suppress(ArithmeticError):
            return least_cost(cost, rows, most, bounds)

    from scipy.optimize import linprog

    solution: Array | None = linprog(
        cost,
        A_ub=rows,
        b_ub=most,
        bounds=[*zip(bounds[0].tolist(), bounds[1].tolist(), strict=True)],
        method="highs",
    ).x
    return solution


EXCESS_COST = 10.0
"""Cost of an excess residual, in units of the aim, over the cost of all the metal there is."""
ONLY_MM = 1e-3
"""Depths that the aim leaves free by less than this are settled: no machine sets them nearer."""


def _only_answer(
    matrix: Array, at_zero: Array, bounds: tuple[Array, Array], same_depth: bool, aim: float
) -> Array | None:
    """Return the depths of smallest residual where the aim leaves no room for any others; else None.

    Newton's step: a linear programme would find the same depths, and its library takes longer to load than
    everything else that a small crank needs.
    """
    least, most = bounds
    shares = np.ones((len(most), 1)) if same_depth else np.eye(len(most))
    free = matrix @ shares
    depths, _, rank, singular = np.linalg.lstsq(free, -at_zero)
    if not len(singular) or rank < shares.shape[1] or aim > ONLY_MM * float(singular[-1]):
        return None
    target: Array = shares @ depths
    left = (at_zero + matrix @ target).reshape(-1, 2)
    within: Array = np.clip(target, least, most)
    if (np.hypot(*left.T) > 0.5 * aim).any() or (np.abs(within - target) > SAME_MM).any():
        return None
    return within


# Plans without negligible cuts: nobody sets up a machine for them.


NEGLIGIBLE_EFFECT_SHARE = 1e-3
"""Share of the permissible values below which a cut is left out. A rim that is turned by less
than its facets are back loses the tips of their edges alone: too little to be found in the file again."""


def worthwhile(residual: Unbalance, tolerance: Tolerance, candidates: Candidates, plan: Plan) -> Plan:
    """Return a plan without its negligible cuts; unchanged where it needs them together.

    Where a job asks for one depth for all cuts, all of them stay.
    """

    def is_idle(cut: Cut, depth: float) -> bool:
        return depth > 0.0 and tolerance.used_share(Unbalance.of(cut.effect(depth))) < NEGLIGIBLE_EFFECT_SHARE

    depths = plan.depths_mm.tolist()
    idle = np.array([is_idle(*each) for each in zip(candidates.cuts, depths, strict=True)], dtype=bool)
    if candidates.same_depth or not idle.any():
        return plan
    without = judged_plan(residual, tolerance, candidates.cuts, np.where(idle, 0.0, plan.depths_mm))
    if without.share > plan.share + AIM_SHARE or without.share > 1.0 >= plan.share:
        return plan
    return replace(without, binding=plan.binding)


# Planned depths set to the limit, step or common value that they stand for, to the last digit.
#
# Solvers end a depth at a limit give or take some roundings, which differ from processor to processor. A cut
# at 0.9999999999999991 mm beside one at 1 mm is another solid, whose faces no longer lie in one plane.


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
