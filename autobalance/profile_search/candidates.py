"""Designs as a search judges them: by the moments of their profiles and by their predicted strength."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from autobalance.profile_search.envelope import violation
from autobalance.profile_search.problem import STRESS, Problem
from autobalance.profile_search.strength_model import Analysed, StrengthModel
from autobalance.rigid_rotor.moments import Moments
from autobalance.types import Array


@dataclass(frozen=True, eq=False)
class Candidate:
    """A judged design: variables (v,) with the balance met, objectives (k,) to be least, and violation.

    ``violation`` counts all limits, ``by_geometry`` only those that need no finite elements.
    """

    variables: Array
    objectives: Array
    violation: float
    by_geometry: float


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of a search: every design judged, with the knowledge of its end.

    Attributes
    ----------
    problem : Problem
        With the last model of strengths.
    candidates : sequence of Candidate
    analysed : sequence of Analysed
        Designs analysed by finite elements.
    """

    problem: Problem
    candidates: tuple[Candidate, ...]
    analysed: tuple[Analysed, ...] = ()

    def with_known(self, analysed: Sequence[Analysed]) -> SearchResult:
        """Return the result with more designs analysed, and all candidates judged again by the new model."""
        every = (*self.analysed, *analysed)
        problem = replace(self.problem, model=StrengthModel.of(self.problem.bounds, every))
        return SearchResult(problem, tuple(completed(problem, each) for each in self.candidates), every)


def objective_values(problem: Problem, moments: Moments, variables: Array) -> Array:
    """Return the values (k,) of a search's objectives, each to be minimized; the stress is predicted."""
    predicted = {} if problem.model is None else problem.model.predicted(variables)
    values = {STRESS: 0.0, **problem.objectives(moments, predicted)}
    return np.array([sign * values[name] for name, sign in problem.signed_objectives])


def judged(problem: Problem, variables: Array) -> Candidate:
    """Return the design with its balance solved for, judged by the moments of its profiles."""
    solved = problem.solved(variables)
    moments = problem.moments(solved)[0]
    constraints, _ = problem.constraints(solved, moments, problem.residual(moments), exact=False)
    broken = violation(constraints)
    every = broken + violation(problem.predicted_limits(solved))
    return Candidate(solved, objective_values(problem, moments, solved), every, broken)


def completed(problem: Problem, candidate: Candidate) -> Candidate:
    """Return a candidate with its strengths predicted by the model; unchanged without a model."""
    if problem.model is None:
        return candidate
    predicted, values = problem.model.predicted(candidate.variables), candidate.objectives.copy()
    for place, (name, sign) in enumerate(problem.signed_objectives):
        if name == STRESS:
            values[place] = sign * predicted[STRESS]
    broken = candidate.by_geometry + violation(problem.predicted_limits(candidate.variables))
    return replace(candidate, objectives=values, violation=broken)


def front(candidates: Sequence[Candidate]) -> list[int]:
    """Return the indices of the Pareto-optimal designs, of equal ones the first only."""
    values = np.stack([each.objectives for each in candidates])
    kept: list[int] = []
    for number, own in enumerate(values):
        beaten = ((values <= own).all(axis=1) & (values < own).any(axis=1)).any()
        same = any((values[other] == own).all() for other in kept)
        if not beaten and not same:
            kept.append(number)
    return kept


def spread_over(candidates: Sequence[Candidate], numbers: Sequence[int], count: int) -> list[int]:
    """Return at most ``count`` designs of a front: the best in each objective, then the most isolated."""
    values = np.stack([candidates[number].objectives for number in numbers])
    reach = np.maximum(np.ptp(values, axis=0), 1e-300)
    scaled = (values - values.min(axis=0)) / reach
    chosen = list(dict.fromkeys(int(column.argmin()) for column in scaled.T))[:count]
    while len(chosen) < min(count, len(numbers)):
        apart = np.linalg.norm(scaled[:, None] - scaled[chosen][None], axis=2).min(axis=1)
        apart[chosen] = -1.0
        chosen.append(int(apart.argmax()))
    return [numbers[place] for place in sorted(chosen)]


def least_violated(candidates: Sequence[Candidate]) -> Iterator[Candidate]:
    yield from sorted(candidates, key=lambda each: (each.violation, *each.objectives))
