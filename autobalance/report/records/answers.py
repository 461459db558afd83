"""Head of every report, and the reports of `verify`, `init`, `sheet` and `calc`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import ABSENT, Absent, Count, Like, NotNegative, Positive, Sha256, record
from autobalance.report.records.job import Job
from autobalance.verification.claims import NotChecked
from autobalance.version import SCHEMA_VERSION, __version__

# Head of every report.


JobEcho = Annotated[Mapping[str, Any], Like(Job)]
"""A job as it was read, defaults filled in."""


@record
class Program:
    """The program that made the report."""

    version: str = __version__


@record
class WrittenFile:
    """A file that was written."""

    file: str
    sha256: Sha256


@record
class Head:
    """The keys that every report begins with."""

    schema_version: Literal[1] = SCHEMA_VERSION
    autobalance: Program = Program()
    command: str
    outputs: Annotated[Mapping[str, WrittenFile], "files of this run beside it, by name"] | Absent = ABSENT


@record
class JobReport(Head):
    """The head of a report on a job, with the keys of the job that were set from outside."""

    job: JobEcho
    job_set: Sequence[str] | Absent = ABSENT


# The reports of `verify`, `init`, `sheet` and `calc`.


@record
class VerifyReport(Head):
    """Whether a report's claims hold."""

    command: Literal["verify"] = "verify"
    report: str
    holds: bool
    within_tolerance: bool
    claims: Count
    residual_g_mm: NotNegative
    permissible_g_mm: Positive
    agreement: Annotated[NotNegative | None, "of two ways to measure, relative; null: measured one way"]
    not_checked: Sequence[NotChecked]
    warnings: Sequence[str]


@record
class SheetReport(Head):
    """The sheets that were drawn of a report."""

    command: Literal["sheet"] = "sheet"
    report: str
    corrections: Count
    outputs: Mapping[str, WrittenFile]


@record
class InitReport(Head):
    """The job that was written, and the values to fill in."""

    command: Literal["init"] = "init"
    crank: str | None
    job: Annotated[str | None, "null: the shop's own file was written"]
    shop: str | Absent = ABSENT
    fill_in: Sequence[str]


@record
class CalcReport(Head):
    """Result of a formula."""

    command: Literal["calc"] = "calc"
    name: str
    input: Mapping[str, str]
    result: Any
