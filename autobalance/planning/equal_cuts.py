"""Equal cuts: a search for common depths of several."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property, lru_cache
from itertools import combinations, islice, product

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.contract import setting_of
from autobalance.planning.cut_curves import Task, bounds_of
from autobalance.planning.depths import Plan, judged_plan, judged_rows, resultant_and_moment
from autobalance.planning.ties import in_order, is_less, key
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Common depths of several cuts: found on the exact curves, rounded to the machine's steps.


NEWTON_STEPS = 6
STEPS_ASIDE = 2
"""Steps of the machine to each side of the exact depths that are tried, with few groups."""
FEW_GROUPS = 4


@dataclass(frozen=True)
class Groups:
    """Groups of a plan's cuts, each of one setting and one depth."""

    members: tuple[tuple[int, ...], ...]
    depths_mm: tuple[float, ...]
    settings: tuple[str, ...]

    @classmethod
    def apart(cls, task: Task, depths_mm: Array) -> Groups:
        """Return the groups of a plan's cuts: of one setting and, to a nanometre, one depth."""
        by_depth: dict[tuple[str, float], list[int]] = {}
        for k in np.flatnonzero(depths_mm > 0.0).tolist():
            by_depth.setdefault((setting_of(task.cuts[k]), round(float(depths_mm[k]), 6)), []).append(k)
        return cls(
            tuple(tuple(group) for group in by_depth.values()),
            tuple(depth for _, depth in by_depth),
            tuple(setting for setting, _ in by_depth),
        )

    def at(self, depths_mm: Array) -> Groups:
        """Return the same groups at a plan's depths."""
        return Groups(
            self.members, tuple(float(depths_mm[group[0]]) for group in self.members), self.settings
        )

    def joinings(self) -> Iterator[Groups]:
        """Yield the groups with all of one setting joined, then with two joined, the nearest depths first."""
        for setting in dict.fromkeys(self.settings):
            if self.settings.count(setting) > 2:
                yield self._joined([n for n, each in enumerate(self.settings) if each == setting])
        count = len(self.members)
        pairs = [
            (i, j) for i in range(count) for j in range(i + 1, count) if self.settings[i] == self.settings[j]
        ]
        pairs.sort(key=lambda pair: round(abs(self.depths_mm[pair[0]] - self.depths_mm[pair[1]]), 9))
        for pair in pairs:
            yield self._joined(pair)

    def _joined(self, places: Sequence[int]) -> Groups:
        kept = [n for n in range(len(self.members)) if n not in places]
        together = tuple(sorted(k for n in places for k in self.members[n]))
        weight = sum(len(self.members[n]) for n in places)
        depth = sum(len(self.members[n]) * self.depths_mm[n] for n in places) / weight
        return Groups(
            (*(self.members[n] for n in kept), together),
            (*(self.depths_mm[n] for n in kept), depth),
            (*(self.settings[n] for n in kept), self.settings[places[0]]),
        )


def common_depths(task: Task, groups: Groups, enough: float) -> Plan | None:
    """Return the plan of groups at depths of smallest residual, on machine steps; None if above ``enough``.

    Gauss-Newton steps on the judged vectors; then the nearest machine steps are tried together.
    """
    cut_now = sorted(k for group in groups.members for k in group)
    low, high = bounds_of(task, cut_now)
    place = {k: n for n, k in enumerate(cut_now)}
    least = np.array([max(low[place[k]] for k in group) for group in groups.members])
    most = np.array([min(high[place[k]] for k in group) for group in groups.members])
    if (least > most).any() or not _keeps_shared(task, groups, least):
        return None
    rows = judged_rows(task.tolerance)
    depths = np.clip(np.array(groups.depths_mm), least, most)
    best = _plan(task, groups, depths)
    for _ in range(NEWTON_STEPS):
        slopes = np.array(
            [_slope(task, group, d) for group, d in zip(groups.members, depths.tolist(), strict=True)]
        )
        step, *_ = np.linalg.lstsq(rows @ slopes.T, -rows @ _plan(task, groups, depths).predicted.components)
        moved = np.clip(depths + step, least, most)
        here = _plan(task, groups, moved)
        best = here if is_less(here.share, best.share) else best
        if np.abs(moved - depths).max() <= 1e-6:
            break
        depths = moved
    best = _on_steps(task, groups, best, (least, most))
    return (
        best
        if best.share <= enough and _keeps_shared(task, groups, groups.at(best.depths_mm).depths_mm)
        else None
    )


def _keeps_shared(task: Task, groups: Groups, depths: Sequence[float] | Array) -> bool:
    depth = {k: float(d) for group, d in zip(groups.members, depths, strict=True) for k in group}
    return all(
        depth.get(pair.first, 0.0) + depth.get(pair.second, 0.0) <= pair.most_mm + 1e-9
        for pair in task.candidates.shared
        if pair.first in depth and pair.second in depth
    )


def _slope(task: Task, group: Sequence[int], depth_mm: float) -> Array:
    return np.asarray(sum(resultant_and_moment(task.cuts[k].rate(depth_mm)) for k in group))


def _plan(task: Task, groups: Groups, depths: Array) -> Plan:
    every = np.zeros(len(task.cuts))
    for group, depth in zip(groups.members, depths.tolist(), strict=True):
        every[list(group)] = depth
    return judged_plan(task.residual, task.tolerance, task.cuts, every)


def _on_steps(task: Task, groups: Groups, plan: Plan, bounds: tuple[Array, Array]) -> Plan:
    """Return the plan of smallest residual with depths on machine steps near those of ``plan``."""
    steps = [max(task.cuts[k].depth_step_mm for k in group) for group in groups.members]
    if not any(steps):
        return plan
    aside = STEPS_ASIDE if len(steps) <= FEW_GROUPS else 0
    choices = []
    for group, step, low, high in zip(
        groups.members, steps, *(ends.tolist() for ends in bounds), strict=True
    ):
        depth = float(plan.depths_mm[group[0]])
        near = math.floor(depth / step + 1e-9) if step else 0
        every = [n * step for n in range(near - aside, near + 2 + aside)] if step else [depth]
        choices.append([d for d in every if low - 1e-9 <= d <= high + 1e-9] or [depth])
    if math.prod(map(len, choices)) > (2 + 2 * STEPS_ASIDE) ** FEW_GROUPS:
        choices = [
            [min(each, key=lambda d, g=group: abs(d - float(plan.depths_mm[g[0]])))]  # type: ignore[misc]
            for each, group in zip(choices, groups.members, strict=True)
        ]
    tried = (_plan(task, groups, np.array(depths)) for depths in _nearest(task, groups, plan, choices))
    return min(tried, key=lambda here: key(here.share))


TRIED_GROUPS = 12


def _nearest(
    task: Task, groups: Groups, plan: Plan, choices: Sequence[Sequence[float]]
) -> list[tuple[float, ...]]:
    """Return the combinations of depths of smallest residual on the tangent."""
    rows = judged_rows(task.tolerance)
    now = np.array([float(plan.depths_mm[group[0]]) for group in groups.members])
    slopes = np.array([_slope(task, group, d) for group, d in zip(groups.members, now.tolist(), strict=True)])
    every = list(product(*choices))
    judged = rows @ plan.predicted.components + (np.array(every) - now) @ slopes @ rows.T
    shares = np.hypot(judged[:, 0::2], judged[:, 1::2]).max(axis=1)
    return [every[k] for k in in_order(shares)[:TRIED_GROUPS].tolist()]


# Direct search for small sets of cuts of one tool and one common depth that correct an unbalance.
#
# At each of some depths the effects of all places are known. Sets of k of them whose sum meets the target
# are joined from two halves whose sums meet, found by a tree (as in `enumeration`). Between two depths a sum
# moves mostly along the target: so it may miss more that way. On two webs each may have its own depth: each
# then makes up its share of the unbalance, as two correction planes do.


LEVELS = 25
"""Number of depths at which sets are searched."""
MOST_ALIKE = 6
"""Cuts in a set, at most."""
MOST_HALVES = 5_000
MOST_MET = 300_000
MISS_RATIO = 1.3
"""Factor on the distance by which halves may miss each other, since slopes differ a little from effects."""
TRIED_SETS = 6
"""Sets kept of each depth, at most: those of smallest residual."""
MAX_SETTLED_SETS = 3
"""Sets settled on the exact curves, at most: the shallowest."""
MAX_PAIRED_SETS = 3
"""Sets of one web that are paired with another's, at most: the shallowest."""
PAIRS_OF_WEBS = 6

_Set = tuple[Indices, float]
"""Members of a set, and their depth [mm]."""


@dataclass(frozen=True, eq=False)
class _CutSeries:
    """Cuts of one setting at some depths: ``effects`` (levels, n, d) and their ``slopes`` per millimetre."""

    members: Indices
    depths_mm: Array
    effects: Array
    slopes: Array
    rule_of: list[tuple[NDArray[np.bool_], int]]
    most_mm: Array

    @classmethod
    def of(cls, task: Task, members: Sequence[int], rows: Array) -> _CutSeries | None:
        """Return cuts at common depths; None where each has one depth only."""
        least = np.array([task.cuts[k].least_depth_mm for k in members])
        most = np.array([task.cuts[k].max_depth_mm for k in members])
        if (most - least).max() < 1e-6:
            return None
        levels = np.linspace(float(least.min()), float(most.max()), LEVELS)
        three = [[task.cuts[k].effect(d) for d in _three(task, k)] for k in members]
        curves = np.array([[rows @ resultant_and_moment(each) for each in group] for group in three])
        span = np.maximum(most - least, 1e-9)
        at = (levels[:, None] - least) / span
        first, middle, last = (curves[:, n] for n in range(3))
        bend = 2.0 * (first - 2.0 * middle + last)
        effects = first + at[..., None] * (last - first - bend) + (at**2)[..., None] * bend
        slopes = ((last - first - bend) + 2.0 * at[..., None] * bend) / span[:, None]
        possible = (at >= -1e-9) & (at <= 1.0 + 1e-9)
        effects[~possible] = np.nan
        whole = np.full((len(task.cuts), len(task.cuts)), np.inf)
        for pair in task.candidates.apart:
            whole[pair.first, pair.second] = whole[pair.second, pair.first] = min(
                pair.most_mm, whole[pair.first, pair.second]
            )
        place = np.array(members)
        rules = []
        for rule in task.candidates.counts:
            inside = np.isin(place, list(rule.members))
            if inside.any():
                rules.append((inside, rule.most))
        return cls(place, levels, effects, slopes, rules, whole[np.ix_(place, place)])

    @property
    def step_mm(self) -> float:
        """Distance between two depths."""
        return float(self.depths_mm[1] - self.depths_mm[0])

    @cached_property
    def _levels(self) -> list[tuple[Indices, Array, float]]:
        """The cuts that there are at each depth, their effects, and the steepest slope among them."""
        some = [np.flatnonzero(~np.isnan(effects[:, 0])) for effects in self.effects]
        return [
            (there, effects[there], float(np.linalg.norm(slopes[there], axis=1).max(initial=0.0)))
            for there, effects, slopes in zip(some, self.effects, self.slopes, strict=True)
        ]

    def sets(self, target: Array, count: int) -> Iterator[_Set]:
        """Yield sets of ``count`` cuts that meet the target within 1, the shallowest first."""
        waiting: list[_Set] = []
        for level, depth in enumerate(self.depths_mm.tolist()):
            waiting.sort(key=_depth_mm)
            settled = sum(each[1] <= depth - 0.5 * self.step_mm for each in waiting)
            yield from waiting[:settled]
            waiting = waiting[settled:] + self._sets_at(level, depth, target, count)
        yield from sorted(waiting, key=_depth_mm)

    def _sets_at(self, level: int, depth_mm: float, target: Array, count: int) -> list[_Set]:
        """Return the sets of smallest residual at one depth, each moved to its best depth nearby."""
        met = self._meeting(level, target, count)
        if not len(met):
            return []
        met = met[self._keeps_rules(met, depth_mm)]
        if not len(met):
            return []
        left = self.effects[level][met].sum(axis=1) - target
        way = self.slopes[level][met].sum(axis=1)
        size = np.maximum((way**2).sum(axis=1), 1e-30)
        along = np.clip(-(left * way).sum(axis=1) / size, -0.5 * self.step_mm, 0.5 * self.step_mm)
        left = left + along[:, None] * way
        share = np.hypot(left[:, 0::2], left[:, 1::2]).max(axis=1)
        best = [row for row in in_order(share)[:TRIED_SETS].tolist() if share[row] <= 1.0]
        return [(self.members[met[row]], depth_mm + float(along[row])) for row in best]

    def _meeting(self, level: int, target: Array, count: int) -> Indices:
        """Return sets (m, count) of indices that come near the target at a depth; empty if too many."""
        from scipy.spatial import cKDTree

        effects = self.effects[level]
        there, acting, steepest = self._levels[level]
        first, last = count // 2, count - count // 2
        nothing = np.zeros((0, count), dtype=np.int64)
        if len(there) < count or math.comb(len(there), last) > MOST_HALVES:
            return nothing
        slack = 1.0 + 0.5 * self.step_mm * count * steepest
        radius = MISS_RATIO * math.sqrt(0.5 * len(target))
        distance = float(np.linalg.norm(target))
        towards = target / max(distance, 1e-12)
        reach = np.sort(acting @ towards)
        if abs(distance - np.clip(distance, reach[:count].sum(), reach[-count:].sum())) > slack * radius:
            return nothing  # not even the places that act along it most, or least, come near it
        squeezed = np.eye(len(target)) - (1.0 - 1.0 / slack) * np.outer(towards, towards)
        effects, goal = effects @ squeezed, target @ squeezed
        many = there[_choices(len(there), last)]
        if not first:
            near = np.linalg.norm(effects[many[:, 0]] - goal, axis=1) <= radius
            return np.asarray(many[near])
        few = there[_choices(len(there), first)]
        one, rest = effects[few].sum(axis=1), goal - effects[many].sum(axis=1)
        inside = _in_box_of(one, rest, radius)
        few, one = few[inside], one[inside]
        if not len(one):
            return nothing
        inside = _in_box_of(rest, one, radius)
        many, rest = many[inside], rest[inside]
        tree, other = cKDTree(one), cKDTree(rest)
        if tree.count_neighbors(other, radius) > MOST_MET:
            return nothing
        met = tree.sparse_distance_matrix(other, radius, output_type="ndarray")
        head, tail = met["i"], met["j"]
        rising = few[:, -1].take(head) < many[:, 0].take(tail)  # most do not: they need no sorting
        head, tail = head[rising], tail[rising]
        order = np.lexsort((tail, head))  # as they are numbered, not as the tree holds them
        return np.hstack([few.take(head[order], axis=0), many.take(tail[order], axis=0)])

    def _keeps_rules(self, sets: Indices, depth_mm: float) -> NDArray[np.bool_]:
        good = np.ones(len(sets), dtype=bool)
        for a, b in combinations(range(sets.shape[1]), 2):
            good &= self.most_mm[sets[:, a], sets[:, b]] >= depth_mm + 0.5 * self.step_mm
        for inside, most in self.rule_of:
            good &= inside[sets].sum(axis=1) <= most
        return good


def _in_box_of(points: Array, others: Array, margin: float) -> NDArray[np.bool_]:
    """Return whether points (m, d) lie in the box around others, widened by the margin (m,)."""
    low, high = others.min(axis=0) - margin, others.max(axis=0) + margin
    within: NDArray[np.bool_] = ((points >= low) & (points <= high)).all(axis=1)
    return within


def _depth_mm(cut_set: _Set) -> float:
    return round(cut_set[1], 9)


@lru_cache(maxsize=64)
def _choices(count: int, size: int) -> Indices:
    """Return every choice of ``size`` numbers below ``count``, rising (m, size)."""
    return np.array(list(combinations(range(count), size)), dtype=np.int64)


def _three(task: Task, k: int) -> list[float]:
    return list(map(float, np.linspace(task.cuts[k].least_depth_mm, task.cuts[k].max_depth_mm, 3)))


def _by_setting(task: Task, among: Sequence[int]) -> dict[str, list[int]]:
    by_setting: dict[str, list[int]] = {}
    for k in among:
        by_setting.setdefault(setting_of(task.cuts[k]), []).append(k)
    return by_setting


def equal_cuts_everywhere(task: Task, enough: float, most_cuts: int = MOST_ALIKE) -> Iterator[Plan]:
    """Yield plans of the fewest cuts of one setting and one depth, for each setting."""
    rows = judged_rows(task.tolerance) / enough
    target = -rows @ task.residual.components
    for members in _by_setting(task, range(len(task.cuts))).values():
        alike = _CutSeries.of(task, members, rows)
        if alike is None:
            continue
        for count in range(1, min(most_cuts, len(members)) + 1):
            good = _settled(task, alike.sets(target, count), enough)
            if good:
                yield from good
                break


def _settled(task: Task, sets: Iterable[_Set], enough: float) -> list[Plan]:
    """Return plans of the first sets, the shallowest, at their exact common depths, on machine steps."""
    plans: list[Plan] = []
    for members, depth in sets:
        setting = setting_of(task.cuts[int(members[0])])
        plan = common_depths(task, Groups((tuple(members.tolist()),), (depth,), (setting,)), enough)
        plans += [] if plan is None else [plan]
        if len(plans) == MAX_SETTLED_SETS:
            break
    return plans


def equal_cuts_on_each_web(task: Task, enough: float) -> Iterator[Plan]:
    """Yield plans in which each of two webs has cuts of one setting and one depth."""
    webs: dict[int, list[int]] = {}
    for k, cut in enumerate(task.cuts):
        web = getattr(cut, "web", None)
        if isinstance(web, int):
            webs.setdefault(web, []).append(k)
    if task.tolerance.judge == "static" or len(webs) < 2:
        return
    pairs = sorted(combinations(sorted(webs), 2), key=lambda pair: pair[0] - pair[1])[:PAIRS_OF_WEBS]
    for one, other in pairs:
        yield from _on_two_webs(task, (webs[one], webs[other]), enough)


def _on_two_webs(task: Task, webs: tuple[list[int], list[int]], enough: float) -> Iterator[Plan]:
    """Yield plans of the fewest cuts of two webs."""
    z = [_middle_mm(task, members) for members in webs]
    if abs(z[1] - z[0]) < 1e-6:
        return
    halves: list[list[list[_Set]]] = []
    for members, vector, share in zip(
        webs, task.residual.in_planes(*z), _shares(task, z, enough), strict=True
    ):
        rows = np.hstack([np.eye(2), np.zeros((2, 2))]) / share
        of_web = []
        for group in _by_setting(task, members).values():
            alike = _CutSeries.of(task, group, rows)
            for count in range(1, MOST_ALIKE + 1):
                sets = [] if alike is None else [*islice(alike.sets(-vector / share, count), MAX_PAIRED_SETS)]
                if sets:
                    of_web.append(sets)
                    break
        if not of_web:
            return
        halves.append(of_web)
    for first, second in product(*halves):
        good = []
        for (a, depth_a), (b, depth_b) in product(first, second):
            settings = tuple(setting_of(task.cuts[int(part[0])]) for part in (a, b))
            groups = Groups((tuple(a.tolist()), tuple(b.tolist())), (depth_a, depth_b), settings)
            plan = common_depths(task, groups, enough)
            good += [] if plan is None else [plan]
        yield from good


def _middle_mm(task: Task, members: Sequence[int]) -> float:
    """Return the mean position along the axis of the metal of a web's cuts."""
    change = [task.cuts[k].effect(task.cuts[k].max_depth_mm) for k in members]
    return float(np.mean([each.centre_mm[2] for each in change]))


def _shares(task: Task, z_mm: Sequence[float], enough: float) -> list[float]:
    """Return the permitted miss of each of two webs [g·mm], with every judged vector good enough."""
    rows = judged_rows(task.tolerance) / enough
    shares = []
    for z in z_mm:
        effect = rows @ np.array([1.0, 0.0, z, 0.0])
        shares.append(0.5 / float(np.hypot(effect[0::2], effect[1::2]).max()))
    return shares
