"""Tasks on designs for workers: the problem travels with each task, and a worker unpacks it once."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

from autobalance.profile_search.problem import Problem
from autobalance.studies.workers import InThisProcess, Workers

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
