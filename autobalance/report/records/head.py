"""Head of every report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from autobalance.declare import ABSENT, Absent, Like, Sha256, record
from autobalance.report.records.job import Job
from autobalance.version import SCHEMA_VERSION, __version__

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
