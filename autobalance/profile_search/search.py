"""The search for designs: its start, a genetic algorithm, what is kept of it."""

from __future__ import annotations

import json
import shutil
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from autobalance.declare import NotNegative
from autobalance.errors import FileError, file_errors
from autobalance.profile_search.analyses import analysed_next, each_done, problem_of
from autobalance.profile_search.candidates import JudgedDesign, SearchResult, completed, judged, refined_sum
from autobalance.profile_search.envelope import Violation
from autobalance.profile_search.level_sets import CLOSENESS_STEPS, Closeness, LevelSet, begun, level_sets
from autobalance.profile_search.problem import Problem
from autobalance.profile_search.strength import Analysed
from autobalance.runtime import Progress, no_progress
from autobalance.studies.batch.journal import made_folder
from autobalance.studies.workers import InThisProcess, Workers
from autobalance.types import Array
from autobalance.value_classes import dataclass

# The search for designs: a genetic algorithm over control points, each design's balance solved for.
#
# Deterministic: every generation follows from the seed and the values of those before, so a stopped search
# is repeated with the values on disk.


PENALTY = 1e3
"""Weight of violations for a method without constraints."""
AT_ONCE = 4
"""Designs that a worker judges at a time."""
DIGITS = 6
"""Decimals of a millimetre in a search's start: gradients carry the last digits of a process up to 1e-11 mm,
and two processes would examine two fronts."""


@dataclass(frozen=True, eq=False)
class Generation:
    """One generation: its designs as proposed (unit cube) and as judged, and those analysed in it."""

    number: int
    asked: Array
    candidates: tuple[JudgedDesign, ...]
    analysed: tuple[Analysed, ...] = ()

    def line(self) -> dict[str, Any]:
        """Return the generation as JSON values with all digits."""
        analysed = [{"variables": each.variables.tolist(), **each.values} for each in self.analysed]
        return {
            "generation": self.number,
            "asked": self.asked.tolist(),
            "variables": [each.variables.tolist() for each in self.candidates],
            "objectives": [each.objectives.tolist() for each in self.candidates],
            "violations": [each.by_geometry for each in self.candidates],
            **({"analysed": analysed} if analysed else {}),
        }

    @classmethod
    def of_line(cls, line: dict[str, Any]) -> Generation:
        rows = zip(line["variables"], line["objectives"], line["violations"], strict=True)
        candidates = tuple(JudgedDesign(np.array(v), np.array(o), float(b), float(b)) for v, o, b in rows)
        analysed = []
        for each in line.get("analysed", ()):
            variables = each.pop("variables")
            analysed.append(Analysed(np.array(variables), each))
        return cls(int(line["generation"]), np.array(line["asked"]), candidates, tuple(analysed))


def searched(
    problem: Problem,
    known: Sequence[Generation],
    keep: Callable[[Generation], None],
    workers: Workers | None = None,
    progress: Progress = no_progress,
) -> SearchResult:
    """Return every design that the search judges.

    Parameters
    ----------
    problem : Problem
    known : sequence of Generation
        Generations of the same search before it was stopped.
    keep : callable
        Called with each new generation.
    workers : Workers or None
        Processes that judge designs; None: this one.
    progress : callable

    Raises
    ------
    FileError
        If the extra ``optimize`` is not installed.
    SolidError
        If no design of the first generation can be meshed, where finite elements are wanted.
    """
    pool = workers or InThisProcess()
    problem, begin = _begun(problem, pool)
    low, high = problem.bounds.T
    span = high - low
    options = problem.design.search
    algorithm = _algorithm(problem, begin)
    findings = SearchResult(problem, ())
    by_number = {generation.number: generation for generation in known}
    number, looked_at = 0, 0
    while algorithm.has_next():
        number += 1
        population = algorithm.ask()
        places = np.atleast_2d(population.get("X"))[: options.evaluations - looked_at]
        generation = by_number.get(number)
        if generation is None or not np.array_equal(generation.asked, places):
            progress(f"generation {number}", looked_at / options.evaluations)
            rows = _judged_all(problem, [low + place * span for place in places], pool)
            if problem.strengths_wanted:
                progress(f"finite elements, generation {number}", looked_at / options.evaluations)
            analysed = analysed_next(findings, rows, number, pool)
            generation = Generation(number, places, tuple(rows), analysed)
            keep(generation)
        findings = findings.with_known(generation.analysed) if generation.analysed else findings
        own = tuple(completed(findings.problem, each) for each in generation.candidates)
        findings = replace(findings, candidates=(*findings.candidates, *own))
        looked_at += len(own)
        progress(f"generation {number}", looked_at / options.evaluations)
        if looked_at >= options.evaluations:
            break
        _tell_algorithm(algorithm, population, own, options.method)
    return findings


def _begun(problem: Problem, pool: Workers) -> tuple[Problem, list[Array]]:
    """Return the problem with its control points at their best places, and the variables to begin from."""
    level = level_sets(problem)
    if not level:
        return problem, []
    ways = _ways_to_begin(problem, level)
    if not problem.design.search.refine:
        _, gathered, variables = next(ways)
        return gathered, variables
    problems = {}
    for close, gathered, _ in ways:
        different = tuple(np.concatenate([each.angles_rad for each in gathered.free.profiles]))
        problems[different] = close, gathered
    close_by = [close for close, _ in problems.values()]
    first = each_done(pool, _refined_task, problem, [(level[:1], close) for close in close_by])
    worth = [(each.violation, float(level[0].weights @ each.objectives)) for each in first]
    chosen = min(range(len(worth)), key=lambda place: worth[place])
    best, gathered = list(problems.values())[chosen]
    others = each_done(pool, _refined_task, problem, [([level[0], each], best) for each in level[1:]])
    refined = [first[chosen], *others]
    outlines = {each.tobytes(): each for each in (candidate.variables.round(DIGITS) for candidate in refined)}
    return gathered, list(outlines.values())


def _ways_to_begin(
    problem: Problem, level: Sequence[LevelSet]
) -> Iterator[tuple[Closeness, Problem, list[Array]]]:
    """Yield each closeness of control points at corners, its problem, and the variables to begin from."""
    for close in CLOSENESS_STEPS:
        gathered, variables = begun(problem, level, close)
        if (np.diff(gathered.bounds) >= 0.0).all():  # points far apart may find no room for their corners
            yield close, gathered, variables


def _refined_task(task: tuple[Any, tuple[Sequence[LevelSet], Closeness]]) -> JudgedDesign:
    """Return the last level set refined, with its control points gathered at the corners of the first."""
    level, close = task[1]
    problem, variables = begun(problem_of(task[0]), level, close)
    return refined_sum(problem, judged(problem, variables[-1]), level[-1].weights)


def _judged_all(problem: Problem, rows: Sequence[Array], workers: Workers) -> list[JudgedDesign]:
    parts = [rows[begin : begin + AT_ONCE] for begin in range(0, len(rows), AT_ONCE)]
    return [candidate for part in each_done(workers, _judged_task, problem, parts) for candidate in part]


def _judged_task(task: tuple[Any, Sequence[Array]]) -> list[JudgedDesign]:
    problem = problem_of(task[0])
    return [judged(problem, row) for row in task[1]]


def _algorithm(problem: Problem, seeds: Sequence[Array]) -> Any:
    """Return pymoo's algorithm, seeded with the start, the level sets (v,) and designs around the start."""
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
    start, *others = [np.clip((each - low) / span, 0.0, 1.0) for each in (problem.start, *seeds)]
    count = len(start)
    if options.method == "cmaes":
        from pymoo.algorithms.soo.nonconvex.cmaes import CMAES  # takes seconds to import

        space = Space(n_var=count, n_obj=1, xl=0.0, xu=1.0)
        algorithm: Any = CMAES(
            x0=others[0] if others else start, sigma=0.2, restarts=0, popsize=options.population
        )
    else:
        space = Space(n_var=count, n_obj=len(options.objectives), n_ieq_constr=1, xl=0.0, xu=1.0)
        algorithm = NSGA2(
            pop_size=options.population, sampling=_first([start, *others], options.population, options.seed)
        )
    algorithm.setup(
        space, termination=get_termination("n_eval", options.evaluations), seed=options.seed, verbose=False
    )
    return algorithm


def _first(begin: Sequence[Array], count: int, seed: int) -> Array:
    """Return the first population: the start, the level sets, designs around it, and designs anywhere."""
    start = begin[0]
    draw = np.random.default_rng(seed)
    near = start + 0.15 * draw.standard_normal((count // 2, len(start)))
    level = draw.random((count - count // 2, 1))
    anywhere = np.clip(level + 0.3 * draw.standard_normal((count - count // 2, len(start))), 0.0, 1.0)
    first = np.concatenate([np.clip(near, 0.0, 1.0), anywhere])
    first[: len(begin)] = begin[:count]
    return first


def _tell_algorithm(algorithm: Any, population: Any, candidates: Sequence[JudgedDesign], method: str) -> None:
    broken = np.array([[each.violation] for each in candidates])
    values = np.stack([each.objectives for each in candidates])
    if method == "cmaes":
        scale = np.abs(values[0, 0]) or 1.0
        population.set("F", values + PENALTY * scale * broken)
    else:
        population.set("F", values)
        population.set("G", broken)
    algorithm.evaluator.n_eval += len(candidates)
    algorithm.tell(infills=population)


# The start of a design search: its objectives, its residual, and the constraints that it breaks.


@dataclass(frozen=True)
class StartFigures:
    """Objectives and residual of the original crank, and constraints that it breaks."""

    objectives: Annotated[Mapping[str, float], "by name"]
    residual_g_mm: NotNegative
    feasible: bool
    violations: tuple[Violation, ...]
    fit_error_mm: Annotated[NotNegative, "of the profiles to the start's own rims"]


def judged_start(problem: Problem) -> StartFigures:
    """Judge the original crank.

    Raises
    ------
    SolidError
        If finite elements are wanted, and the solid cannot be meshed.
    """
    variables, moments = problem.as_it_came, problem.crank.moments
    residual = problem.residual(moments)
    constraints, _ = problem.constraints(variables, moments, residual)
    solid = problem.crank.source.solid.moved(problem.crank.anatomy.file_to_rotor)
    strengths = problem.strengths(moments, solid)
    every = [*constraints, *problem.of_strengths(strengths)]
    broken = tuple(each.violation for each in every if each.violation is not None)
    return StartFigures(
        problem.asked(problem.objectives(moments, strengths, solid)),
        residual.magnitude_g_mm,
        not broken,
        broken,
        problem.free.fit_error_mm,
    )


# A design search on disk: one line for each generation, from which a stopped search resumes.


SEARCH_FILE = "search.jsonl"
WRITTEN_FILES = ("design.json", "front.svg", "front.png", SEARCH_FILE)
DESIGNS = "designs"


class KeptSearch:
    """Generations of a search, kept in a folder if there is one.

    Parameters
    ----------
    folder : Path or None
    fingerprint : str
        Hash of everything that the search depends on; each line holds it.
    fresh : bool
        Delete the results of earlier searches in the folder.

    Raises
    ------
    FileError
        If the folder belongs to another design, or cannot be written.
    """

    def __init__(self, folder: Path | None, fingerprint: str, *, fresh: bool) -> None:
        self.generations: list[Generation] = []
        self._folder, self._fingerprint = folder, fingerprint
        if folder is None:
            return
        lines = [] if fresh else _lines(folder / SEARCH_FILE)
        if any(line.get("design") != fingerprint for line in lines):
            raise FileError(f"{folder} holds another design's search; choose another folder, or --fresh")
        self.generations = [Generation.of_line(line) for line in takewhile(_is_as_written, lines)]
        made_folder(folder)
        with file_errors(f"write {folder}"):
            if fresh:
                _forget(folder)
            text = "".join(self._text(generation) for generation in self.generations)
            (folder / SEARCH_FILE).write_text(text, encoding="utf-8")

    def keep(self, generation: Generation) -> None:
        if self._folder is not None:
            with (self._folder / SEARCH_FILE).open("a", encoding="utf-8") as stream:
                stream.write(self._text(generation))

    def _text(self, generation: Generation) -> str:
        line = generation.line()
        return json.dumps({"design": self._fingerprint, "crc32": _crc32(line), **line}) + "\n"


def _crc32(line: Mapping[str, Any]) -> int:
    return zlib.crc32(json.dumps(line).encode())


def _is_as_written(line: Mapping[str, Any]) -> bool:
    """Return whether a line is as it was written: the search resumes before the first changed one."""
    generation = {key: value for key, value in line.items() if key not in ("design", "crc32")}
    return line.get("crc32") == _crc32(generation)


def _lines(path: Path) -> list[dict[str, Any]]:
    """Return the complete lines of a file as objects, up to the first that is not JSON."""
    if not path.exists():
        return []
    entries = []
    for text in path.read_text(encoding="utf-8", errors="replace").split("\n")[:-1]:
        try:
            line = json.loads(text)
        except (ValueError, RecursionError):
            break
        entries.append(line if isinstance(line, dict) else {})
    return entries


def _forget(folder: Path) -> None:
    """Delete everything that searches have written to the folder."""
    for name in WRITTEN_FILES:
        (folder / name).unlink(missing_ok=True)
    if (folder / DESIGNS).is_dir():
        shutil.rmtree(folder / DESIGNS)
