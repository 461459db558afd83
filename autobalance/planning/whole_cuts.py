"""Choose which cuts to make where that is a matter of whole numbers: holes, drills, slugs, machine steps.

Where a handful of cuts suffices, `handful` finds the lightest; elsewhere a mixed-integer linear programme
(HiGHS through scipy) picks the cuts on piecewise linear effects. `plan` finds their depths on the exact
curves, and the depths are then rounded to the machine's steps together, so that the residual stays least.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from autobalance.correction.kind import Apart, Array, Cut, Offer, Prefer, SharedDepth
from autobalance.planning.depths import (
    AIM,
    Plan,
    independent_rows,
    judged_plan,
    judged_rows,
    plan_depths,
    resultant_and_moment,
)
from autobalance.planning.enumeration import lightest_set
from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance

_Pair = TypeVar("_Pair", Apart, SharedDepth)

POINTS = 3
"""Depths of each cut at which the programme knows its effect exactly."""
SIDES = 6
"""Sides of the polygon that stands for the circle of a judged vector while choosing."""
GAP = 0.015, 0.1
"""How far from its bound the programme may stop, as a share: half of a least cut, but between these; less
where several cuts are offered for one place."""
NODES = 100
"""Branches looked at, at most: a limit that gives the same answer on every machine, unlike seconds."""
EXCESS_WEIGHT = 100.0
"""Metal that one aim of residual is worth, in units of a usual correction."""
WORTH = 1e-4
"""Share of the cost that another step of the depths must save."""
ROUNDS = 4
COMBINATIONS = 50_000
"""Roundings tried, at most."""
STEPS_ASIDE = 3


def choose(
    residual: Unbalance,
    tolerance: Tolerance,
    offer: Offer,
    *,
    prefer: Prefer = "least_metal",
    start_mm: Array | None = None,
    aim: float = AIM,
) -> Plan:
    """Return the cuts to make and their depths.

    Parameters
    ----------
    residual : Unbalance
        With no cut made, as judged.
    tolerance : Tolerance
    offer : Offer
        The cuts at hand and their rules.
    prefer : Prefer
        What to spare among plans that reach the aim.
    start_mm : (n,) float, optional
        An earlier plan: its choice of cuts is kept if it still serves.
    aim : float
        Share of the permissible value below which less residual is worth nothing.

    Returns
    -------
    Plan
    """
    if not offer.cuts or (not _is_discrete(offer) and prefer == "least_metal"):
        return plan_depths(
            residual,
            tolerance,
            offer.cuts,
            start_mm=start_mm,
            same_depth=offer.same_depth,
            shared=offer.shared,
            aim=aim,
        )
    task = _Task(residual, tolerance, offer, prefer, aim, *_usual(offer))
    if start_mm is not None and start_mm.any():
        kept = _finished(task, _settled(task, start_mm))
        if kept.share <= max(aim, _rounding_share(task, start_mm)):
            return kept
    first = _first(task)
    plan = _finished(task, first)
    for extra in (1, 2):
        if first.share > ROUNDED or plan.share <= ROUNDED:
            break
        again = _finished(task, _chosen(task, int(np.count_nonzero(plan.depths_mm)) + extra, FEW))
        plan = again if again.share < plan.share * (1.0 - aim) else plan
    return plan


REFINED = 0.9
"""Share of the former residual below which another look at the exact curves is worth its time; nor is it
where the programme's bound says that no choice comes near the aim."""
HOPELESS = 3.0
"""Share of the permissible value that no better look at the exact curves makes up."""
ROUNDED = 0.5
"""Share of the permissible value that rounding to machine steps may leave before more cuts are tried."""


@dataclass(frozen=True, eq=False)
class _Task:
    residual: Unbalance
    tolerance: Tolerance
    offer: Offer
    prefer: Prefer
    aim: float
    usual_g: float
    usual_radius_mm: float

    @property
    def cuts(self) -> Sequence[Cut]:
        return self.offer.cuts

    def cost(self, change: Moments) -> float:
        """Return what a change of moments costs; linear in it as long as it keeps its sign."""
        if self.prefer == "most_inertia_removed":
            return change.polar_inertia_g_mm2
        if self.prefer == "least_inertia_change":
            return abs(change.polar_inertia_g_mm2)
        return abs(change.mass_g)


def _usual(offer: Offer) -> tuple[float, float]:
    """Return the mass and the radius of a usual correction: four times the mean of the deepest cuts."""
    changes = [cut.effect(cut.max_depth_mm) for cut in offer.cuts]
    mass = 4.0 * sum(abs(change.mass_g) for change in changes) / max(len(changes), 1)
    inertia = 4.0 * sum(abs(change.polar_inertia_g_mm2) for change in changes) / max(len(changes), 1)
    return (mass, math.sqrt(inertia / mass)) if mass > 0.0 else (1.0, 1.0)


def _is_discrete(offer: Offer) -> bool:
    return bool(offer.counts or offer.apart) or any(
        cut.least_depth_mm > 0.0 or cut.depth_step_mm > 0.0 for cut in offer.cuts
    )


# --- which cuts ---------------------------------------------------------------------------------------------


def _first(task: _Task) -> Plan:
    """Return the lightest few cuts, or where others may be lighter, what the integer programme chooses."""
    few, unseen_g = _few(task)
    if few is not None and _weight(task, few) <= (1.0 + UNSEEN) * unseen_g:
        return few
    plan = _chosen(task, 0, FEW) if few is None else _chosen(task, 0, FEW[:1], rounds=1)
    if few is None or max(plan.share, few.share) > task.aim * (1.0 + 1e-6):
        return few if few is not None and few.share < plan.share else plan
    return few if _weight(task, few) < _weight(task, plan) else plan


def _few(task: _Task) -> tuple[Plan | None, float]:
    """Return the plan of the lightest few cuts, if any, and what others weigh at least."""
    offer = task.offer
    if task.prefer != "least_metal" or offer.shared or any(cut.least_depth_mm <= 0.0 for cut in task.cuts):
        return None, 0.0
    enough = task.aim * (1.0 + 1e-6)

    def serves(depths: Array) -> bool:
        here = judged_plan(task.residual, task.tolerance, task.cuts, depths)
        return here.share <= enough or _settled(task, depths).share <= enough

    depths, unseen_g = lightest_set(task.residual, task.tolerance, offer, task.aim, serves)
    return (None if depths is None else _settled(task, depths)), unseen_g


def _weight(task: _Task, plan: Plan) -> float:
    return sum(task.cost(cut.effect(float(d))) for cut, d in zip(task.cuts, plan.depths_mm, strict=True) if d)


def _chosen(task: _Task, least_count: int, sizes: Sequence[int], rounds: int = ROUNDS) -> Plan:
    """Return depths by the mixed-integer programme, refined until they hold on the exact curves."""
    tables = _tables(task)
    best = _settled(task, np.zeros(len(task.cuts)))
    for _ in range(rounds):
        depths, bound = _solve(task, tables, least_count, sizes)
        here = _settled(task, depths)
        is_new = here.share < REFINED * best.share and bound < EXCESS_WEIGHT
        if here.share < best.share:
            best = here
        if not is_new or not task.aim * (1.0 + 1e-6) < here.share <= HOPELESS:
            break
        if not _add_points(tables, depths, here.depths_mm):
            break
    return best


def _add_points(tables: list[Array], *answers: Array) -> bool:
    """Make the effects exact at the depths of some answers; tell whether that changed anything."""
    added = False
    for depths in answers:
        for k in np.flatnonzero(depths).tolist():
            if np.abs(tables[k] - depths[k]).min() > 1e-3:
                tables[k] = np.sort(np.append(tables[k], depths[k]))
                added = True
    return added


def _tables(task: _Task, count: int = POINTS) -> list[Array]:
    """Return each cut's breakpoints: evenly over the depths it may have, and where neighbours end it.

    An even point makes way for an end nearer than half a space.
    """
    ends: list[set[float]] = [set() for _ in task.cuts]
    for pair in task.offer.apart:
        for k in (pair.first, pair.second):
            if task.cuts[k].least_depth_mm < pair.most_mm < task.cuts[k].max_depth_mm:
                ends[k].add(pair.most_mm)
    tables = []
    for cut, places in zip(task.cuts, ends, strict=True):
        least, most = cut.least_depth_mm, cut.max_depth_mm
        if most - least < 1e-9:
            tables.append(np.array([most]))
            continue
        even, end = np.linspace(least, most, count), np.array(sorted(places))
        if len(end):
            near = np.abs(even[:, None] - end).min(axis=1) < 0.5 * (even[1] - even[0])
            even = np.concatenate([even[~near], even[[0, -1]]])
        points = np.unique(np.concatenate([even, end]))
        tables.append(points[points > 0.0])
    return tables


def _solve(
    task: _Task, tables: Sequence[Array], least_count: int, sizes: Sequence[int]
) -> tuple[Array, float]:
    """Return depths by the integer programme over the cuts that look best in its relaxation, and its bound.

    The relaxation's value is a bound for the whole programme: where the few come near it, the rest need not
    be looked at.
    """
    count = len(task.cuts)
    effects = _effects(task, tables)
    relaxed = _MilpModel(task, tables, effects, least_count)
    answer = _relaxed(relaxed)
    if answer.x is None:  # more cuts asked for than the counts allow
        return np.zeros(count), math.inf
    best, value = np.zeros(count), math.inf
    bound = float(answer.fun or 0.0)
    slack = _slack(task, relaxed, bound)
    looked_at: set[int] = set()
    for size in sizes:
        few = sorted(_promising(relaxed, answer, value - bound)[:size])
        if looked_at.issuperset(few) or (size == FEW[-1] and value - bound < OUT_OF_REACH):
            break
        looked_at.update(few)
        found, here = _solve_few(
            _part(task, few),
            [tables[k] for k in few],
            [effects[k] for k in few],
            least_count,
            slack,
        )
        if here < value:
            value = here
            best = np.zeros(count)
            best[few] = found
        near = NEAR if 4 * len(looked_at) >= count else 0.0
        if value - bound <= max(2.0 * slack, near) * abs(value) + 1e-6:
            break
    return best, bound


def _slack(task: _Task, relaxed: _MilpModel, bound: float) -> float:
    """Return how far from its bound the programme may stop, as a share: of holes, less than half of one.

    The bound knows nothing of whole cuts, so that of a few the best stands off it by half a least one or so;
    to prove that took most of the time, and what was found first was mostly within 1 % of the best. Cuts of
    several sizes for one place come nearer.
    """
    if task.prefer == "fewest_holes":
        return min(0.45 / (bound + 1.0), 0.2)
    least = float(np.abs(relaxed.cost[relaxed.first[:-1]]).min())
    share = 0.5 * least / max(abs(bound), 1e-12)
    return min(max(share, GAP[0]), GAP[1]) * relaxed.places / len(relaxed.tables)


def least_share(residual: Unbalance, tolerance: Tolerance, offer: Offer) -> float:
    """Return a share of the permissible value that no plan within the rules gets below (to about 1 %).

    Whole numbers are let go of here, so that a plan may well not reach it; but none is better.
    """
    if not offer.cuts:
        return tolerance.used_share(residual)
    rules = _unpriced(residual, tolerance, offer)
    rules.cost[rules.excess] = 1.0
    excess = float(_relaxed(rules).fun or 0.0)
    return 0.0 if excess <= 1e-6 else math.cos(math.pi / SIDES) * AIM * (0.5 + excess)


def greatest_multiple(residual: Unbalance, tolerance: Tolerance, offer: Offer, most: float) -> float:
    """Return how many times an unbalance the cuts can correct, up to ``most`` (whole numbers are let go of).

    The programme's own rows with the multiple in the place of the excess: residual · multiple + effects ≤ 1.
    """
    if not offer.cuts:
        return 0.0
    rules = _unpriced(residual, tolerance, offer)
    judged = np.flatnonzero(rules.matrix[:, [rules.excess]].toarray())
    equal = np.flatnonzero(rules.upper_rows == rules.lower_rows)
    matrix = rules.matrix.tolil()
    matrix[judged, rules.excess] = 0.0
    matrix[equal, rules.excess] = -rules.upper_rows[equal][:, None]
    rules.matrix = matrix.tocsr()
    rules.upper_rows[judged] = 1.0 / AIM
    rules.upper_rows[equal] = rules.lower_rows[equal] = 0.0
    rules.upper[rules.excess] = most
    rules.cost[rules.excess] = -1.0
    return float(-_relaxed(rules).fun)


def _unpriced(residual: Unbalance, tolerance: Tolerance, offer: Offer) -> _MilpModel:
    """Return the rules over all cuts, finer than for choosing, in which nothing costs anything yet."""
    task = _Task(residual, tolerance, offer, "least_metal", AIM, *_usual(offer))
    tables = _tables(task, 2 * POINTS - 1)
    rules = _MilpModel(task, tables, _effects(task, tables), 0)
    rules.cost[:] = 0.0
    return rules


def _effects(task: _Task, tables: Sequence[Array]) -> list[list[Moments]]:
    return [[cut.effect(float(d)) for d in points] for cut, points in zip(task.cuts, tables, strict=True)]


def _relaxed(rules: _MilpModel) -> Any:
    """Solve the programme with switches anywhere between off and on."""
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


def _promising(relaxed: _MilpModel, answer: Any, gap: float) -> list[int]:
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
    order = np.argsort(price, kind="stable")
    return [int(k) for k in order if price[k] < gap]


UNSEEN = 0.03
"""How near to what unseen cuts weigh at least the lightest few are taken for good, as a share."""
NEAR = 0.06
"""How near the bound over all cuts an answer from a quarter of them is taken for good, as a share.

Looks at more cuts took most of the time and found nothing lighter by more than 0.4 %.
"""
FEW = (56, 100, 250)
"""How many cuts the integer programme looks at: the best few, then those that could still be better."""
OUT_OF_REACH = 1.0
"""Cost above the bound, in usual corrections, that only excess residual makes: the most cuts are for that."""


def vstack_rows(*blocks: Any) -> Any:
    """Return sparse rows one under the other."""
    from scipy.sparse import vstack

    return vstack(blocks).tocsr()


def _solve_few(
    task: _Task,
    tables: Sequence[Array],
    effects: Sequence[Sequence[Moments]],
    least_count: int,
    slack: float,
) -> tuple[Array, float]:
    """Solve the mixed-integer programme: λ for each breakpoint, a switch for each cut, the excess share."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    rules = _MilpModel(task, tables, effects, least_count)
    with _silenced():
        answer = milp(
            rules.cost,
            integrality=rules.integrality,
            bounds=Bounds(rules.lower, rules.upper),
            constraints=LinearConstraint(rules.matrix, rules.lower_rows, rules.upper_rows),
            options={"mip_rel_gap": slack, "node_limit": NODES, "presolve": False},
        )
    depths = np.zeros(len(task.cuts))
    if answer.x is None:
        return depths, math.inf
    for k, cut in enumerate(task.cuts):
        if answer.x[rules.switch + k] > 0.5:
            depth = float(answer.x[rules.first[k] : rules.first[k + 1]] @ tables[k])
            depths[k] = min(max(depth, cut.least_depth_mm), cut.max_depth_mm)
    return depths, float(answer.fun)


@contextmanager
def _silenced() -> Iterator[None]:
    """Keep the solver's own output away: HiGHS prints some lines past every option, on file descriptor 1."""
    try:
        sys.stdout.flush()
        kept = os.dup(1)
    except (OSError, ValueError):  # no standard output at all
        yield
        return
    sink = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(sink, 1)
        yield
    finally:
        _flush_c()
        os.dup2(kept, 1)
        os.close(kept)
        os.close(sink)


def _flush_c() -> None:
    """Empty the C library's output buffers."""
    import ctypes

    try:
        ctypes.CDLL(None).fflush(None)
    except (OSError, TypeError, AttributeError):  # Windows: the solver's C library is its own
        return


def _part(task: _Task, few: Sequence[int]) -> _Task:
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
    )
    return replace(task, offer=part)


class _MilpModel:
    """The programme's matrix, row by row."""

    def __init__(
        self,
        task: _Task,
        tables: Sequence[Array],
        effects: Sequence[Sequence[Moments]],
        least_count: int,
    ) -> None:
        from scipy.sparse import coo_array

        count = len(tables)
        sizes = [len(points) for points in tables]
        self.first = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
        self.switch = int(self.first[-1])
        self.excess = self.switch + count
        self.change = self.excess + 1
        self.left = self.change + 1
        self.tables = tables
        self._rows: list[Any] = []
        self._columns: list[Any] = []
        self._values: list[Any] = []
        self._low: list[float] = []
        self._high: list[float] = []
        self._weights_follow_switches(task.cuts)
        self._residual_rows(task, effects)
        self._apart_rows(task)
        for pair in task.offer.shared:
            self._add_depths([(pair.first, 1.0), (pair.second, 1.0)], -math.inf, pair.most_mm)
        for rule in task.offer.counts:
            self._add(
                [self.switch + k for k in rule.members], [1.0] * len(rule.members), -math.inf, rule.most
            )
        if least_count:
            self._add(range(self.switch, self.excess), [1.0] * count, least_count, math.inf)
        self.cost = self._cost_row(task, effects)
        free = len(independent_rows(task.tolerance))
        width = self.left + free
        self.upper = np.concatenate([np.ones(self.excess), np.full(2 + free, np.inf)])
        self.lower = np.concatenate([np.zeros(self.left), np.full(free, -np.inf)])
        self.integrality = np.zeros(width, dtype=np.int64)
        self.integrality[self.switch : self.excess] = 1
        rows = np.concatenate(self._rows)
        self.matrix = coo_array(
            (np.concatenate(self._values), (rows, np.concatenate(self._columns))),
            shape=(len(self._low), width),
        ).tocsr()
        self.lower_rows, self.upper_rows = np.array(self._low), np.array(self._high)

    def _add(self, columns: Any, values: Any, low: float, high: float) -> None:
        columns = np.asarray(columns, dtype=np.int64)
        self._rows.append(np.full(len(columns), len(self._low)))
        self._columns.append(columns)
        self._values.append(np.asarray(values, dtype=np.float64))
        self._low.append(low)
        self._high.append(high)

    def _add_depths(self, depths: Sequence[tuple[int, float]], low: float, high: float) -> None:
        """Add a row in terms of depths."""
        columns: list[int] = []
        values: list[float] = []
        for k, factor in depths:
            columns += range(self.first[k], self.first[k + 1])
            values += (factor * self.tables[k]).tolist()
        self._add(columns, values, low, high)

    def _weights_follow_switches(self, cuts: Sequence[Cut]) -> None:
        for k, cut in enumerate(cuts):
            size = self.first[k + 1] - self.first[k]
            columns = [*range(self.first[k], self.first[k + 1]), self.switch + k]
            low = 0.0 if cut.least_depth_mm > 0.0 else -1.0  # the weight that is left is that of depth zero
            self._add(columns, [1.0] * size + [-1.0], low, 0.0)

    def _residual_rows(self, task: _Task, effects: Sequence[Sequence[Moments]]) -> None:
        """Give the residual columns of its own, so that few rows name every cut; keep it in polygons."""
        rows = judged_rows(task.tolerance)
        own = independent_rows(task.tolerance)
        size = len(own)
        table = np.array([resultant_and_moment(effect) for group in effects for effect in group]).T
        effect = own @ table / task.aim
        now = own @ task.residual.components / task.aim
        for k in range(size):
            columns = np.append(np.arange(self.switch), self.left + k)
            self._add(columns, np.append(effect[k], -1.0), -now[k], -now[k])
        angle = (np.arange(SIDES) + 0.5) * (2.0 * math.pi / SIDES)
        inner = math.cos(math.pi / SIDES)
        judged = rows @ np.linalg.pinv(own)  # from the residual's columns to every judged vector
        for k in range(0, len(rows), 2):
            for a in angle:
                u = np.array([math.cos(a), math.sin(a)])
                values = np.append(u @ judged[k : k + 2], -inner)
                self._add([*range(self.left, self.left + size), self.excess], values, -math.inf, 0.5 * inner)

    def _apart_rows(self, task: _Task) -> None:
        never = [pair for pair in task.offer.apart if _is_never(pair, task.cuts)]
        for clique in _cliques(never, len(task.cuts)):
            self._add([self.switch + k for k in clique], [1.0] * len(clique), -math.inf, 1.0)
        site = _sites(never, len(task.cuts))
        self.places = max(site) + 1
        most: dict[tuple[int, int], dict[tuple[int, int], float]] = {}
        for pair in task.offer.apart:
            for k, other in ((pair.first, pair.second), (pair.second, pair.first)):
                most.setdefault((site[k], site[other]), {})[k, other] = pair.most_mm
        for (here, there), pairs in most.items():
            if here != there:
                self._beside(pairs)

    def _beside(self, most_mm: Mapping[tuple[int, int], float]) -> None:
        """Allow no weight deeper at one site than the cut at another lets it be.

        Of a site's cuts one is made at most. So where any of some others is made, all weight lies above the
        depth that the most lenient of them allows; one row for each who may be that.
        """
        here = sorted({k for k, _ in most_mm})
        rows: set[tuple[tuple[int, ...], tuple[int, ...]]] = set()
        for lenient in sorted({other for _, other in most_mm}):
            bound = {k: most_mm[k, lenient] for k in here if (k, lenient) in most_mm}
            others = [
                other
                for other in sorted({other for _, other in most_mm})
                if all(most_mm.get((k, other), math.inf) <= most + 1e-9 for k, most in bound.items())
            ]
            deeper = [
                int(self.first[k] + n)
                for k, most in bound.items()
                for n in np.flatnonzero(self.tables[k] > most + 1e-9)
            ]
            if deeper:
                rows.add((tuple(deeper), tuple(others)))
        for deeper_columns, made in sorted(rows):
            columns = [*deeper_columns, *(self.switch + other for other in made)]
            self._add(columns, [1.0] * len(columns), -math.inf, 1.0)

    def _cost_row(self, task: _Task, effects: Sequence[Sequence[Moments]]) -> Array:
        """Cost in units of a usual correction, so that the excess outweighs it."""
        cost = np.zeros(self.left + len(independent_rows(task.tolerance)))
        masses = np.array([abs(effect.mass_g) for group in effects for effect in group])
        cost[: self.switch] = masses / task.usual_g
        inertia = np.array([effect.polar_inertia_g_mm2 for group in effects for effect in group])
        usual_inertia = task.usual_g * task.usual_radius_mm**2
        if task.prefer == "fewest_holes":
            cost[: self.switch] *= 0.01
            cost[self.switch : self.excess] = 1.0
        elif task.prefer == "most_inertia_removed":
            cost[: self.switch] = inertia / usual_inertia
        elif task.prefer == "least_inertia_change":
            cost[: self.switch] *= 0.01
            cost[self.change] = 1.0
            for sign in (1.0, -1.0):  # change ≥ |Σ ΔJ|
                values = np.append(sign * inertia / usual_inertia, -1.0)
                self._add(np.append(np.arange(self.switch), self.change), values, -math.inf, 0.0)
        cost[self.excess] = EXCESS_WEIGHT
        return cost


def _is_never(pair: Apart, cuts: Sequence[Cut]) -> bool:
    return pair.most_mm < max(cuts[pair.first].least_depth_mm, cuts[pair.second].least_depth_mm)


def _sites(never: Sequence[Apart], count: int) -> list[int]:
    """Part cuts into sets of which any two exclude each other: the drills for one place, for instance."""
    near: list[set[int]] = [set() for _ in range(count)]
    for pair in never:
        near[pair.first].add(pair.second)
        near[pair.second].add(pair.first)
    members: list[list[int]] = []
    site = [0] * count
    for k in range(count):
        for other in sorted(near[k]):
            if other < k and near[k].issuperset(members[site[other]]):
                site[k] = site[other]
                break
        else:
            site[k] = len(members)
            members.append([])
        members[site[k]].append(k)
    return site


def _cliques(pairs: Sequence[Apart], count: int) -> Iterator[list[int]]:
    """Yield sets of cuts of which any two exclude each other, until every pair is in one."""
    near: list[set[int]] = [set() for _ in range(count)]
    for pair in pairs:
        near[pair.first].add(pair.second)
        near[pair.second].add(pair.first)
    covered: set[tuple[int, int]] = set()
    for pair in pairs:
        if (pair.first, pair.second) in covered:
            continue
        clique = [pair.first, pair.second]
        for other in sorted(near[pair.first] & near[pair.second]):
            if all(other in near[member] for member in clique):
                clique.append(other)
        clique.sort()
        covered.update((a, b) for n, a in enumerate(clique) for b in clique[n + 1 :])
        yield clique


# --- how deep -----------------------------------------------------------------------------------------------


def _settled(task: _Task, depths: Array) -> Plan:
    """Return the exact depths of the cuts that ``depths`` makes, within their limits."""
    made = [int(k) for k in np.flatnonzero(depths > 0.0)]
    part = _part(task, made)
    plan = plan_depths(
        task.residual,
        task.tolerance,
        part.cuts,
        start_mm=depths[made],
        shared=part.offer.shared,
        aim=task.aim,
        bounds_mm=_bounds(task, made),
        cost=task.cost,
        worth=WORTH,
    )
    whole = np.zeros(len(depths))
    whole[made] = plan.depths_mm
    return replace(plan, depths_mm=whole)


def _bounds(task: _Task, made: Sequence[int]) -> tuple[Array, Array]:
    """Return least and greatest depths of the cuts made, with regard to their neighbours."""
    least = np.array([task.cuts[k].least_depth_mm for k in made])
    most = np.array([task.cuts[k].max_depth_mm for k in made])
    place = {k: n for n, k in enumerate(made)}
    for pair in task.offer.apart:
        if pair.first in place and pair.second in place:
            for k in (place[pair.first], place[pair.second]):
                most[k] = max(min(most[k], pair.most_mm), least[k])
    return least, most


def _finished(task: _Task, plan: Plan) -> Plan:
    """Round the depths to the machine's steps and name what binds."""
    rounded = _rounded(task, plan)
    limits = [
        cut.limit
        for cut, d in zip(task.cuts, rounded.depths_mm, strict=True)
        if d >= cut.max_depth_mm - 1e-6 and cut.max_depth_mm > cut.least_depth_mm
    ]
    for rule in task.offer.counts:
        if sum(rounded.depths_mm[k] > 0.0 for k in rule.members) >= rule.most:
            limits.append(rule.limit)
    binding = tuple(dict.fromkeys(limits)) if rounded.share > max(task.aim, 1.0) else ()
    return replace(rounded, binding=binding)


def _rounding_share(task: _Task, depths: Array) -> float:
    """Return the share of the permissible value that half a step of each cut can make up."""
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


def _rounded(task: _Task, plan: Plan) -> Plan:
    """Return the depths on their machines' steps that leave least, among the nearest ones."""
    made = [k for k in np.flatnonzero(plan.depths_mm).tolist() if task.cuts[k].depth_step_mm > 0.0]
    if not made:
        return plan
    least, most = _bounds(task, made)
    room = COMBINATIONS
    choices = []
    count = len(made)
    for n, k in enumerate(made):
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
    return _best_combination(task, plan, made, choices)


def _best_combination(task: _Task, plan: Plan, made: Sequence[int], choices: Sequence[Array]) -> Plan:
    """Look through all combinations on the tangent, then through the best of them exactly."""
    rows = judged_rows(task.tolerance)
    slopes = (
        np.array([resultant_and_moment(task.cuts[k].rate(float(plan.depths_mm[k]))) for k in made]) @ rows.T
    )
    judged = rows @ plan.predicted.components
    for k, steps, slope in zip(made, choices, slopes, strict=True):
        judged = (judged[..., None, :] + (steps - plan.depths_mm[k])[:, None] * slope).reshape(-1, len(rows))
    shares = np.hypot(judged[:, 0::2], judged[:, 1::2]).max(axis=1)
    best: Plan | None = None
    for place in np.argsort(shares, kind="stable")[:EXACT].tolist():
        depths = plan.depths_mm.copy()
        depths[list(made)] = _combination(choices, place)
        here = judged_plan(task.residual, task.tolerance, task.cuts, depths)
        if best is None or here.share < best.share:
            best = here
    assert best is not None
    return best


def _combination(choices: Sequence[Array], place: int) -> list[float]:
    """Return the steps of one combination by its place; those of the last choice run fastest."""
    steps_of = []
    for steps in reversed(choices):
        place, at = divmod(place, len(steps))
        steps_of.append(float(steps[at]))
    return steps_of[::-1]


EXACT = 12
"""Combinations of steps that are looked at on the exact curves."""
