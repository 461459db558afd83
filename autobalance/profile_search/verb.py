"""``ab.design``: counterweight profiles searched for the best, their balance met exactly."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import field
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalance.report.files import Staging, remove_stale
from autobalance.report.plots import Plot, Plots
from autobalance.runtime import Progress, no_progress
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.result import VerbResult
from autobalance.version import __version__

if TYPE_CHECKING:
    from autobalance.profile_search.answer import DesignFigures, DesignReport
    from autobalance.profile_search.candidates import JudgedDesign, SearchResult
    from autobalance.profile_search.input import DesignJob
    from autobalance.profile_search.problem import Problem
    from autobalance.profile_search.written import WrittenDesign

INFEASIBLE = 4


@dataclass(frozen=True, eq=False, repr=False)
class DesignResult(VerbResult):
    """The best designs; ``made`` are the files of each by its id."""

    content: DesignReport
    made: Mapping[str, Mapping[str, bytes]] = field(default_factory=dict)
    drawn: Plot | None = None

    @property
    def exit_code(self) -> int:
        """4 where every design breaks a constraint, else 0."""
        return 0 if self.content.outcome == "found" else INFEASIBLE

    def text(self, units: str = "metric") -> str:
        """Return the designs as lines for people; always metric."""
        from autobalance.profile_search.files import design_text

        return design_text(self.content)

    def plots(self) -> Plots:
        """Return the front."""
        return Plots({} if self.drawn is None else {"front": self.drawn})

    def files(self) -> Mapping[str, bytes]:
        """Return each design's files and the front."""
        by_name = {
            f"designs/{name}/{file}": data
            for name, files in self.made.items()
            for file, data in files.items()
        }
        front = {} if self.drawn is None else {f"front.{ending}": self.drawn[ending] for ending in self.drawn}
        return {**by_name, **front}


@documented
def design(
    source: str | Path | dict[str, Any],
    output: str | Path | None = None,
    *,
    fresh: bool = False,
    workers: int | None = None,
    cluster: str | None = None,
    cluster_timeout_s: float = 10.0,
    progress: Progress | None = None,
) -> DesignResult:
    """Search profiles of counterweights for the best designs.

    Parameters
    ----------
    source : path or dict
        Design file: the start, what is free and what must be kept. Or its tables; files are relative to the
        working folder then.
    output : path or None
        Results folder; an interrupted search resumes from it. None: nothing is written.
    fresh : bool
        Discard what the folder holds of another search.

    Returns
    -------
    DesignResult
        That no design keeps everything is a result too.

    Raises
    ------
    JobError
        If the design is impossible: crossing control points, held metal outside the envelope.
    FileError
        If the folder is of another design, the extra is not installed, or the cluster does not answer.
    """
    from autobalance.balancing.measured_crank import measure_crank
    from autobalance.profile_search.free_metal import free_metal
    from autobalance.profile_search.input import load_design, parse_design
    from autobalance.profile_search.problem import Problem
    from autobalance.profile_search.search import KeptSearch, searched
    from autobalance.runtime import Stopwatch
    from autobalance.studies.workers import workers_of

    started = time.perf_counter()
    notify = progress or no_progress
    job = parse_design(source, Path("design.toml")) if isinstance(source, dict) else load_design(Path(source))
    with workers_of(workers, cluster, cluster_timeout_s) as pool:
        notify("reading the crank", 0.0)
        crank = measure_crank(job.start.crankshaft, Stopwatch())
        problem = Problem.of(job, crank, free_metal(job, crank))
        folder = None if output is None else Path(output)
        kept = KeptSearch(folder, _fingerprint(job, crank.source.sha256), fresh=fresh)
        searched_designs = searched(
            problem, kept.generations, kept.keep, pool, lambda words, share: notify(words, 0.8 * share)
        )
        result = _result(searched_designs, started, notify)
    if folder is not None:
        _write(result, folder)
    return result


def _fingerprint(job: DesignJob, crank_sha256: str) -> str:
    inputs = {"design": job.raw, "crank": crank_sha256, "version": __version__}
    return sha256(json.dumps(inputs, sort_keys=True, default=str).encode()).hexdigest()


# --- from candidates to designs -----------------------------------------------------------------------------


def _result(findings: SearchResult, started: float, notify: Progress) -> DesignResult:
    from autobalance.profile_search.answer import (
        DesignFigures,
        DesignReport,
        SearchFigures,
        front_of,
        infeasible_reason,
        remedies,
        step_notes,
    )
    from autobalance.profile_search.candidates import chosen, with_refined
    from autobalance.profile_search.search import judged_start

    problem = findings.problem
    every = findings
    if problem.design.search.refine:
        notify("refining by gradients", 0.8)
        every = with_refined(findings)
    notify("writing designs", 0.85)
    answer = chosen(every)
    picked = answer.designs
    files_of: dict[str, dict[str, bytes]] = {}
    listed = []
    for number, each in enumerate(picked, 1):
        name = f"d{number:02d}"
        files_of[name] = _files(problem, each)
        digests = {file: sha256(data).hexdigest() for file, data in files_of[name].items()}
        listed.append(DesignFigures.of(problem, name, each, digests))
        notify("writing designs", 0.85 + 0.15 * number / len(picked))
    front, best = front_of(problem, listed)
    report = DesignReport(
        design=problem.design.raw,
        start=judged_start(problem),
        search=SearchFigures.of(findings, answer),
        designs=listed,
        front=front,
        best=best,
        outcome="found" if answer.kept else "infeasible",
        reason=None if answer.kept else infeasible_reason(picked[0], lambda: remedies(problem)),
        notes=step_notes({file for files in files_of.values() for file in files}),
        seconds=time.perf_counter() - started,
    )
    return DesignResult(report, files_of, _drawn(problem, answer.found.candidates, listed))


def _files(problem: Problem, design: WrittenDesign) -> dict[str, bytes]:
    """Return a design's files by name."""
    from autobalance.profile_search.files import design_picture
    from autobalance.profile_search.written import design_step, job_toml
    from autobalance.solid.cad.installed import has_kernel

    files = {"crank.stl": design.data}
    if has_kernel():
        drillings = problem.design.drillings
        name, data = design_step(problem.free, problem.crank, design.amounts, drillings)
        files[name] = data
    files["picture.png"] = design_picture(design.solid.mesh)
    files["job.toml"] = job_toml(problem).encode()
    return files


def _drawn(problem: Problem, candidates: Sequence[JudgedDesign], designs: Sequence[DesignFigures]) -> Plot:
    from autobalance.profile_search.files import front_plot

    names = tuple(name for name, _ in problem.signed_objectives)
    signs = np.array([sign for _, sign in problem.signed_objectives])
    good = [each for each in candidates if each.violation <= 0.0] or list(candidates)
    others = np.stack([each.objectives for each in good]) * signs
    front = np.array([[each.objectives[name] for name in names] for each in designs])
    return front_plot(names, front, others)


def _write(result: DesignResult, folder: Path) -> None:
    """Write the report, the designs and the front, all or none; designs of an earlier search go."""
    targets = {folder / name: data for name, data in result.folder_files(folder).items()}
    with Staging(sorted({path.parent for path in targets})) as staging:
        for path, data in targets.items():
            staging.add(path, data)
        remove_stale(staging, folder / result.report_name, result.report)
        staging.commit()
