"""The report of `jobs`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal, Self

from autobalance.declare import Angle, Count, NotNegative, Ordinal, Pair, Positive, record
from autobalance.report.records.head import Head
from autobalance.rigid_rotor.tolerance import Outcome
from autobalance.studies.archive import JobRow
from autobalance.studies.series import PlaneSeries, Series


@record
class ArchivedJob:
    """One crank's job with its last stage; ``share_*`` is the worst judged value over its permissible one."""

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

    @classmethod
    def of(cls, row: JobRow) -> Self:
        values = {key: value for key, value in vars(row).items() if key not in _OTHERWISE}
        return cls(**values, planes_before_g_mm=row.planes_before, planes_after_g_mm=row.planes_after)


_OTHERWISE = ("planes_before", "planes_after", "permissible_planes_g_mm", "searched")


@record
class SeriesPlane:
    """A plane over a series of cranks."""

    plane: str
    mean_before_g_mm: NotNegative
    mean_before_deg: Angle
    scatter_before_g_mm: NotNegative
    mean_after_g_mm: NotNegative
    scatter_after_g_mm: NotNegative
    capability: Annotated[float | None, "(permitted - mean left) / (3 standard deviations of what is left)"]
    drift_g_mm: Annotated[NotNegative | None, "between the means before of the two halves of the series"]
    drift_in_errors: Annotated[NotNegative | None, "the same over its standard error"]
    drifts: bool

    @classmethod
    def of(cls, plane: PlaneSeries) -> Self:
        return cls(**vars(plane), drifts=plane.drifts)


@record
class JobSeries:
    """Cranks of one engine."""

    engine: str
    jobs: Count
    within: Count
    planes: Sequence[SeriesPlane]

    @classmethod
    def of(cls, series: Series) -> Self:
        planes = [SeriesPlane.of(each) for each in series.planes]
        return cls(engine=series.engine, jobs=series.jobs, within=series.within, planes=planes)


@record
class JobsReport(Head):
    """The jobs whose reports lie in a folder, and statistics of each engine."""

    command: Literal["jobs"] = "jobs"
    folder: str
    find: str | None
    jobs: Sequence[ArchivedJob]
    series: Sequence[JobSeries]
    warnings: Sequence[str]
