"""The search for designs: a genetic algorithm over control points, each design's balance solved for.

Deterministic: every generation follows from the seed and the values of those before, so a search that was
stopped is run again with the values it has on disk.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalance.design_search.build import with_profiles
from autobalance.design_search.envelope import violation
from autobalance.design_search.problem import STRESS, Problem
from autobalance.errors import FileError
from autobalance.rigid_rotor.moments import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.studies.workers import InThisProcess, Workers

Array = NDArray[np.float64]

PENALTY = 1e3
"""Weight of broken constraints where the method knows none."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A judged design: variables (v,) with the balance met, objectives (k,) to be least, and violation."""

    variables: Array
    objectives: Array
    violation: float


@dataclass(frozen=True, eq=False)
class Generation:
    """One generation as it was asked (unit cube) and judged."""

    number: int
    asked: Array
    candidates: tuple[Candidate, ...]

    def line(self) -> dict[str, Any]:
        """Return it as JSON values with all digits."""
        return {
            "generation": self.number,
            "asked": self.asked.tolist(),
            "variables": [each.variables.tolist() for each in self.candidates],
            "objectives": [each.objectives.tolist() for each in self.candidates],
            "violations": [each.violation for each in self.candidates],
        }

    @classmethod
    def of_line(cls, line: dict[str, Any]) -> Generation:
        """Return the generation that a line holds."""
        rows = zip(line["variables"], line["objectives"], line["violations"], strict=True)
        made = tuple(Candidate(np.array(v), np.array(o), float(b)) for v, o, b in rows)
        return cls(int(line["generation"]), np.array(line["asked"]), made)


def objective_values(problem: Problem, moments: Moments, variables: Array) -> Array:
    """Return the values (k,) of a search's objectives, each to be least; its solid is made for the stress."""

    def solid() -> Solid:
        amounts = problem.amounts(variables)
        return with_profiles(problem.free, amounts.radii_mm, amounts.thickness_mm)[0]

    values = problem.objectives(moments, solid if STRESS in problem.wanted else None)
    return np.array(
        [
            -values[name.removeprefix("-")] if name.startswith("-") else values[name]
            for name in problem.design.search.objectives
        ]
    )


def judged(problem: Problem, variables: Array) -> Candidate:
    """Return a design with its balance solved for, judged by its profiles' own moments."""
    solved = problem.solved(variables)
    moments = problem.moments(solved)[0]
    constraints, _ = problem.constraints(solved, moments, problem.residual(moments), exact=False)
    return Candidate(solved, objective_values(problem, moments, solved), violation(constraints))


def searched(
    problem: Problem,
    known: Sequence[Generation],
    keep: Callable[[Generation], None],
    workers: Workers | None = None,
    progress: Callable[[str, float], object] = lambda _words, _share: None,
) -> list[Candidate]:
    """Return every design that was looked at.

    Parameters
    ----------
    problem : Problem
    known : sequence of Generation
        Of the same search, when it was stopped.
    keep : callable
        Told each new generation.
    workers : Workers or None
        Who judges designs; None: this process.
    progress : callable

    Raises
    ------
    FileError
        If the extra ``optimize`` is not installed.
    """
    low, high = problem.bounds.T
    span = high - low
    options = problem.design.search
    algorithm = _algorithm(problem)
    found: list[Candidate] = []
    by_number = {generation.number: generation for generation in known}
    number = 0
    while algorithm.has_next():
        number += 1
        asked = algorithm.ask()
        places = np.atleast_2d(asked.get("X"))[: options.evaluations - len(found)]
        generation = by_number.get(number)
        if generation is None or not np.array_equal(generation.asked, places):
            rows = _judged_all(problem, [low + place * span for place in places], workers or InThisProcess())
            generation = Generation(number, places, tuple(rows))
            keep(generation)
        found += generation.candidates
        progress(f"generation {number}", len(found) / options.evaluations)
        if len(found) >= options.evaluations:
            break
        _tell(algorithm, asked, generation, options.method)
    return found


AT_ONCE = 4
"""Designs that a worker judges at a time."""


def _judged_all(problem: Problem, rows: Sequence[Array], workers: Workers) -> list[Candidate]:
    if isinstance(workers, InThisProcess):
        return [judged(problem, row) for row in rows]
    each = 1 if STRESS in problem.wanted else AT_ONCE
    parts = [rows[begin : begin + each] for begin in range(0, len(rows), each)]
    sent = pickle.dumps(problem)
    made: dict[int, list[Candidate]] = {}
    for done in workers.run(_judged_task, [(sent, part) for part in parts]):
        here = done.lost  # no worker outlives it: where this process does, its answer stands
        made[done.number] = [judged(problem, row) for row in parts[done.number]] if here else done.value
    return [candidate for number in range(len(parts)) for candidate in made[number]]


def _judged_task(task: tuple[bytes, Sequence[Array]]) -> list[Candidate]:
    sent, rows = task
    problem = _problem(sent)
    return [judged(problem, row) for row in rows]


@lru_cache(maxsize=1)
def _problem(sent: bytes) -> Problem:
    """Return a problem as it was sent; a worker makes it once."""
    found: Problem = pickle.loads(sent)
    return found


def _algorithm(problem: Problem) -> Any:
    """Return pymoo's algorithm, set up: the start and designs around it first."""
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.core.problem import Problem as Space
        from pymoo.termination import get_termination
    except ImportError:
        raise FileError(
            "a search needs pymoo, which is not installed: pip install 'autobalance[optimize]'"
        ) from None
    options = problem.design.search
    low, high = problem.bounds.T
    span = np.where(high > low, high - low, 1.0)
    start = np.clip((problem.start - low) / span, 0.0, 1.0)
    count = len(start)
    if options.method == "cmaes":
        from pymoo.algorithms.soo.nonconvex.cmaes import CMAES  # takes seconds to import

        space = Space(n_var=count, n_obj=1, xl=0.0, xu=1.0)
        algorithm: Any = CMAES(x0=start, sigma=0.2, restarts=0, popsize=options.population)
    else:
        space = Space(n_var=count, n_obj=len(options.objectives), n_ieq_constr=1, xl=0.0, xu=1.0)
        algorithm = NSGA2(
            pop_size=options.population, sampling=_first(start, options.population, options.seed)
        )
    algorithm.setup(
        space, termination=get_termination("n_eval", options.evaluations), seed=options.seed, verbose=False
    )
    return algorithm


def _first(start: Array, count: int, seed: int) -> Array:
    """Return the first population: the start, designs around it, and designs anywhere."""
    draw = np.random.default_rng(seed)
    near = start + 0.15 * draw.standard_normal((count // 2, len(start)))
    level = draw.random((count - count // 2, 1))
    anywhere = np.clip(level + 0.3 * draw.standard_normal((count - count // 2, len(start))), 0.0, 1.0)
    first = np.concatenate([np.clip(near, 0.0, 1.0), anywhere])
    first[0] = start
    return first


def _tell(algorithm: Any, asked: Any, generation: Generation, method: str) -> None:
    broken = np.array([[each.violation] for each in generation.candidates])
    values = np.stack([each.objectives for each in generation.candidates])
    if method == "cmaes":
        scale = np.abs(values[0, 0]) or 1.0
        asked.set("F", values + PENALTY * scale * broken)
    else:
        asked.set("F", values)
        asked.set("G", broken)
    algorithm.evaluator.n_eval += len(generation.candidates)
    algorithm.tell(infills=asked)


def front(candidates: Sequence[Candidate]) -> list[int]:
    """Return the numbers of the designs that no other beats in all objectives, each once."""
    values = np.stack([each.objectives for each in candidates])
    kept: list[int] = []
    for number, own in enumerate(values):
        beaten = ((values <= own).all(axis=1) & (values < own).any(axis=1)).any()
        same = any((values[other] == own).all() for other in kept)
        if not beaten and not same:
            kept.append(number)
    return kept


def spread_over(candidates: Sequence[Candidate], numbers: Sequence[int], count: int) -> list[int]:
    """Return at most ``count`` designs of a front: the best in each objective, then the loneliest."""
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
    """Yield designs, the least violated first."""
    yield from sorted(candidates, key=lambda each: (each.violation, *each.objectives))
