"""``ab.study``: many cranks made to one plan, and how many of them are within tolerance."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.errors import UsageError
from autobalance.report.plots import Plots
from autobalance.runtime import Progress, no_progress
from autobalance.studies.study.input import study_options
from autobalance.types import Array
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import documented
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.job import Job
    from autobalance.studies.study.answer import StudyReport
    from autobalance.verbs.crank import Crank

NOT_REACHED = 4
PLOTS_SHOWN = 2
"""Plots on the page: the spread of the cranks, and its causes."""


@dataclass(frozen=True, eq=False, repr=False)
class StudyResult(VerbResult):
    """Share of drawn cranks within tolerance, causes of the others, and remedies.

    Attributes
    ----------
    series : bytes
        The drawn cranks as CSV, one row each.
    shares : array
        What each of them uses of the permissible value (n,).
    missed : bool
        Whether the target requested is not reached, or the plan itself is above tolerance.
    """

    content: StudyReport
    series: bytes
    shares: Array
    missed: bool

    @property
    def exit_code(self) -> int:
        """4 where the target is not reached or the plan itself is above tolerance, else 0."""
        return NOT_REACHED if self.missed else 0

    def text(self, units: str = "metric") -> str:
        """Return the study as lines for people."""
        from autobalance.report.display_units import ON_SCREEN
        from autobalance.studies.study.answer import study_text

        return study_text(self.content, ON_SCREEN[units])

    def page(self, units: str = "metric") -> bytes:
        """Return the study as a page for a browser, with its plots where what draws them is installed."""
        from importlib.util import find_spec

        from autobalance.report.page.templates import summary_page

        drawn = self.plots().values() if find_spec("matplotlib") is not None else ()
        plots = [each._repr_svg_() for each in list(drawn)[:PLOTS_SHOWN]]
        return summary_page("Study", self.text(units), not self.missed, plots=plots)

    def plots(self) -> Plots:
        """Return a histogram of what is used of the permissible value, and a tornado of the causes."""
        from autobalance.studies.study.answer import study_plots

        return Plots(study_plots(self.content, self.shares))

    def files(self) -> Mapping[str, bytes]:
        """Return the series."""
        return {"series.csv": self.series}


@documented
def study(
    job: str | Path | Job | Mapping[str, Any],
    crank: Crank | None = None,
    *,
    settings: Sequence[str] = (),
    samples: int = 10_000,
    seed: int = 1,
    target: float | None = None,
    exact: int = 10,
    workers: int | None = None,
    cluster: str | None = None,
    cluster_timeout_s: float = 10.0,
    progress: Progress | None = None,
    **options: Any,
) -> StudyResult:
    """Draw cranks made to a job's plan, and judge them.

    Parameters
    ----------
    job : path, Job or mapping
        Job, which is balanced first, the report of a balanced one, or a crank file with options for the job's
        keys. Files that a mapping names are relative to the working folder.
    samples : int
        Number of cranks to draw.
    seed : int
        Seed of the random numbers: the same seed draws the same cranks.
    target : float or None
        Smallest share of cranks within tolerance, above 0 to 1, with exit code 4 below it; None: not
        required, and advice is given for 0.95.
    exact : int
        Number of cranks that are also cut and measured, which checks the linear model.
    **options
        With a crank file in place of the job, keys of the job as for ``balance``.

    Returns
    -------
    StudyResult

    Raises
    ------
    UsageError
        If a count or the target is out of range.
    JobError
        If nothing has a ±, or the job is wrong.
    """
    from autobalance.studies.study.answer import ABOVE_OUTCOME, study_report, study_series
    from autobalance.studies.study.monte_carlo import Sampler, study_of
    from autobalance.studies.study.study_plan import studied_plan
    from autobalance.studies.workers import workers_of
    from autobalance.verbs.crank_job import is_crank, job_given

    started = time.perf_counter()
    _refuse(samples, seed, target, exact)
    if options or is_crank(job):
        job, settings = job_given("study", job, options, settings), ()
    with workers_of(workers, cluster, cluster_timeout_s) as pool:
        studied = studied_plan(job, crank, telling(progress), settings)
        plan = studied.plan
        sampler = Sampler(samples, seed, study_options(plan.job).sampling, exact)
        answer = study_of(plan, sampler, target, pool, progress or no_progress)
    missed = plan.result.outcome == ABOVE_OUTCOME or (
        target is not None and answer.found.probability_within < target
    )
    report = study_report(answer, seed, studied.report_sha256, time.perf_counter() - started)
    return StudyResult(report, study_series(answer), answer.shares, missed)


def _refuse(samples: int, seed: int, target: float | None, exact: int) -> None:
    for name, value, least in (("samples", samples, 1), ("seed", seed, 0), ("exact", exact, 0)):
        if value < least:
            raise UsageError(f"{name} is {value}; must be ≥ {least}")
    if target is not None and not 0.0 < target <= 1.0:
        raise UsageError(f"target is {target:g}; must be above 0 and at most 1")
