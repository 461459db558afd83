"""``compare``: every kind of correction and the useful mixes on one crank, like for like."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from autobalance import job as jobs
from autobalance.balancing.run import Compared, compare_job
from autobalance.correction import mixes
from autobalance.job import JobSource
from autobalance.runtime import Progress
from autobalance.value_classes import dataclass
from autobalance.verbs.balance import with_crank
from autobalance.verbs.crank_job import job_given, pressed_up_told
from autobalance.verbs.declaration import documented
from autobalance.verbs.engine_case import job_set
from autobalance.verbs.entry import Entries, entries
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.report.records.compare import CompareReport
    from autobalance.verbs.crank import Crank

READ_BEFORE = 0.1
"""Share of a usual comparison that reading and measuring take."""
GOOD_OUTCOMES = ("within_tolerance", "already_within_tolerance")


@dataclass(frozen=True, eq=False, repr=False)
class CompareResult(VerbResult):
    """One row for each kind and mix; those within tolerance are ranked, and one is recommended."""

    content: CompareReport

    @property
    def rows(self) -> Entries:
        """The rows, with the keys of the report."""
        return entries(self.report["rows"])

    @property
    def exit_code(self) -> int:
        """0 if some kind comes within tolerance (or no cut is needed), 4 if none does."""
        return 0 if any(row.outcome in GOOD_OUTCOMES for row in self.content.comparison.rows) else 4

    def text(self, units: str = "metric") -> str:
        """Return the blocks that the command prints."""
        from autobalance.report.balance.comparison import comparison_text
        from autobalance.report.display_units import ON_SCREEN

        return comparison_text(self.content.comparison, ON_SCREEN[units])

    def full_text(self, units: str = "metric") -> str:
        """Return the blocks with the whole reason of each kind that is above tolerance."""
        from autobalance.report.balance.comparison import comparison_text
        from autobalance.report.display_units import ON_SCREEN

        return comparison_text(self.content.comparison, ON_SCREEN[units], verbose=True)

    def page(self, units: str = "metric") -> bytes:
        """Return the comparison as a page for a browser."""
        from autobalance.report.balance.comparison import comparison_html
        from autobalance.report.display_units import ON_SCREEN
        from autobalance.report.page.templates import summary_page

        table = comparison_html(self.content.comparison, ON_SCREEN[units])
        return summary_page("Comparison", self.full_text(units), self.exit_code == 0, table)

    def _repr_html_(self) -> str:
        from autobalance.report.balance.comparison import comparison_html
        from autobalance.report.display_units import ON_SCREEN

        return comparison_html(self.content.comparison, ON_SCREEN["metric"])


@documented
def compare(
    job: JobSource,
    crank: Crank | None = None,
    *,
    settings: Sequence[str] = (),
    progress: Progress | None = None,
    **options: Any,
) -> CompareResult:
    """Balance one crank by every kind of correction and the useful mixes in turn; nothing is written.

    Parameters
    ----------
    job : Job, path or dict
        Job file, or a crank file with options for the job's keys. Each kind takes its limits from its own
        table there, or its defaults; ``method`` is not looked at.
    **options
        With a crank file in place of the job, keys of the job as for ``balance``.

    Raises
    ------
    AutobalanceError
        For anything wrong with the job or the crank.
    """
    return compared(job_given("compare", job, options, settings), crank, progress)


def compared(
    job: JobSource,
    crank: Crank | None,
    progress: Progress | None,
    done: Callable[[CompareResult], None] = lambda _: None,
) -> CompareResult:
    """Compare as ``compare`` does; ``done`` is called after each kind with the result so far."""
    from autobalance.report.balance.comparison import comparison
    from autobalance.report.records.compare import CompareReport

    whole_job = jobs.as_job(job)
    measured = None if crank is None else crank.measured
    of = whole_job if crank is None else with_crank(whole_job, crank)

    def result(some: Compared) -> CompareResult:
        report = comparison(str(of.path), some.tolerance, some.initial, some.rows, of.prefer)
        return CompareResult(CompareReport(comparison=report, warnings=some.warnings, **job_set(of)))

    with pressed_up_told(of):
        notify = telling(progress, _done_before())
        return result(compare_job(of, notify, measured, lambda some: done(result(some))))


def _done_before() -> tuple[tuple[str, float], ...]:
    """Return the share behind at the beginning of each kind and mix: longer names first."""
    every = ["+".join(names) for names in mixes()]
    shares = [
        (f"trying {name}", READ_BEFORE + (1.0 - READ_BEFORE) * k / len(every)) for k, name in enumerate(every)
    ]
    return tuple(sorted(shares, key=lambda each: -len(each[0])))
