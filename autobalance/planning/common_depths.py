"""Common depths of several cuts: found on the exact curves, rounded to the machine's steps."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from autobalance.correction.contract import setting_of
from autobalance.planning.depth_steps import bounds_of
from autobalance.planning.depths import Plan, judged_plan, judged_rows, resultant_and_moment
from autobalance.planning.task import Task
from autobalance.planning.ties import in_order, is_less, key
from autobalance.types import Array

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
