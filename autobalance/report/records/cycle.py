"""The report of `cycle`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from autobalance.declare import ABSENT, INLINE, Absent, Positive, record
from autobalance.engine.cycle.figures import CycleSummary, PendulumFigures, SweepRow
from autobalance.machine_models.cycle_films import FilmTable
from autobalance.machine_models.flexible_figures import Flexible
from autobalance.report.records.head import Head, JobEcho


@record
class CycleReport(Head):
    """Gas pressure, torque, speed, loads, and what each balance factor costs."""

    command: Literal["cycle"] = "cycle"
    job_set: Sequence[str] | Absent = ABSENT
    input: JobEcho
    speed_rpm: Positive
    summary: Annotated[CycleSummary, INLINE]
    pendulum: PendulumFigures | None
    sweep: Sequence[SweepRow] | None
    films: FilmTable | None
    flexible: Flexible | Absent = ABSENT
    warnings: Sequence[str]
