"""Which of the designs that were looked at are written: the front, as far as it holds when measured."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.design_search.problem import Problem
from autobalance.design_search.refine import refined
from autobalance.design_search.search import Candidate, front, least_violated, spread_over
from autobalance.design_search.written import WrittenDesign, written

TRIED_MOST = 25
"""Designs that are written to find one that keeps everything when measured."""


def with_refined(problem: Problem, found: Sequence[Candidate]) -> list[Candidate]:
    """Return what was found, and the best in each objective made better by gradients."""
    every = list(found)
    for objective in range(len(problem.design.search.objectives)):
        best = min(every, key=lambda each: (each.violation, each.objectives[objective]))
        every.append(refined(problem, best, objective))
    return every


def chosen(problem: Problem, found: Sequence[Candidate]) -> tuple[list[WrittenDesign], bool]:
    """Return the designs to be written, and whether they keep everything when measured."""
    left = [each for each in found if each.violation <= 0.0]
    kept: list[WrittenDesign] = []
    for _ in range(TRIED_MOST):
        if not left:
            break
        numbers = spread_over(left, front(left), problem.design.search.designs)
        tried = [(number, written(problem, left[number].variables)) for number in numbers]
        kept += [made for _, made in tried if made.feasible]
        if kept:
            return kept, True
        left = [each for number, each in enumerate(left) if number not in numbers]
    nearest = next(iter(least_violated(found)))
    return [written(problem, nearest.variables)], False
