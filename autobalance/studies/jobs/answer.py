"""The report of `jobs`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from autobalance.declare import record
from autobalance.report.records.head import Head
from autobalance.studies.jobs.archive import ArchivedJob
from autobalance.studies.jobs.series import JobSeries


@record
class JobsReport(Head):
    """The jobs whose reports lie in a folder, and statistics of each engine."""

    command: Literal["jobs"] = "jobs"
    folder: str
    find: str | None
    jobs: Sequence[ArchivedJob]
    series: Sequence[JobSeries]
    warnings: Sequence[str]
