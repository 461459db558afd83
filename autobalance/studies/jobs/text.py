"""An archive of jobs as a table, its series, and as CSV."""

from __future__ import annotations

import csv
import io

from autobalance.report.display_units import DisplayUnits
from autobalance.report.tables import table
from autobalance.studies.jobs.answer import JobsReport
from autobalance.studies.jobs.series import JobSeries
from autobalance.wording import percent

VERDICTS = {
    "within_tolerance": "within",
    "already_within_tolerance": "within already",
    "above_tolerance": "ABOVE",
}
COLUMNS = (
    *("date", "customer", "engine", "serial", "stage", "before_g_mm", "after_g_mm", "permissible_g_mm"),
    *("share_before", "share_after", "place_before", "place_after", "outcome", "report"),
)


def jobs_text(report: JobsReport, units: DisplayUnits) -> str:
    """Return the jobs, one a line, the latest last, then the series."""
    if not report.jobs:
        what = "" if report.find is None else f" with {report.find!r}"
        return f"{report.folder}: no report of balance or recut{what} in this folder or below it"
    words = ("customer", "engine", "serial", "stage")
    rows: list[tuple[str, ...]] = [
        ("Date", *words, "before, of permitted", "after, of permitted", "verdict", "report")
    ]
    rows += [
        (
            job.date,
            *(each or "" for each in (job.customer, job.engine, job.serial)),
            str(job.stage),
            _share(job.share_before, job.place_before),
            _share(job.share_after, job.place_after),
            VERDICTS[job.outcome],
            job.report,
        )
        for job in report.jobs
    ]
    return "\n\n".join([table(rows), *(_series(each, units) for each in report.series)])


def _share(share: float, place: str) -> str:
    return f"{percent(share)} in {place.removeprefix('the ')}"


def _series(series: JobSeries, units: DisplayUnits) -> str:
    name = series.engine or "jobs that name no engine"
    head = f"{name}: {series.jobs} jobs, {series.within} within"
    rows: list[tuple[str, ...]] = [
        (head, "mean before", "at", "scatter", "mean after", "capability", "drift")
    ]
    of = units.of_unbalance
    for plane in series.planes:
        drift = "" if plane.drift_g_mm is None else of(plane.drift_g_mm)
        if plane.drift_in_errors is not None:
            drift += f" ({plane.drift_in_errors:.1f} standard errors)"
        rows.append(
            (
                f"  plane {plane.plane}",
                of(plane.mean_before_g_mm),
                f"{plane.mean_before_deg:.1f}°",
                of(plane.scatter_before_g_mm),
                of(plane.mean_after_g_mm),
                "" if plane.capability is None else f"{plane.capability:.2f}",
                drift,
            )
        )
    drifting = [plane.plane for plane in series.planes if plane.drifts]
    return table(rows) + (f"\n  plane {' and '.join(drifting)} drifts" if drifting else "")


def jobs_csv(report: JobsReport) -> bytes:
    """Return the jobs as CSV, one a row."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows([getattr(job, name) for name in COLUMNS] for job in report.jobs)
    return text.getvalue().encode()
