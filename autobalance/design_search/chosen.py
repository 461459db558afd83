"""Which of the designs that were looked at are written: the front, as far as it holds when measured."""

from __future__ import annotations

from collections.abc import Sequence

from autobalance.design_search.envelope import violation
from autobalance.design_search.problem import Problem
from autobalance.design_search.refine import refined
from autobalance.design_search.search import Candidate, front, least_violated, spread_over
from autobalance.design_search.written import WrittenDesign, written

TRIED_MOST = 20
"""Designs that are written to find one that keeps everything when measured."""


def with_refined(problem: Problem, found: Sequence[Candidate]) -> list[Candidate]:
    """Return what was found, and the best in each objective made better by gradients."""
    every = list(found)
    for objective in range(len(problem.design.search.objectives)):
        best = min(every, key=lambda each: (each.violation, each.objectives[objective]))
        every.append(refined(problem, best, objective))
    return every


def chosen(problem: Problem, found: Sequence[Candidate]) -> tuple[list[WrittenDesign], bool]:
    """Return the designs to be written, and whether they keep everything when measured.

    The front first; where none of it does (finite elements are asked only here), designs from all over what
    is feasible, and at last the least violated of those that were measured.
    """
    left = [each for each in found if each.violation <= 0.0]
    tried: list[WrittenDesign] = []
    while left and len(tried) < TRIED_MOST:
        among = range(len(left)) if tried else front(left)
        numbers = spread_over(left, list(among), min(problem.design.search.designs, TRIED_MOST - len(tried)))
        made = [written(problem, left[number].variables) for number in numbers]
        kept = [each for each in made if each.feasible]
        if kept:
            return kept, True
        tried += made
        left = [each for number, each in enumerate(left) if number not in numbers]
    if not tried:
        tried = [written(problem, next(iter(least_violated(found))).variables)]
    return [min(tried, key=lambda each: violation(each.constraints))], False
