"""The mixed-integer linear programme of whole cuts: its columns, rows and costs; it solves nothing.

Columns: a weight λ for each breakpoint of each cut, a switch for each cut and each limited group, the excess
of residual, the change of inertia, and the residual itself. Effects are piecewise linear between breakpoints.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np

from autobalance.correction.contract import Apart, Cut, Variety
from autobalance.planning.cut_curves import Task
from autobalance.planning.depths import independent_rows, judged_rows, resultant_and_moment
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.types import Array

POINTS = 3
"""Depths of each cut at which the programme has its exact effect."""
SIDES = 6
"""Sides of the polygon that stands for the circle of a judged vector while choosing."""
EXCESS_WEIGHT = 100.0
"""Metal that one aim of residual is worth, in units of a usual correction."""


def breakpoints(task: Task, count: int = POINTS) -> list[Array]:
    """Return each cut's breakpoints: even over its depths, and at its limits beside neighbours.

    An even point makes way for a limit nearer than half a space.
    """
    ends: list[set[float]] = [set() for _ in task.cuts]
    for pair in task.candidates.apart:
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


def add_points(tables: list[Array], *answers: Array) -> bool:
    """Add the depths of some answers as breakpoints; return whether any was new."""
    added = False
    for depths in answers:
        for k in np.flatnonzero(depths).tolist():
            if np.abs(tables[k] - depths[k]).min() > 1e-3:
                tables[k] = np.sort(np.append(tables[k], depths[k]))
                added = True
    return added


def effects_at(task: Task, tables: Sequence[Array]) -> list[list[Moments]]:
    """Return each cut's effects at its breakpoints."""
    return [[cut.effect(float(d)) for d in points] for cut, points in zip(task.cuts, tables, strict=True)]


class MilpModel:
    """Matrix, bounds and costs of the programme of whole cuts."""

    def __init__(
        self,
        task: Task,
        tables: Sequence[Array],
        effects: Sequence[Sequence[Moments]],
        least_count: int,
        sides: int = SIDES,
    ) -> None:
        count = len(tables)
        sizes = [len(points) for points in tables]
        self.first = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
        self.switch = int(self.first[-1])
        self.kinds = self.switch + count
        varieties = [rule for rule in task.candidates.varieties if sum(map(bool, rule.groups)) > rule.most]
        self.excess = self.kinds + sum(len(rule.groups) for rule in varieties)
        self.change = self.excess + 1
        self.left = self.change + 1
        self.tables = tables
        self._rows: list[Any] = []
        self._columns: list[Any] = []
        self._values: list[Any] = []
        self._low: list[float] = []
        self._high: list[float] = []
        self._weights_follow_switches(task.cuts)
        self._residual_rows(task, effects, sides)
        self._apart_rows(task)
        for pair in task.candidates.shared:
            self._add_depths([(pair.first, 1.0), (pair.second, 1.0)], -math.inf, pair.most_mm)
        for rule in task.candidates.counts:
            self._add(
                [self.switch + k for k in rule.members], [1.0] * len(rule.members), -math.inf, rule.most
            )
        self._variety_rows(varieties)
        if least_count:
            self._add(range(self.switch, self.kinds), [1.0] * count, least_count, math.inf)
        self.cost = self._cost_row(task, effects)
        free = len(independent_rows(task.tolerance))
        width = self.left + free
        self.upper = np.concatenate([np.ones(self.excess), np.full(2 + free, np.inf)])
        self.lower = np.concatenate([np.zeros(self.left), np.full(free, -np.inf)])
        self.integrality = np.zeros(width, dtype=np.int64)
        self.integrality[self.switch : self.excess] = 1
        self.lower_rows, self.upper_rows = np.array(self._low), np.array(self._high)

    @cached_property
    def matrix(self) -> Any:
        """The rows, as a sparse array (CSR)."""
        from scipy.sparse import coo_array

        places = np.stack([np.concatenate(self._rows), np.concatenate(self._columns)])
        rows, columns = places.astype(np.int32)  # HiGHS in scipy 1.13 takes no others
        return coo_array((np.concatenate(self._values), (rows, columns)), self.shape).tocsr()

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return len(self._low), len(self.upper)

    def without_residual(self) -> tuple[Array, Array]:
        """Return rows (m, n) and bounds (m,), row · x ≤ bound, with the residual's columns eliminated."""
        every = np.zeros(self.shape)
        places = np.concatenate(self._rows), np.concatenate(self._columns)
        np.add.at(every, places, np.concatenate(self._values))
        own = every[:, self.left :]
        telling = (own != 0.0).any(axis=1) & (self.lower_rows == self.upper_rows)  # effects · x − own = −now
        rest = every[:, : self.left] + own @ every[telling, : self.left]
        shift = own @ self.upper_rows[telling]
        upper, lower = (np.isfinite(ends) & ~telling for ends in (self.upper_rows, self.lower_rows))
        rows = np.concatenate([rest[upper], -rest[lower]])
        most = np.concatenate([self.upper_rows[upper] + shift[upper], -self.lower_rows[lower] - shift[lower]])
        return rows, most

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

    def _residual_rows(self, task: Task, effects: Sequence[Sequence[Moments]], sides: int) -> None:
        """Add separate columns for the residual, so that few rows name every cut; keep it in polygons."""
        rows = judged_rows(task.tolerance)
        own = independent_rows(task.tolerance)
        size = len(own)
        table = np.array([resultant_and_moment(effect) for group in effects for effect in group]).T
        effect = own @ table / task.aim
        now = own @ task.residual.components / task.aim
        for k in range(size):
            columns = np.append(np.arange(self.switch), self.left + k)
            self._add(columns, np.append(effect[k], -1.0), -now[k], -now[k])
        angle = (np.arange(sides) + 0.5) * (2.0 * math.pi / sides)
        inner = math.cos(math.pi / sides)
        judged = rows @ np.linalg.pinv(own)  # from the residual's columns to every judged vector
        for k in range(0, len(rows), 2):
            for a in angle:
                u = np.array([math.cos(a), math.sin(a)])
                values = np.append(u @ judged[k : k + 2], -inner)
                self._add([*range(self.left, self.left + size), self.excess], values, -math.inf, 0.5 * inner)

    def _variety_rows(self, varieties: Sequence[Variety]) -> None:
        """Add a switch for each group, on where one of its cuts is made, and limit the number that are on."""
        here = self.kinds
        for rule in varieties:
            for column, group in enumerate(rule.groups, here):
                for k in group:
                    self._add([self.switch + k, column], [1.0, -1.0], -math.inf, 0.0)
            columns = range(here, here + len(rule.groups))
            self._add(columns, [1.0] * len(rule.groups), -math.inf, rule.most)
            here += len(rule.groups)

    def _apart_rows(self, task: Task) -> None:
        never = [pair for pair in task.candidates.apart if is_never(pair, task.cuts)]
        for clique in cliques_of(never, len(task.cuts)):
            self._add([self.switch + k for k in clique], [1.0] * len(clique), -math.inf, 1.0)
        site = sites_of(never, len(task.cuts))
        self.places = max(site) + 1
        most: dict[tuple[int, int], dict[tuple[int, int], float]] = {}
        for pair in task.candidates.apart:
            for k, other in ((pair.first, pair.second), (pair.second, pair.first)):
                most.setdefault((site[k], site[other]), {})[k, other] = pair.most_mm
        for (here, there), pairs in most.items():
            if here != there:
                self._beside(pairs)

    def _beside(self, most_mm: Mapping[tuple[int, int], float]) -> None:
        """Allow no weight at one site deeper than the cut at another site permits.

        Of a site's cuts one is made at most. So where any of some others is made, all weight lies above the
        depth that the most lenient of them allows; one row for each that may be it.
        """
        here, there = (sorted(set(cuts)) for cuts in zip(*most_mm, strict=True))
        most = np.array([[most_mm.get((k, other), math.inf) for k in here] for other in there])
        allowed = most + 1e-9
        no_deeper = np.asarray((most[None] <= allowed[:, None]).all(axis=2))
        from_column = [
            (self.first[k] + np.searchsorted(self.tables[k], limits, "right")).tolist()
            for k, limits in zip(here, allowed.T, strict=True)
        ]
        ends = self.first[1:][here].tolist()
        rows: set[tuple[tuple[int, ...], tuple[int, ...]]] = set()
        for lenient, begins in enumerate(zip(*from_column, strict=True)):
            deeper = tuple(chain.from_iterable(map(range, begins, ends)))
            others = [there[place] for place in np.flatnonzero(no_deeper[lenient]).tolist()]
            if deeper:
                rows.add((deeper, tuple(others)))
        for deeper_columns, beside in sorted(rows):
            columns = [*deeper_columns, *(self.switch + other for other in beside)]
            self._add(columns, [1.0] * len(columns), -math.inf, 1.0)

    def _cost_row(self, task: Task, effects: Sequence[Sequence[Moments]]) -> Array:
        """Return the costs in units of a usual correction, so that the excess outweighs them."""
        cost = np.zeros(self.left + len(independent_rows(task.tolerance)))
        masses = np.array([abs(effect.mass_g) for group in effects for effect in group])
        cost[: self.switch] = masses / task.usual_g
        inertia = np.array([effect.polar_inertia_g_mm2 for group in effects for effect in group])
        usual_inertia = task.usual_g * task.usual_radius_mm**2
        if task.prefer == "fewest_holes":
            cost[: self.switch] *= 0.01
            cost[self.switch : self.kinds] = 1.0
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


def is_never(pair: Apart, cuts: Sequence[Cut]) -> bool:
    """Return whether only one of two cuts can be made, since neither is so shallow."""
    return pair.most_mm < max(cuts[pair.first].least_depth_mm, cuts[pair.second].least_depth_mm)


def sites_of(never: Sequence[Apart], count: int) -> list[int]:
    """Return the site of each cut; any two of one site exclude each other, as the drills for one place do."""
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


def cliques_of(pairs: Sequence[Apart], count: int) -> Iterator[list[int]]:
    """Yield sets of cuts in which any two exclude each other, until every pair is in one."""
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
