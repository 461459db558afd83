"""The report of `cycle`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Annotated, Any, Literal

from autobalance.declare import ABSENT, INLINE, Absent, Positive, Registered, record
from autobalance.engines.cycle.figures import CycleSummary, PendulumFigures, SweepRow
from autobalance.engines.cycle.films import FilmTable
from autobalance.engines.cycle.sections import cycle_section_types
from autobalance.report.records.answers import Head, JobEcho


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
    of_addons: Annotated[Mapping[str, Any], INLINE, Registered(cycle_section_types)] = field(
        default_factory=dict
    )
    warnings: Sequence[str]
