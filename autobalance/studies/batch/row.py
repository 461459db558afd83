"""A row of a batch, as a worker does it: bytes in, bytes out, no file touched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.errors import AutobalanceError, one_line
from autobalance.report.files import Staging

if TYPE_CHECKING:
    from autobalance.job import Job

FAILED_EXIT_CODE = 3


@dataclass(frozen=True, eq=False)
class RowTask:
    """Input of a worker for a row: the job, the bytes of its crank's file, and the pages wanted.

    ``file`` is where the crank came from and ``folder`` where the results will be, both absolute on the
    machine that asks: a worker may have another working folder.
    """

    job: Job
    crank: bytes
    only: tuple[str, ...]
    file: Path
    folder: Path


@dataclass(frozen=True, eq=False)
class RowOutcome:
    """End of a row: files by name, or the line of its error."""

    exit_code: int
    files: Mapping[str, bytes]
    message: str
    started: str
    finished: str


class _InMemory(Staging):
    """Takes files as ``Staging`` does, and keeps them."""

    def __init__(self) -> None:
        super().__init__([])
        self.kept: dict[str, bytes] = {}

    def add(self, path: Path, data: bytes) -> None:
        """Keep a file."""
        self.kept[path.name] = data


def balance_row(task: RowTask) -> RowOutcome:
    """Balance one row's crank; touches no file."""
    started = now()
    try:
        files, code, message = _balanced(task)
    except AutobalanceError as error:
        return RowOutcome(FAILED_EXIT_CODE, {}, str(error), started, now())
    except MemoryError:
        return RowOutcome(FAILED_EXIT_CODE, {}, "not enough memory for this crank", started, now())
    return RowOutcome(code, files, message, started, now())


def _balanced(task: RowTask) -> tuple[Mapping[str, bytes], int, str]:
    from autobalance.report.bundle import choice_of
    from autobalance.runtime import Stopwatch
    from autobalance.verbs.balance import run
    from autobalance.verbs.crank import Crank

    crankshaft = replace(task.job.crankshaft, file=task.file)
    result = run(task.job, Crank(_recognised(task), crankshaft), lambda _words: None, Stopwatch())
    choice = choice_of(task.only, "A4", "metric")
    kept = _InMemory()
    result.staged(task.folder, choice, lambda _words: None, kept)
    return kept.kept, result.exit_code, one_line(result.reason or "")


def _recognised(task: RowTask) -> Any:
    """Return the crank in the bytes of a file, not measured yet."""
    from autobalance.balancing.crank_size import refuse_density, refuse_size
    from autobalance.balancing.measured import Crank as MeasuredCrank
    from autobalance.balancing.measured_crank import recognised
    from autobalance.rigid_rotor.moments import Moments
    from autobalance.solid.formats.read import source_of_bytes
    from autobalance.solid.formats.registry import name_of_ending

    crankshaft = task.job.crankshaft
    assert crankshaft.file is not None
    refuse_density(crankshaft)
    ending = crankshaft.file.suffix.lower().lstrip(".")
    try:
        source = source_of_bytes(
            task.crank,
            name_of_ending(ending),
            crankshaft.unit,
            crankshaft.body,
            pressed_up=not crankshaft.crankpin_in_file,
            holes=crankshaft.holes,
        )
        refuse_size(source, "the solid")
        anatomy = recognised(source, crankshaft.overrides)
    except AutobalanceError as error:
        raise type(error)(f"{crankshaft.file}: {error}") from None
    return MeasuredCrank(source, anatomy, crankshaft.density_g_mm3, Moments.zero(), None)


def now() -> str:
    """Return the time as the journal has it."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")
