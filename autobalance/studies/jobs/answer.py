"""The report of `jobs`: an archive as a table, and its series."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np

from autobalance.declare import Angle, Count, NotNegative, derived, record
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.answers import Head
from autobalance.report.tables import table
from autobalance.studies.jobs.archive import ArchivedJob
from autobalance.types import Array
from autobalance.value_classes import dataclass
from autobalance.wording import angle_deg, percent

# Statistics of cranks of one kind that were balanced one after another.


LEAST_DRIFT = 3.0
"""Standard errors by which the means of two halves of a series must differ to be no chance."""
LEAST_JOBS = 2


@dataclass(frozen=True)
class SeriesPlane:
    """A plane over a series: mean and scatter of the cranks as they come and as they go.

    The mean before is a vector, what all of them share; the mean after is of the magnitudes left. A scatter
    is the standard deviation of x and of y, both together. ``capability`` is None if nothing scatters,
    the drift of fewer than four cranks.
    """

    plane: str
    mean_before_g_mm: NotNegative
    mean_before_deg: Angle
    scatter_before_g_mm: NotNegative
    mean_after_g_mm: NotNegative
    scatter_after_g_mm: NotNegative
    capability: Annotated[
        float | None, "(permitted - mean residual) / (3 standard deviations of the residual)"
    ]
    drift_g_mm: Annotated[NotNegative | None, "between the means before of the two halves of the series"]
    drift_in_errors: Annotated[NotNegative | None, "the same over its standard error"]

    @derived
    def drifts(self) -> bool:
        return self.drift_in_errors is not None and self.drift_in_errors >= LEAST_DRIFT


@dataclass(frozen=True)
class JobSeries:
    """Cranks of one engine, in the order of their dates."""

    engine: str
    jobs: Count
    within: Count
    planes: tuple[SeriesPlane, ...]


def series_of(rows: Sequence[ArchivedJob]) -> tuple[JobSeries, ...]:
    """Return the statistics of each engine with two jobs or more."""
    by_engine: dict[str, list[ArchivedJob]] = {}
    for row in rows:
        by_engine.setdefault(row.engine or "", []).append(row)
    return tuple(
        JobSeries(engine, len(jobs), sum("within" in each.outcome for each in jobs), _planes(jobs))
        for engine, jobs in sorted(by_engine.items())
        if len(jobs) >= LEAST_JOBS
    )


def _planes(jobs: Sequence[ArchivedJob]) -> tuple[SeriesPlane, ...]:
    first = jobs[0].planes_before_g_mm
    names = [name for name in first if all(name in each.planes_before_g_mm for each in jobs)]
    return tuple(
        plane_series(
            name,
            np.array([each.planes_before_g_mm[name] for each in jobs]),
            np.array([each.planes_after_g_mm[name] for each in jobs]),
            min(each.permissible_planes_g_mm.get(name, math.inf) for each in jobs),
        )
        for name in names
    )


def plane_series(name: str, before: Array, after: Array, permissible_g_mm: float) -> SeriesPlane:
    """Return the statistics of one plane; ``before`` and ``after`` (n, 2) are vectors [g·mm]."""
    mean, left = before.mean(axis=0), np.hypot(*after.T)
    spread = float(left.std(ddof=1))
    capable = spread > 0.0 and math.isfinite(permissible_g_mm)
    drift = _drift(before)
    return SeriesPlane(
        plane=name,
        mean_before_g_mm=float(np.hypot(*mean)),
        mean_before_deg=angle_deg(mean),
        scatter_before_g_mm=_scatter(before),
        mean_after_g_mm=float(left.mean()),
        scatter_after_g_mm=_scatter(after),
        capability=(permissible_g_mm - float(left.mean())) / (3.0 * spread) if capable else None,
        drift_g_mm=None if drift is None else drift[0],
        drift_in_errors=None if drift is None else drift[1],
    )


def _scatter(vectors: Array) -> float:
    off = vectors - vectors.mean(axis=0)
    return math.sqrt(float((off**2).sum()) / (2 * (len(vectors) - 1)))


def _drift(vectors: Array) -> tuple[float, float | None] | None:
    """Return the shift of the mean from the first half to the second, and that over its standard error."""
    if len(vectors) < 4:
        return None
    first, second = np.array_split(vectors, 2)
    way = float(np.hypot(*(second.mean(axis=0) - first.mean(axis=0))))
    inside = math.sqrt(
        sum((len(each) - 1) * _scatter(each) ** 2 for each in (first, second)) / (len(vectors) - 2)
    )
    error = inside * math.sqrt(1.0 / len(first) + 1.0 / len(second))
    return way, way / error if error > 0.0 else None


# The report of `jobs`.


@record
class JobsReport(Head):
    """The jobs whose reports lie in a folder, and statistics of each engine."""

    command: Literal["jobs"] = "jobs"
    folder: str
    find: str | None
    jobs: Sequence[ArchivedJob]
    series: Sequence[JobSeries]
    warnings: Sequence[str]


# An archive of jobs as a table, its series, and as CSV.


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
