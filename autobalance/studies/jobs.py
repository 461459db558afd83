"""``ab.jobs``: the archive of a shop, from the reports of its jobs alone."""

from __future__ import annotations

import csv
import io
import json
import math
import posixpath
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from autobalance.declare import UNWRITTEN, Angle, Count, NotNegative, Ordinal, Pair, Positive, derived, record
from autobalance.errors import AutobalanceError, FileError
from autobalance.report.display_units import DisplayUnits
from autobalance.report.records.answers import Head
from autobalance.report.records.balanced import BalancedReport
from autobalance.report.tables import table
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.types import Array
from autobalance.value_classes import dataclass
from autobalance.verbs.result import VerbResult
from autobalance.verification.report_file import read_report
from autobalance.wording import angle_deg, percent

# The reports below a folder, one row a crank: read from them alone, indexed so that each is read once.


INDEX = ".autobalance-jobs.sqlite"
"""It lies next to the results. Its content is read from the reports, and it may be deleted at any time."""
LAYOUT = 3
REPORT = "report.json"
OF_RUNS = ("balance", "recut")


@dataclass(frozen=True)
class ArchivedJob:
    """One crank's job, with its last stage; unbalance of the resultant, planes as [x, y] [g·mm].

    ``share_before`` and ``share_after`` are the worst judged unbalance over its permissible value.
    """

    report: str
    customer: str | None
    engine: str | None
    serial: str | None
    date: Annotated[str, "when the report's file was written"]
    stage: Ordinal
    before_g_mm: NotNegative
    after_g_mm: NotNegative
    permissible_g_mm: Positive
    share_before: NotNegative
    share_after: NotNegative
    place_before: Annotated[str, "of share_before: the resultant, or a plane"]
    place_after: str
    outcome: Outcome
    planes_before_g_mm: Mapping[str, Pair]
    planes_after_g_mm: Mapping[str, Pair]
    permissible_planes_g_mm: Annotated[Mapping[str, float], UNWRITTEN]
    searched: Annotated[str, UNWRITTEN]

    def holds(self, text: str) -> bool:
        """Return whether a text is in the header of the job, in any case."""
        return text.casefold() in self.searched.casefold()


@dataclass(frozen=True)
class Archive:
    """The jobs of a folder, in the order of their dates, and what could not be read, a line each."""

    rows: tuple[ArchivedJob, ...]
    warnings: tuple[str, ...]


def archive(folder: Path) -> Archive:
    """Return the jobs whose reports lie in a folder or below it, each with its last stage.

    What an index beside them has of reports that did not change since is not read again.
    """
    known = _index_of(folder)
    entries: dict[str, tuple[int, int, dict[str, Any] | None]] = {}
    warnings = []
    for path in sorted(folder.rglob(REPORT)):
        if not path.is_file():
            continue
        name, status = path.relative_to(folder).as_posix(), path.stat()
        size, changed = status.st_size, status.st_mtime_ns
        kept = known.get(name)
        if kept is not None and kept[:2] == (size, changed):
            entries[name] = kept
            continue
        try:
            values = read_report(path)
            entries[name] = size, changed, _entry(name, values, status.st_mtime)
        except AutobalanceError as error:
            warnings.append(f"{name} is left out: {error}")
        except (AttributeError, TypeError, ValueError):
            warnings.append(f"{name} is left out: it is not a report of balance or recut")
    if entries != known:
        _write_index(folder, entries)
    results = {name: entry for name, (_, _, entry) in entries.items() if entry is not None}
    rows = sorted(_last_stages(results), key=lambda row: (row.date, row.report))
    return Archive(tuple(rows), tuple(warnings))


def _entry(name: str, values: Mapping[str, Any], changed_s: float) -> dict[str, Any] | None:
    """Return the row of a report, with the first report of its crank; None if it is not a run's."""
    if values.get("command") not in OF_RUNS:
        return None
    report = BalancedReport.read(values)
    before, after, tolerance = report.initial, report.residual, report.tolerance
    before_worst, after_worst = tolerance.worst(before), tolerance.worst(after)
    header, stages = report.given.job, report.stages
    first = stages[0].report if stages else None
    row = ArchivedJob(
        name,
        header.customer,
        header.engine,
        report.serial or header.serial,
        datetime.fromtimestamp(changed_s).strftime("%Y-%m-%d %H:%M"),
        len(stages) or 1,
        before.magnitude_g_mm,
        after.magnitude_g_mm,
        tolerance.permissible_g_mm,
        before_worst[1] / before_worst[2],
        after_worst[1] / after_worst[2],
        before_worst[0],
        after_worst[0],
        report.outcome,
        {each.name: each.unbalance_g_mm for each in before.planes},
        {each.name: each.unbalance_g_mm for each in after.planes},
        {each.name: each.permissible_g_mm for each in tolerance.planes},
        "\n".join(map(str, [name, report.serial, *filter(None, (report.job.get("job") or {}).values())])),
    )
    of = name if first is None else (Path(name).parent / first).as_posix()
    return {"of": posixpath.normpath(of), "row": json.loads(json.dumps(asdict(row)))}


def _last_stages(entries: Mapping[str, dict[str, Any]]) -> Iterator[ArchivedJob]:
    """Yield the last stage of each crank, its before that of the first stage."""
    stages: dict[str, list[dict[str, Any]]] = {}
    for entry in entries.values():
        stages.setdefault(entry["of"], []).append(entry["row"])
    for rows in stages.values():
        rows.sort(key=lambda row: row["stage"])
        first, last = rows[0], rows[-1]
        header = {key: last[key] or first[key] for key in ("customer", "engine", "serial")}
        keys = ("before_g_mm", "share_before", "place_before", "planes_before_g_mm")
        before = {key: first[key] for key in keys}
        searched = "\n".join(row["searched"] for row in rows)
        yield ArchivedJob(**{**last, **header, **before, "searched": searched})


# --- the index ----------------------------------------------------------------------------------------------


def _index_of(folder: Path) -> dict[str, tuple[int, int, dict[str, Any] | None]]:
    """Return the entries of the index; none if there is no index, or none of ours."""
    path = folder / INDEX
    if not path.is_file():
        return {}
    try:
        with closing(sqlite3.connect(path)) as index:
            if index.execute("PRAGMA user_version").fetchone()[0] != LAYOUT:
                return {}
            rows = index.execute("SELECT report, size, changed_ns, entry FROM reports").fetchall()
        return {name: (size, changed, json.loads(entry)) for name, size, changed, entry in rows}
    except (sqlite3.Error, ValueError):
        return {}


def _write_index(folder: Path, entries: Mapping[str, tuple[int, int, dict[str, Any] | None]]) -> None:
    """Write the index again; a folder that nobody may write to goes without."""
    path = folder / INDEX
    with suppress(OSError, sqlite3.Error):
        path.unlink(missing_ok=True)
        with closing(sqlite3.connect(path)) as index:
            index.execute(f"PRAGMA user_version = {LAYOUT}")
            index.execute("CREATE TABLE reports (report TEXT PRIMARY KEY, size, changed_ns, entry)")
            rows = [(name, *changes, json.dumps(entry)) for name, (*changes, entry) in entries.items()]
            index.executemany("INSERT INTO reports VALUES (?, ?, ?, ?)", rows)
            index.commit()


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


# The public function.


@dataclass(frozen=True, eq=False, repr=False)
class JobsResult(VerbResult):
    """Jobs of a folder, and statistics of series."""

    content: JobsReport

    def text(self, units: str = "metric") -> str:
        """Return a line for each job, and the series."""
        from autobalance.report.display_units import ON_SCREEN

        return jobs_text(self.content, ON_SCREEN[units])

    def files(self) -> Mapping[str, bytes]:
        """Return the jobs as CSV."""
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
    place = Path(folder)
    if not place.is_dir():
        raise FileError(f"{place} is not a folder; expected the folder of a shop's results")
    listed = archive(place)
    rows = [row for row in listed.rows if find is None or row.holds(find)]
    return JobsResult(
        JobsReport(folder=str(folder), find=find, jobs=rows, series=series_of(rows), warnings=listed.warnings)
    )
