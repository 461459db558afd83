"""A batch at work on its folder: finished rows, rows computed now, and a row as a worker does it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from autobalance.errors import AutobalanceError, one_line, system_reason
from autobalance.report.files import Staging
from autobalance.runtime import Progress
from autobalance.studies.batch.answer import BatchReport, RowFigures, RowNumbers
from autobalance.studies.batch.journal import JOURNAL, JournalLine, append_line, read_journal, rewrite_journal
from autobalance.value_classes import dataclass
from autobalance.verbs.result import Values
from autobalance.version import __version__

if TYPE_CHECKING:
    from autobalance.job import Job
    from autobalance.studies.batch.input import BatchList, BatchRow
    from autobalance.studies.workers import Done


# A row of a batch, as a worker does it: bytes in, bytes out, no file touched.


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
    from autobalance.balancing.measured import Crank as MeasuredCrank
    from autobalance.balancing.measured_crank import recognised
    from autobalance.balancing.typed_effects import refuse_density, refuse_size
    from autobalance.rigid_rotor.unbalance import Moments
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


# A batch at work on its folder: finished rows, rows computed now, and the table's line of each row.


ROWS = "rows"
LOST, NOT_ALL_WITHIN = 1, 4
OUTCOMES: Mapping[int, Literal["lost", "error"]] = {LOST: "lost", FAILED_EXIT_CODE: "error"}
TABLES = ("results.csv", "results.xlsx", "summary.html")


@dataclass(frozen=True, eq=False)
class _Todo:
    """A row to do: its job, the file of its crank, and its fingerprint."""

    row: BatchRow
    job: Job
    crank: Path
    fingerprint: str


class _Tasks(Sequence[RowTask]):
    """The tasks of rows; each crank is read when its task is wanted, not before."""

    def __init__(self, rows: Sequence[_Todo], only: tuple[str, ...], folder: Path) -> None:
        self.rows, self._only, self._folder = rows, only, folder.resolve() / ROWS

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, place: int) -> RowTask: ...

    @overload
    def __getitem__(self, place: slice) -> Sequence[RowTask]: ...

    def __getitem__(self, place: int | slice) -> RowTask | Sequence[RowTask]:
        if isinstance(place, slice):
            return [self[number] for number in range(*place.indices(len(self)))]
        row = self.rows[place]
        try:
            data = row.crank.read_bytes()
        except OSError:
            data = b""  # it was there a moment ago; the row will say that it is empty
        job = replace(row.job, path=row.job.path.resolve())
        return RowTask(job, data, self._only, row.crank.resolve(), self._folder / row.row.name)


class BatchRun:
    """A batch at work on its folder."""

    def __init__(
        self, folder: Path, listed: BatchList, only: tuple[str, ...], progress: Progress | None
    ) -> None:
        from autobalance.report.bundle import choice_of

        choice_of(only, "A4", "metric")  # refuses unknown kinds before anything is run
        self.folder, self.listed, self.only, self._progress = folder, listed, only, progress
        self.lines: dict[str, JournalLine] = {}
        self.taken_over = 0
        self._todo: list[_Todo] = []

    def take_over(self, *, fresh: bool) -> None:
        """Keep the rows that are done and whole, write down those that cannot be done, list the others."""
        if fresh:
            self._forget_everything()
        old = read_journal(self.folder)
        wrong: list[tuple[BatchRow, str, str]] = []
        for row in self.listed.rows:
            job, crank, digest, message = _read_row(row)
            fingerprint = _fingerprint(row, job, digest, self.only)
            line = old.get(row.name)
            if line is not None and line.fingerprint == fingerprint and self._is_whole(row, line):
                self.lines[row.name] = replace(line, row=row.number)
                self.taken_over += 1
            elif job is None or crank is None:
                wrong.append((row, fingerprint, message))
            else:
                self._todo.append(_Todo(row, job, crank, fingerprint))
        rewrite_journal(self.folder, self.lines.values())
        self._clean()
        for row, fingerprint, message in wrong:
            self._forget_files(row)
            self._write_line(_undone(row, FAILED_EXIT_CODE, fingerprint, 1, message))
        self._report_progress()

    def tasks(self) -> _Tasks:
        return _Tasks(self._todo, self.only, self.folder)

    def finish(self, todo: _Todo, done: Done) -> None:
        """Put a row's files in place and write its line."""
        self._forget_files(todo.row)
        if done.lost:
            message = f"its worker died on each of {done.attempt} tries"
            self._write_line(_undone(todo.row, LOST, todo.fingerprint, done.attempt, message))
        else:
            outcome: RowOutcome = done.value
            target = self.folder / ROWS / todo.row.name
            if outcome.files:
                with Staging([target]) as staging:
                    for name, data in outcome.files.items():
                        staging.add(target / name, data)
                    staging.commit()
            self._write_line(
                JournalLine(
                    row=todo.row.number,
                    name=todo.row.name,
                    exit_code=outcome.exit_code,
                    fingerprint=todo.fingerprint,
                    try_=done.attempt,
                    worker=done.worker,
                    started=outcome.started,
                    finished=outcome.finished,
                    message=outcome.message,
                    files={name: sha256(data).hexdigest() for name, data in outcome.files.items()},
                )
            )
        self._report_progress()

    def _write_line(self, line: JournalLine) -> None:
        append_line(self.folder, line)
        self.lines[line.name] = line

    def _is_whole(self, row: BatchRow, line: JournalLine) -> bool:
        """Return whether the files of a row are those listed in its line."""
        if line.exit_code in (0, NOT_ALL_WITHIN) and not line.files:
            return False
        folder = self.folder / ROWS / row.name
        try:
            return all(
                sha256((folder / name).read_bytes()).hexdigest() == digest
                for name, digest in line.files.items()
            )
        except OSError:
            return False

    def _forget_files(self, row: BatchRow) -> None:
        shutil.rmtree(self.folder / ROWS / row.name, ignore_errors=True)

    def _forget_everything(self) -> None:
        """Take away what earlier batches have written."""
        for name in (*TABLES, JOURNAL):
            (self.folder / name).unlink(missing_ok=True)
        shutil.rmtree(self.folder / ROWS, ignore_errors=True)

    def _clean(self) -> None:
        """Take away what a killed batch left half-written."""
        for part in self.folder.glob(".*.part"):
            part.unlink(missing_ok=True)

    def _report_progress(self) -> None:
        if self._progress is not None:
            done, rows = len(self.lines), len(self.listed.rows)
            self._progress(f"{done} of {rows} rows done", done / rows)

    # --- results --------------------------------------------------------------------------------------------

    def report(self, seconds: float) -> BatchReport:
        results = [self._result(row) for row in self.listed.rows]
        codes = [result.exit_code for result in results]
        return BatchReport(
            rows=len(results),
            within=codes.count(0),
            above=codes.count(NOT_ALL_WITHIN),
            failed=codes.count(FAILED_EXIT_CODE),
            lost=codes.count(LOST),
            taken_over=self.taken_over,
            results=results,
            seconds=seconds,
        )

    def _result(self, row: BatchRow) -> RowFigures:
        line = self.lines[row.name]
        outcome, numbers = OUTCOMES.get(line.exit_code), RowNumbers()
        if outcome is None:
            path = self.folder / ROWS / row.name / "report.json"
            values = json.loads(path.read_text(encoding="utf-8"))
            outcome, numbers = values["outcome"], _numbers(values)
        return RowFigures(
            row=row.number,
            name=row.name,
            job=row.job,
            crank=row.crank,
            exit_code=line.exit_code,
            outcome=outcome,
            message=line.message,
            numbers=numbers,
            settings=dict(row.settings),
        )

    def write(self, report: BatchReport) -> None:
        """Write the table as CSV, workbook and page."""
        from autobalance.studies.batch.answer import results_csv, results_workbook, summary_page

        with Staging([self.folder]) as staging:
            staging.add(self.folder / "results.csv", results_csv(report))
            staging.add(self.folder / "results.xlsx", results_workbook(report))
            staging.add(self.folder / "summary.html", summary_page(report))
            staging.commit()


def _undone(row: BatchRow, exit_code: int, fingerprint: str, attempt: int, message: str) -> JournalLine:
    """Return the line of a row that cannot be done, or whose worker died."""
    at = now()
    return JournalLine(
        row=row.number,
        name=row.name,
        exit_code=exit_code,
        fingerprint=fingerprint,
        try_=attempt,
        worker="",
        started=at,
        finished=at,
        message=message,
        files={},
    )


def _read_row(row: BatchRow) -> tuple[Job | None, Path | None, str | None, str]:
    """Return a row's job, the file of its crank and that file's digest, or the line of what is wrong."""
    try:
        job = row.read()
    except AutobalanceError as error:
        return None, None, None, str(error)
    file = job.crankshaft.file
    if file is None:
        return job, None, None, f"{row.job_file.name}: crankshaft.file is missing"
    try:
        return job, file, sha256(file.read_bytes()).hexdigest(), ""
    except FileNotFoundError:
        return job, None, None, f"{file} does not exist"
    except OSError as error:
        return job, None, None, f"{file} cannot be read: {system_reason(error)}"


def _fingerprint(row: BatchRow, job: Job | None, digest: str | None, only: tuple[str, ...]) -> str:
    """Return a digest of what a row's results depend on."""
    inputs = {
        "job": None if job is None else _without_file(job.raw),
        "row": [row.job, row.settings] if job is None else None,
        "crank": digest,
        "version": __version__,
        "only": only,
    }
    return sha256(json.dumps(inputs, sort_keys=True, default=str).encode()).hexdigest()


def _without_file(raw: Mapping[str, Any]) -> Values:
    crankshaft = raw.get("crankshaft", {})
    kept = {key: value for key, value in crankshaft.items() if key != "file"} if crankshaft else {}
    return {**raw, "crankshaft": kept}


def _numbers(values: Values) -> RowNumbers:
    """Return a report's row of the table."""
    from autobalance.declare import present
    from autobalance.report.records.balanced import BalancedReport

    report = BalancedReport.read(values)
    _, worst_g_mm, permissible_g_mm = report.tolerance.worst(report.residual)
    solid = present(report.written.solid)
    return RowNumbers(
        mass_g=report.crank.body.mass_g,
        initial_g_mm=report.initial.magnitude_g_mm,
        residual_g_mm=report.residual.magnitude_g_mm,
        permissible_g_mm=report.tolerance.permissible_g_mm,
        worst_share=worst_g_mm / permissible_g_mm,
        removed_g=sum(cut.removed_mass_g for cut in report.corrections),
        cuts=len(report.corrections),
        solid_sha256=None if solid is None else solid.sha256,
    )
