"""``ab.jobs``: the archive of a shop, from the reports of its jobs alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from autobalance.errors import FileError
from autobalance.value_classes import dataclass
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.studies.jobs.answer import JobsReport


@dataclass(frozen=True, eq=False, repr=False)
class JobsResult(VerbResult):
    """Jobs of a folder, and statistics of series."""

    content: JobsReport

    def text(self, units: str = "metric") -> str:
        """Return a line for each job, and the series."""
        from autobalance.report.display_units import ON_SCREEN
        from autobalance.studies.jobs.answer import jobs_text

        return jobs_text(self.content, ON_SCREEN[units])

    def files(self) -> Mapping[str, bytes]:
        """Return the jobs as CSV."""
        from autobalance.studies.jobs.answer import jobs_csv

        return {"jobs.csv": jobs_csv(self.content)}


def jobs(folder: str | Path = ".", *, find: str | None = None) -> JobsResult:
    """List the jobs whose reports lie in a folder or below it, with statistics of each engine.

    The reports are all that is read; an index beside them (``.autobalance-jobs.sqlite``) is made of them, so
    that each is read once, and may be deleted at any time.

    Parameters
    ----------
    folder : path
        Folder of results, with folders below it.
    find : str or None
        Text in customer, engine, serial, operator, note or path; None: all jobs.

    Returns
    -------
    JobsResult

    Raises
    ------
    FileError
        If the folder is missing.
    """
    from autobalance.studies.jobs.answer import JobsReport, series_of
    from autobalance.studies.jobs.archive import archive

    place = Path(folder)
    if not place.is_dir():
        raise FileError(f"{place} is not a folder; expected the folder of a shop's results")
    listed = archive(place)
    rows = [row for row in listed.rows if find is None or row.holds(find)]
    return JobsResult(
        JobsReport(folder=str(folder), find=find, jobs=rows, series=series_of(rows), warnings=listed.warnings)
    )
