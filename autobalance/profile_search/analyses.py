"""Analyses of designs, and the tasks that carry them to workers."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from autobalance.errors import SolidError
from autobalance.profile_search.candidates import JudgedDesign, SearchResult, completed, front, least_violated
from autobalance.profile_search.input import DEFAULT_ANALYSES
from autobalance.profile_search.problem import Problem
from autobalance.profile_search.strength import Analysed
from autobalance.profile_search.written import with_profiles
from autobalance.studies.workers import InThisProcess, Workers
from autobalance.types import Array

# Tasks on designs for workers: the problem travels with each task, and a worker unpacks it once.


Work = Callable[[tuple[Any, Any]], Any]
"""Function of a task: takes the problem, plain or packed, and the task."""


def each_done(
    workers: Workers, work: Callable[[tuple[Any, Any]], Any], problem: Problem, tasks: Sequence[Any]
) -> list[Any]:
    """Return the results of all tasks in order; workers have no model of strengths."""
    bare = replace(problem, model=None)
    if isinstance(workers, InThisProcess):
        return [work((bare, task)) for task in tasks]
    sent, results = pickle.dumps(bare), {}
    for done in workers.run(work, [(sent, task) for task in tasks]):
        # where no worker outlives a task, this process does it
        results[done.number] = work((bare, tasks[done.number])) if done.lost else done.value
    return [results[number] for number in range(len(tasks))]


def problem_of(sent: Any) -> Problem:
    """Return the problem of a task, plain or unpacked."""
    return sent if isinstance(sent, Problem) else _unpacked(sent)


@lru_cache(maxsize=1)
def _unpacked(sent: bytes) -> Problem:
    """Return a packed problem; a worker unpacks it once."""
    problem: Problem = pickle.loads(sent)
    return problem


# Choice of the designs of a search that finite elements analyse, so that all others can be predicted.


MIN_FIRST_ANALYSES = 6
"""Smallest number of designs analysed in the first generation."""
SAME_PLACE = 1e-3
"""Distance, as a share of the bounds, within which a design adds nothing new."""


def analysed_next(
    findings: SearchResult, rows: Sequence[JudgedDesign], number: int, workers: Workers
) -> tuple[Analysed, ...]:
    """Return finite-element results of the most uncertain designs of a generation.

    Half of the analyses are of the first generation, spread over it; the others of the designs that look
    best by the model so far, as many in each generation.
    """
    problem, options = findings.problem, findings.problem.design.search
    if not problem.strengths_wanted:
        return ()
    most = DEFAULT_ANALYSES if problem.design.fem is None else problem.design.fem.analyses
    left = most - len(findings.analysed)
    generations = math.ceil(options.evaluations / options.population)
    if number == 1:
        count = left if generations == 1 else min(left, max(math.ceil(left / 2), MIN_FIRST_ANALYSES))
        chosen = _far_apart([each.variables for each in rows], count, problem.bounds)
    else:
        count = math.ceil(max(left, 0) / max(generations - number + 1, 1))
        chosen = _least_known(findings, rows, count)
    analysed = each_done(workers, _analysed_task, problem, chosen)
    if number == 1 and not any(each.values for each in analysed):
        raise SolidError("no design of the first generation can be meshed; choose another [fem] size_mm")
    return tuple(analysed)


def _far_apart(rows: Sequence[Array], count: int, bounds: Array) -> list[Array]:
    """Return at most ``count`` designs, each once: the first, then always that furthest from all chosen."""
    low, high = bounds.T
    places = (np.stack(rows) - low) / np.where(high > low, high - low, 1.0)
    chosen = [0]
    far = np.linalg.norm(places - places[0], axis=1)
    while len(chosen) < min(count, len(rows)) and far.max() > SAME_PLACE:
        chosen.append(int(far.argmax()))
        far = np.minimum(far, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return [rows[number] for number in chosen]


def _least_known(findings: SearchResult, rows: Sequence[JudgedDesign], count: int) -> list[Array]:
    """Return at most ``count`` designs far from all analysed ones: those of the front first, then others."""
    model = findings.problem.model
    rows_known = [completed(findings.problem, each) for each in rows]
    kept = [each for each in rows_known if each.violation <= 0.0]
    best = [kept[number] for number in front(kept)] if kept else list(least_violated(rows_known))[:count]
    others = [each for each in rows_known if each.by_geometry <= 0.0 and each not in best]
    chosen: list[Array] = []
    for pool in (best, others):
        far = [math.inf if model is None else model.nearest(each.variables) for each in pool]
        order = np.argsort(np.negative(far), kind="stable")
        chosen += [pool[place].variables for place in order if far[place] > SAME_PLACE]
    return chosen[:count]


def _analysed_task(task: tuple[Any, Array]) -> Analysed:
    """Return a design's finite-element results to six digits (a mesh is worth four); none without a mesh."""
    problem, variables = problem_of(task[0]), task[1]
    amounts = problem.amounts(variables)
    solid = with_profiles(problem.free, amounts.radii_mm, amounts.thickness_mm)
    try:
        strengths = problem.strengths(problem.moments(variables)[0], solid)
    except SolidError:
        return Analysed(variables, {})
    return Analysed(variables, {name: float(f"{value:.6g}") for name, value in strengths.items()})
