"""Work on designs, done by workers: the problem goes with each task, and a worker unpacks it once."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

from autobalance.design_search.problem import Problem
from autobalance.studies.workers import InThisProcess, Workers

Work = Callable[[tuple[Any, Any]], Any]
"""Takes the problem, as it is or packed, and a task."""


def each_done(
    workers: Workers, work: Callable[[tuple[Any, Any]], Any], problem: Problem, tasks: Sequence[Any]
) -> list[Any]:
    """Return what becomes of each task, in order; the model of strengths is not known to the workers."""
    bare = replace(problem, model=None)
    if isinstance(workers, InThisProcess):
        return [work((bare, task)) for task in tasks]
    sent, results = pickle.dumps(bare), {}
    for done in workers.run(work, [(sent, task) for task in tasks]):
        # where no worker outlives a task, this process does it
        results[done.number] = work((bare, tasks[done.number])) if done.lost else done.value
    return [results[number] for number in range(len(tasks))]


def problem_of(sent: Any) -> Problem:
    """Return the problem of a task, as it is or as it was sent."""
    return sent if isinstance(sent, Problem) else _unpacked(sent)


@lru_cache(maxsize=1)
def _unpacked(sent: bytes) -> Problem:
    """Return a problem as it was sent; a worker makes it once."""
    problem: Problem = pickle.loads(sent)
    return problem
