"""Search for the lightest set of few cuts, where whole numbers decide and a linear bound is weak.

A chosen cut weighs at least as much as at its smallest depth. So k cuts weigh at least the bound of a small
linear programme for any k of all cuts, plus the reduced cost of each one. The sum of their effects at their
smallest depths misses the target by no more than the weight left to spend can make up. All sets within both
bounds are tried, up to a level of weight that rises until one of them serves. Many sets are joined from two
halves whose sums meet, found by a tree.

Without this search, by HiGHS alone, 27 unbalances of eight counterweights took six times as long, and up to
3.6 times the metal where a few holes suffice (in the mean 1.2 times).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.kind import Candidates
from autobalance.planning.cut_curves import CutCurves, least_of, length, parabola, slopes_of
from autobalance.planning.depths import independent_rows, resultant_and_moment
from autobalance.planning.ties import in_order
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

MOST_CUTS = 7
"""Cuts in a set at most: more are the integer programme's."""
LEVELS = (1.0025, 1.005, 1.01, 1.02, 1.03, *(1.04**n for n in range(1, 50)))
"""Weights up to which sets are searched, over the least that the bounds allow."""
PLACES = (0.0, 0.04, 0.1, 0.2, 0.4, 0.7, 1.0)
"""Points of the curves in the linear programme, 0 to 1; closer where they are light."""
MOST_SETS = 100_000
"""Sets or halves of sets held at once; where a level has more, the search ends."""
MOST_MEETINGS = 600_000
"""Pairs of halves that meet, likewise."""
TRIED_SETS = 8
"""Sets of each size and level that are tried on the exact curves, at most: the lightest."""
LEVEL_RISE = 1.25
"""Factor to which levels rise over the least weight of sets that are too many to try."""
MAX_CLIPS = 3
"""Times that the rest is spread again along the chords that have not come to an end."""


def lightest_set(
    residual: Unbalance,
    tolerance: Tolerance,
    candidates: Candidates,
    aim: float,
    serves: Callable[[Array], bool],
) -> tuple[Array | None, float]:
    """Return the depths of the lightest set of few cuts, and the least weight of sets that were not tried.

    Parameters
    ----------
    residual : Unbalance
        With no cut made, as judged.
    tolerance : Tolerance
    candidates : Candidates
        Cuts with a smallest depth; shared depths are not heeded.
    aim : float
        Share of the permissible value to reach.
    serves : callable
        Whether cuts reach the aim from depths near the given ones (n,), on the exact curves.

    Returns
    -------
    (n,) float or None
        Depths near their best; None if nothing was found.
    float
        Smallest weight of the sets that were not tried [g]. The result is the lightest of the tried sets to
        about 0.5 %, since the search leaves out some slack of the aim.
    """
    fewest = math.ceil(_count_at_least(residual, tolerance, candidates))
    if fewest > MOST_CUTS:
        return None, 0.0
    field = CutCurves.of(residual, tolerance, candidates, aim)
    least = float(field.weight[:, 0].min())
    lowest = max(_price(field, None).bound, least)
    possible = _possible(candidates)
    if possible > MOST_CUTS and lowest >= least * (MOST_CUTS + 1):
        return None, lowest
    sizes: dict[int, _Sets] = {}
    lost: set[int] = set()
    best, chosen, unseen = math.inf, None, math.inf
    for level in lowest * np.array(LEVELS):
        for count in range(max(fewest, 1), possible + 1):
            top = min(float(level), best)
            if count * least >= top:
                break
            if count > MOST_CUTS:
                unseen = min(unseen, max(count * least, lowest))
                break
            if count not in sizes:
                sizes[count] = _Sets(field, count)
            if count not in lost and not sizes[count].look(top):
                lost.add(count)
                unseen = min(unseen, sizes[count].seen)
            for weight, depths in sizes[count].lightest_set(top):
                if serves(depths):
                    best, chosen = weight, depths
                    break
        if best <= level or level > min(LEVEL_RISE * unseen, possible * field.weight.max()):
            break
    return chosen, unseen


def _count_at_least(residual: Unbalance, tolerance: Tolerance, candidates: Candidates) -> float:
    """Return the least number of cuts that reach the permissible values, not a whole number."""
    rows = independent_rows(tolerance)
    now = residual.components
    need = float(length(rows @ now)) - 0.5 * len(rows)
    deepest = np.array([rows @ resultant_and_moment(cut.effect(cut.max_depth_mm)) for cut in candidates.cuts])
    return need / max(float(length(deepest).max(initial=0.0)), 1e-12)


def _possible(candidates: Candidates) -> int:
    """Return the largest number of cuts that the rules of count allow."""
    free, total = set(range(len(candidates.cuts))), 0
    for rule in candidates.counts:
        total += min(rule.most, len(free.intersection(rule.members)))
        free.difference_update(rule.members)
    return total + len(free)


# --- bounds -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Price:
    """Smallest weight of sets of cuts: ``bound``, and ``reduced`` (n,) more for each member."""

    bound: float
    reduced: Array


def _price(field: CutCurves, count: int | None) -> _Price:
    """Return the bound for ``count`` cuts (None: any number), each in part or more than once."""
    from scipy.optimize import linprog

    width = len(field.wanted)
    columns = np.concatenate([parabola(field.effect, at) for at in PLACES]).T
    answer = linprog(
        np.concatenate([parabola(field.weight, at) for at in PLACES]),
        A_ub=np.vstack([columns, -columns]),
        b_ub=np.concatenate([field.wanted + 1.0, 1.0 - field.wanted]),
        A_eq=None if count is None else np.ones((1, columns.shape[1])),
        b_eq=None if count is None else [count],
        method="highs",
        options={"presolve": False},  # presolving takes as long as all the rest
    )
    if answer.x is None:
        return _Price(math.inf, np.zeros(len(field.weight)))
    dual: Array = answer.ineqlin.marginals[:width] - answer.ineqlin.marginals[width:]
    each = 0.0 if count is None else float(answer.eqlin.marginals[0])
    return _Price(float(answer.fun or 0.0), least_of(field.weight - dual @ field.effect - each))


# --- sets of so many cuts -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _CutSets:
    """Sets of cuts with the target on their chords: members, depths from 0 to 1 (m, k), and weights."""

    sets: Indices
    deep: Array
    weight: Array

    def part(self, of: Indices | slice) -> _CutSets:
        return _CutSets(self.sets[of], self.deep[of], self.weight[of])


class _Sets:
    """Sets of ``count`` cuts, searched up to a weight that rises."""

    def __init__(self, field: CutCurves, count: int) -> None:
        self.field = field
        self.count = count
        self.price = _price(field, count)
        self.order = in_order(self.price.reduced)
        self.least = float(field.weight[:, 0].min())
        self.seen = self.price.bound
        self.are_many = False
        self.meetings = MOST_MEETINGS
        self.found = _screened(field, np.zeros((0, count), dtype=np.int64))

    def look(self, top: float) -> bool:
        """Search the sets up to a new weight; return whether they were few enough."""
        if self.price.bound >= top:
            return True
        places = None if self.are_many else self._begun((self.count, 0), top - self.price.bound, top)
        if places is None:
            self.are_many = True  # and all the more at higher weights
            places = self._meet_in_the_middle(top)
        if places is None:
            return False
        field, sets = self.field, self.order[places]
        missed = length(field.wanted - field.at_least(sets)) - 0.5 * len(field.wanted)
        weight = np.maximum(
            field.weight[sets, 0].sum(axis=1) + np.maximum(missed, 0.0) / field.reach,
            self.price.bound + np.maximum(self.price.reduced[sets].sum(axis=1), 0.0),
        )
        new = _screened(field, sets[(weight < top) & (weight >= self.seen)])
        old, self.seen = self.found, top
        self.found = _CutSets(
            np.concatenate([old.sets, new.sets]),
            np.concatenate([old.deep, new.deep]),
            np.concatenate([old.weight, new.weight]),
        )
        return True

    def lightest_set(self, top: float) -> Iterator[tuple[float, Array]]:
        """Yield weights and depths of sets up to a weight, lightest first, and forget them all."""
        order = in_order(self.found.weight)
        most = int((self.found.weight <= top).sum())
        tried, self.found = self.found.part(order[: min(most, TRIED_SETS)]), self.found.part(order[most:])
        low, high = self.field.depth_mm[:, 0], self.field.depth_mm[:, 2]
        for weight, members, deep in zip(tried.weight.tolist(), tried.sets, tried.deep, strict=True):
            depths = np.zeros(len(low))
            depths[members] = low[members] + deep * (high - low)[members]
            yield weight, depths

    def _begun(self, sizes: tuple[int, int], spare: float, top: float) -> Indices | None:
        """Return indices into ``order`` (m, first size) of members, rising; None: too many.

        Their reduced costs leave room for as many more as the second size, none of them lower.
        """
        size, following = sizes
        reduced, light = self.price.reduced[self.order], self.field.weight[self.order, 0]
        sets, spent = np.zeros((1, 0), dtype=np.int64), np.zeros(1)
        for n in range(size):
            start = sets[:, -1] + 1 if n else np.zeros(1, dtype=np.int64)
            end = np.searchsorted(reduced * (size - n + following), spare - spent, side="right")
            each = np.maximum(end - start, 0)
            if each.sum() > MOST_SETS:
                return None
            last = np.repeat(start - np.cumsum(each) + each, each) + np.arange(each.sum())
            begun = np.repeat(sets, each, axis=0)
            apart = self.field.keeps_apart(self.order[begun], self.order[last[:, None]])
            sets = np.hstack([begun, last[:, None]])
            sets = sets[apart & (light[sets].sum(axis=1) <= top)]
            spent = reduced[sets].sum(axis=1)
        return sets

    def _meet_in_the_middle(self, top: float) -> Indices | None:
        """Return sets joined from their first and their last members in ``order``; None: too many."""
        from scipy.spatial import cKDTree

        field, first, last = self.field, self.count // 2, self.count - self.count // 2
        spare = top - self.price.bound
        few = self._begun((first, last), spare, top - last * self.least)
        spare -= first * float(self.price.reduced.min())
        many = self._begun((last, 0), spare, top - first * self.least)
        if few is None or many is None:
            return None
        light = [field.weight[self.order[half], 0].sum(axis=1).min(initial=math.inf) for half in (few, many)]
        if sum(light) >= top:
            return np.zeros((0, self.count), dtype=np.int64)
        radius = field.reach * (top - float(sum(light))) + 0.5 * len(field.wanted)
        tree = cKDTree(field.at_least(self.order[few]))
        other = cKDTree(field.wanted - field.at_least(self.order[many]))
        # counting takes half as long as meeting: not where the last level was far from too many
        if 2 * self.meetings > MOST_MEETINGS and tree.count_neighbors(other, radius) > MOST_MEETINGS:
            return None
        met = tree.sparse_distance_matrix(other, radius, output_type="ndarray")
        self.meetings = len(met)
        rising = met[few[:, -1].take(met["i"]) < many[:, 0].take(met["j"])]
        one, rest = few.take(rising["i"], axis=0), many.take(rising["j"], axis=0)
        places: Indices = np.hstack([one, rest])[field.keeps_apart(self.order[one], self.order[rest])]
        return places


# --- how deep -----------------------------------------------------------------------------------------------


def _screened(field: CutCurves, sets: Indices) -> _CutSets:
    """Return the sets (m, k) that can meet the target on their chords, with good depths.

    Depths follow the shortest way along the chords; those past an end stay there and the rest is spread
    again. Then, of more cuts than necessary, metal is saved as long as some still can be.
    """
    if sets.shape[1] < len(field.wanted):
        sets = sets[_can_meet(field, sets)]
    high = np.ones(sets.shape)
    for a, b in permutations(range(sets.shape[1]), 2):
        high[:, a] = np.minimum(high[:, a], field.deepest_beside[sets[:, a], sets[:, b]])
    bow, chord = field.bow[sets], field.chord[sets]
    high += bow * high * (1.0 - high)
    need = field.wanted - field.at_least(sets)
    along, free = np.zeros(sets.shape), np.ones(sets.shape, dtype=bool)
    for _ in range(MAX_CLIPS):
        left = need - _added(chord, np.where(free, 0.0, along))
        answer = _shortest(chord * free[:, :, None], left)
        along = np.where(free, np.clip(answer, 0.0, high), along)
        free &= (answer > 0.0) & (answer < high)
    left = need - _added(chord, along)
    good = np.hypot(left[:, 0::2], left[:, 1::2]).max(axis=1) <= _slack(field, sets)
    sets, along, high, bow = sets[good], along[good], high[good], bow[good]
    for _ in range(chord.shape[1] - chord.shape[2]):
        along = _lightened(field, sets, along, high)
    deep = _depth_share(bow, along)
    return _CutSets(sets, deep, parabola(field.weight[sets], deep).sum(axis=1))


def _slack(field: CutCurves, sets: Indices) -> Array:
    """Return the distance from the target at which judged vectors may end (m,), in units of the aim."""
    return np.asarray(1.0 + field.bend[sets].sum(axis=1))


def _can_meet(field: CutCurves, sets: Indices) -> NDArray[np.bool_]:
    """Return whether sets of fewer cuts than directions meet the target anywhere along their chords (m,)."""
    chord, need = field.chord[sets], field.wanted - field.at_least(sets)
    left = need - _added(chord, _shortest(chord, need))
    return np.asarray((left**2).sum(axis=1) <= 0.5 * left.shape[1] * _slack(field, sets) ** 2)


def _added(chord: Array, along: Array) -> Array:
    """Return the sums (m, d) of shares (m, k) of chords (m, k, d)."""
    return np.asarray((along[:, None] @ chord)[:, 0])


def _shortest(chord: Array, left: Array) -> Array:
    """Return the shares (m, k) of chords (m, k, d), of least squares, that make up a remainder (m, d)."""
    square = np.swapaxes(chord, 1, 2) @ chord
    ridge = 1e-9 * np.maximum(np.trace(square, axis1=1, axis2=2), 1e-30)  # some do not span all directions
    square += ridge[:, None, None] * np.eye(square.shape[1])
    return np.asarray((chord @ np.linalg.solve(square, left[:, :, None]))[:, :, 0])


def _depth_share(bow: Array, along: Array) -> Array:
    """Return the depths, from 0 smallest to 1 largest, at shares ``along`` the chords."""
    root = np.sqrt(np.maximum((1.0 + bow) ** 2 - 4.0 * bow * along, 0.0))
    return np.asarray(2.0 * along / (1.0 + bow + root))


def _lightened(field: CutCurves, sets: Indices, along: Array, high: Array) -> Array:
    """Return ``along`` moved where weight falls steepest at an equal sum, to an end or the least weight."""
    chord = field.chord[sets] * ((along > 0.0) & (along < high))[:, :, None]
    bow, deep = field.bow[sets], _depth_share(field.bow[sets], along)
    slopes = slopes_of(field.weight[sets])
    pace = np.maximum(1.0 + bow * (1.0 - 2.0 * deep), 1e-6)
    slope = np.where(chord.any(axis=2), parabola(slopes, deep) / pace, 0.0)
    steeper = np.maximum((slopes[..., 2] - slopes[..., 0] + 2.0 * bow * slope) / pace**2, 0.0)
    way = _shortest(chord, _added(chord, slope)) - slope
    way[np.abs(way).max(axis=1) < 1e-5 * np.abs(slope).max(axis=1)] = 0.0  # rounding, no way at all
    to_end = np.where(way > 0.0, high - along, along) / np.maximum(np.abs(way), 1e-12)
    to_least = -(slope * way).sum(axis=1) / np.maximum((steeper * way**2).sum(axis=1), 1e-12)
    step = np.maximum(np.minimum(to_end.min(axis=1), to_least), 0.0)
    return np.asarray(np.clip(along + step[:, None] * way, 0.0, high))
