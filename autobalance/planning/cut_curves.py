"""Cuts as parabolas of judged vectors through three depths, and their sums over many sets."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from autobalance.correction.kind import Candidates
from autobalance.planning.depths import independent_rows, resultant_and_moment
from autobalance.rigid_rotor.tolerance import Tolerance
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.types import Array, Indices

MOST_LATE = 0.99
"""Largest lag of a curve: one that would run backwards at first is taken to start slowly."""


@dataclass(frozen=True, eq=False)
class CutCurves:
    """All cuts as curves of judged vectors, known at their least, middle and largest depths.

    Attributes
    ----------
    candidates : Candidates
    depth_mm : (n, 3) float
    effect : (n, d, 3) float
        d = 2 or 4: the judged vectors side by side, in units of the aim.
    weight : (n, 3) float
        Metal [g].
    wanted : (d,) float
        Target of the sum of effects.
    """

    candidates: Candidates
    depth_mm: Array
    effect: Array
    weight: Array
    wanted: Array

    @classmethod
    def of(cls, residual: Unbalance, tolerance: Tolerance, candidates: Candidates, aim: float) -> CutCurves:
        rows = independent_rows(tolerance) / aim
        depth = np.array([np.linspace(cut.least_depth_mm, cut.max_depth_mm, 3) for cut in candidates.cuts])
        changes = [
            [cut.effect(float(d)) for d in three] for cut, three in zip(candidates.cuts, depth, strict=True)
        ]
        effect = np.array([[resultant_and_moment(change) for change in three] for three in changes]) @ rows.T
        weight = np.array([[abs(change.mass_g) for change in three] for three in changes])
        now = residual.components
        return cls(candidates, depth, np.moveaxis(effect, 2, 1), weight, -rows @ now)

    @cached_property
    def least(self) -> Array:
        """The effects at the least depths (n, d)."""
        return np.ascontiguousarray(self.effect[:, :, 0])

    def at_least(self, sets: Indices) -> Array:
        """Return the sums (m, d) of the effects of sets of cuts (m, k) at their smallest depths."""
        total = np.zeros((len(sets), len(self.wanted)))
        for members in sets.T:
            total += self.least.take(members, axis=0)
        return total

    @cached_property
    def chord(self) -> Array:
        """Change of each effect from the least to the largest depth (n, d)."""
        return self.effect[:, :, 2] - self.effect[:, :, 0]

    @cached_property
    def bow(self) -> Array:
        """Progress of each curve along its chord at its middle depth beyond one half, times four (n,).

        Zero for a cut of one depth only, which has no chord.
        """
        middle = ((self.effect[:, :, 1] - self.effect[:, :, 0]) * self.chord).sum(axis=1)
        square = (self.chord**2).sum(axis=1)
        bow = np.where(square > 1e-30, 4.0 * middle / np.maximum(square, 1e-30) - 2.0, 0.0)
        return np.asarray(np.maximum(bow, -MOST_LATE))

    @cached_property
    def bend(self) -> Array:
        """Distance of each curve sideways from its chord at its middle depth (n,)."""
        middle = self.effect[:, :, 1] - self.effect[:, :, 0]
        return length(middle - (0.5 + 0.25 * self.bow)[:, None] * self.chord)

    @cached_property
    def reach(self) -> float:
        """Largest growth of the length of an effect per gram of metal."""
        gain, spent = length(np.moveaxis(slopes_of(self.effect), 2, 1)), slopes_of(self.weight)
        return max(float((gain / np.maximum(spent, 1e-12)).max(initial=0.0, where=spent > 1e-12)), 1e-12)

    @cached_property
    def deepest_beside(self) -> Array:
        """Largest depth, from 0 smallest to 1 largest, of the first of two cuts beside the second (n, n).

        Below 0: the two exclude each other.
        """
        most = np.full((len(self.weight), len(self.weight)), np.inf)
        least, span = self.depth_mm[:, 0], np.maximum(self.depth_mm[:, 2] - self.depth_mm[:, 0], 1e-9)
        for pair in self.candidates.apart:
            for i, j in ((pair.first, pair.second), (pair.second, pair.first)):
                never = pair.most_mm < max(least[i], least[j])
                most[i, j] = min(most[i, j], -1.0 if never else (pair.most_mm - least[i]) / span[i])
        return most

    @cached_property
    def never_both(self) -> NDArray[np.bool_]:
        """Pairs of cuts that exclude each other (n, n)."""
        return self.deepest_beside < 0.0

    def keeps_apart(self, first: Indices, last: Indices) -> NDArray[np.bool_]:
        """Return whether sets keep the rules (m,) whose first (m, j) and last members (m, k) each do."""
        good = np.ones(len(first), dtype=bool)
        for a, b in product(range(first.shape[1]), range(last.shape[1])):
            good &= ~self.never_both[first[:, a], last[:, b]]
        sets = np.hstack([first, last])
        for rule in self.candidates.counts:
            if rule.most < sets.shape[1]:
                inside = np.zeros(len(self.weight), dtype=np.int64)
                inside[list(rule.members)] = 1
                good &= inside[sets].sum(axis=1) <= rule.most
        for groups, most in self._groups:
            if most < sets.shape[1]:
                used = (groups[sets][:, :, None] == np.arange(groups.max() + 1)).any(axis=1)
                good &= used.sum(axis=1) <= most
        return good

    @cached_property
    def _groups(self) -> list[tuple[Indices, int]]:
        """Group of each cut (n,), −1 for none, and largest number of groups used, by rule of variety."""
        groups = []
        for rule in self.candidates.varieties:
            number = np.full(len(self.weight), -1, dtype=np.int64)
            for n, group in enumerate(rule.groups):
                number[list(group)] = n
            groups.append((number, rule.most))
        return groups


def length(vectors: Array) -> Array:
    """Return the sum of the lengths of the judged vectors that lie side by side."""
    return np.asarray(np.hypot(vectors[..., 0::2], vectors[..., 1::2]).sum(axis=-1))


def parabola(three: Array, at: Array | float) -> Array:
    """Return the values at ``at`` of parabolas through values at 0, ½ and 1."""
    first, middle, last = np.moveaxis(three, -1, 0)
    curve = 2.0 * (first - 2.0 * middle + last)
    return np.asarray(first + at * (last - first - curve) + at * at * curve)


def slopes_of(three: Array) -> Array:
    """Return the slopes at 0, ½ and 1 of parabolas through values there."""
    first, middle, last = np.moveaxis(three, -1, 0)
    return np.stack(
        [4.0 * middle - 3.0 * first - last, last - first, first + 3.0 * last - 4.0 * middle], axis=-1
    )


def least_of(three: Array) -> Array:
    """Return the least values, between 0 and 1, of parabolas through values at 0, ½ and 1."""
    first, middle, last = np.moveaxis(three, -1, 0)
    curve = 2.0 * (first - 2.0 * middle + last)
    inside = np.clip((curve - last + first) / np.where(curve > 0.0, 2.0 * curve, 1.0), 0.0, 1.0)
    return parabola(three, np.where(curve > 0.0, inside, last < first))
