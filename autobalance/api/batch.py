"""``ab.batch``: many jobs, one result row each, here or on a cluster, taken up again after a kill."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from autobalance.api.progress import Progress
from autobalance.api.result import Values, VerbResult, report_head
from autobalance.errors import AutobalanceError, FileError, one_line
from autobalance.report.files import Staging
from autobalance.version import __version__

if TYPE_CHECKING:
    from autobalance.job import Job
    from autobalance.job.batch_list import BatchList, BatchRow
    from autobalance.studies.workers import Done

ROWS = "rows"
LOST, FAILED = 1, 3
NUMBERS = (
    "mass_g", "initial_g_mm", "residual_g_mm", "permissible_g_mm", "worst_share", "removed_g", "cuts",
)  # fmt: skip
NOT_ALL_WITHIN = 4


class BatchResult(VerbResult):
    """One row for each job of a list."""

    @property
    def exit_code(self) -> int:
        """0 where all rows are within tolerance, else 4."""
        return 0 if self.report["within"] == self.report["rows"] else NOT_ALL_WITHIN

    def text(self, units: str = "metric") -> str:
        """Return the counts and the reasons as lines for people."""
        from autobalance.report.batch_files import batch_text

        return batch_text(self.report)


def batch(
    source: str | Path,
    output: str | Path,
    *,
    job: str | Path | None = None,
    settings: Sequence[str] = (),
    only: Sequence[str] = ("json",),
    fresh: bool = False,
    workers: int | None = None,
    cluster: str | None = None,
    cluster_timeout_s: float = 10.0,
    progress: Progress | None = None,
) -> BatchResult:
    """Balance every job of a list or a folder; rows that are done already are taken over.

    Parameters
    ----------
    source : path
        A list (CSV, workbook), a folder of jobs, or with ``job`` a folder of cranks.
    output : path
        Folder of the results, made where it is missing.
    job : path or None
        The job of all rows that name none.
    settings : sequence of str
        Keys to set in every job, ``["balance.factor=0.5"]``; a column of the list goes before them.
    only : sequence of str
        Pages wanted beside each solid, as for ``BalanceResult.write``.
    fresh : bool
        Forget what the folder holds of an earlier batch.
    workers : int or None
        Processes here; None: as many as there are cores.
    cluster : str or None
        Address of a Dask scheduler, whose workers are taken instead.
    cluster_timeout_s : float
        How long it may take to answer [s].
    progress : callable or None
        Told words and the share done; may raise to stop.

    Returns
    -------
    BatchResult
        Rows that fail are rows too, with their line.

    Raises
    ------
    JobError
        If the list is none.
    FileError
        If the folder is held by another batch, or the cluster does not answer.
    """
    from autobalance.job.batch_list import read_batch_list
    from autobalance.studies.journal import held
    from autobalance.studies.workers import workers_of

    started = time.perf_counter()
    folder = Path(output)
    listed = read_batch_list(Path(source), None if job is None else Path(job)).with_set(settings)
    with workers_of(workers, cluster, cluster_timeout_s, alone=False) as pool:
        _make(folder)
        with held(folder):
            run = _Run(folder, listed, tuple(only), progress)
            run.take_over(fresh=fresh)
            todo = run.tasks()
            for done in pool.run(balance_row, todo):
                run.finish(todo.rows[done.number], done)
            report = run.report(time.perf_counter() - started)
            run.write(report)
    return BatchResult(report)


def _make(folder: Path) -> None:
    try:
        (folder / ROWS).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(
            f"cannot make the folder {folder}: {(error.strerror or str(error)).lower()}"
        ) from None


# --- a row, on a worker -------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class RowTask:
    """What a worker needs for a row: the job, the bytes of its crank's file, and the pages wanted."""

    job: Job
    crank: bytes
    only: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class RowOutcome:
    """What became of a row: files by name, or the line of what is wrong."""

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
    started = _now()
    try:
        files, code, message = _balanced(task)
    except AutobalanceError as error:
        return RowOutcome(FAILED, {}, str(error), started, _now())
    except MemoryError:
        return RowOutcome(FAILED, {}, "not enough memory for this crank", started, _now())
    return RowOutcome(code, files, message, started, _now())


def _balanced(task: RowTask) -> tuple[Mapping[str, bytes], int, str]:
    from autobalance.api.balance import choice_of, run, staged
    from autobalance.api.crank import Crank
    from autobalance.runtime import Stopwatch

    crankshaft = task.job.crankshaft
    result = run(task.job, Crank(_recognised(task), crankshaft), lambda _words: None, Stopwatch())
    choice = choice_of(task.only, "A4", "metric", None)
    kept = _InMemory()
    staged(result, Path(), choice, lambda _words: None, kept)
    return kept.kept, result.exit_code, one_line(result.reason or "")


def _recognised(task: RowTask) -> Any:
    """Return the crank in the bytes of a file, not measured yet."""
    from autobalance.balancing.measured_crank import Crank as MeasuredCrank
    from autobalance.balancing.measured_crank import recognised
    from autobalance.rigid_rotor.moments import Moments
    from autobalance.solid.formats.read import source_of_bytes
    from autobalance.solid.formats.registry import name_of_ending

    crankshaft = task.job.crankshaft
    assert crankshaft.file is not None
    ending = crankshaft.file.suffix.lower().lstrip(".")
    try:
        source = source_of_bytes(
            task.crank,
            name_of_ending(ending),
            crankshaft.unit,
            crankshaft.body,
            pressed_up=not crankshaft.crankpin_in_file,
        )
        anatomy = recognised(source, crankshaft.overrides)
    except AutobalanceError as error:
        raise type(error)(f"{crankshaft.file}: {error}") from None
    return MeasuredCrank(source, anatomy, crankshaft.density_g_mm3, Moments.zero(), None)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


# --- the batch, on this machine -----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Todo:
    """A row to do: its job, the file of its crank, and its fingerprint."""

    row: BatchRow
    job: Job
    crank: Path
    fingerprint: str


class _Tasks(Sequence[RowTask]):
    """The tasks of rows; each crank is read when its task is wanted, not before."""

    def __init__(self, rows: Sequence[_Todo], only: tuple[str, ...]) -> None:
        self.rows, self._only = rows, only

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
        return RowTask(row.job, data, self._only)


class _Run:
    """A batch at work on its folder."""

    def __init__(
        self, folder: Path, listed: BatchList, only: tuple[str, ...], progress: Progress | None
    ) -> None:
        from autobalance.api.balance import choice_of

        choice_of(only, "A4", "metric", None)  # refuses unknown kinds before anything is run
        self.folder, self.listed, self.only, self._progress = folder, listed, only, progress
        self.lines: dict[str, Values] = {}
        self.taken_over = 0
        self._todo: list[_Todo] = []

    def take_over(self, *, fresh: bool) -> None:
        """Keep the rows that are done and whole, write down those that cannot be done, list the others."""
        from autobalance.studies.journal import read_journal, rewrite_journal

        old = {} if fresh else read_journal(self.folder)
        wrong: list[tuple[BatchRow, str, str]] = []
        for row in self.listed.rows:
            job, crank, digest, message = _read_row(row)
            fingerprint = _fingerprint(row, job, digest, self.only)
            line = old.get(row.name)
            if line is not None and line.get("fingerprint") == fingerprint and self._is_whole(row, line):
                self.lines[row.name] = {**line, "row": row.number}
                self.taken_over += 1
            elif job is None or crank is None:
                wrong.append((row, fingerprint, message))
            else:
                self._todo.append(_Todo(row, job, crank, fingerprint))
        rewrite_journal(self.folder, self.lines)
        self._clean()
        for row, fingerprint, message in wrong:
            self._forget_files(row)
            now = _now()
            self._write_line(row, FAILED, fingerprint, 1, "", now, now, message, {})
        self._tell()

    def tasks(self) -> _Tasks:
        """Return what workers are to do."""
        return _Tasks(self._todo, self.only)

    def finish(self, todo: _Todo, done: Done) -> None:
        """Put a row's files in place and write its line."""
        self._forget_files(todo.row)
        if done.lost:
            now = _now()
            message = f"its worker died on each of {done.attempt} tries"
            self._write_line(todo.row, LOST, todo.fingerprint, done.attempt, "", now, now, message, {})
        else:
            outcome: RowOutcome = done.value
            target = self.folder / ROWS / todo.row.name
            if outcome.files:
                with Staging([target]) as staging:
                    for name, data in outcome.files.items():
                        staging.add(target / name, data)
                    staging.commit()
            digests = {name: sha256(data).hexdigest() for name, data in outcome.files.items()}
            self._write_line(
                todo.row,
                outcome.exit_code,
                todo.fingerprint,
                done.attempt,
                done.worker,
                outcome.started,
                outcome.finished,
                outcome.message,
                digests,
            )
        self._tell()

    def _write_line(
        self,
        row: BatchRow,
        exit_code: int,
        fingerprint: str,
        attempt: int,
        worker: str,
        started: str,
        finished: str,
        message: str,
        files: Mapping[str, str],
    ) -> None:
        from autobalance.studies.journal import append_line

        line = {
            "row": row.number,
            "name": row.name,
            "exit_code": exit_code,
            "fingerprint": fingerprint,
            "try": attempt,
            "worker": worker,
            "started": started,
            "finished": finished,
            "message": message,
            "files": dict(files),
        }
        append_line(self.folder, line)
        self.lines[row.name] = line

    def _is_whole(self, row: BatchRow, line: Values) -> bool:
        """Tell whether the files of a row are those that its line says."""
        files = line.get("files")
        if not isinstance(files, dict) or (line.get("exit_code") in (0, NOT_ALL_WITHIN) and not files):
            return False
        folder = self.folder / ROWS / row.name
        try:
            return all(
                sha256((folder / name).read_bytes()).hexdigest() == digest for name, digest in files.items()
            )
        except OSError:
            return False

    def _forget_files(self, row: BatchRow) -> None:
        shutil.rmtree(self.folder / ROWS / row.name, ignore_errors=True)

    def _clean(self) -> None:
        """Take away what a killed batch left half-written."""
        for part in self.folder.glob(".*.part"):
            part.unlink(missing_ok=True)

    def _tell(self) -> None:
        if self._progress is not None:
            done, rows = len(self.lines), len(self.listed.rows)
            self._progress(f"{done} of {rows} rows done", done / rows)

    # --- results --------------------------------------------------------------------------------------------

    def report(self, seconds: float) -> Values:
        """Return what ``--json`` writes."""
        results = [self._result(row) for row in self.listed.rows]
        codes = [result["exit_code"] for result in results]
        return {
            **report_head("batch"),
            "rows": len(results),
            "within": codes.count(0),
            "above": codes.count(NOT_ALL_WITHIN),
            "failed": codes.count(FAILED),
            "lost": codes.count(LOST),
            "taken_over": self.taken_over,
            "results": results,
            "seconds": seconds,
        }

    def _result(self, row: BatchRow) -> Values:
        line = self.lines[row.name]
        known: Values = dict.fromkeys((*NUMBERS, "solid_sha256"))
        outcome = {LOST: "lost", FAILED: "error"}.get(line["exit_code"])
        if outcome is None:
            path = self.folder / ROWS / row.name / "report.json"
            values = json.loads(path.read_text(encoding="utf-8"))
            outcome, known = values["outcome"], _numbers(values)
        return {
            "row": row.number,
            "name": row.name,
            "job": row.job,
            "crank": row.crank,
            "exit_code": line["exit_code"],
            "outcome": outcome,
            "message": line["message"],
            **known,
            **dict(row.settings),
        }

    def write(self, report: Values) -> None:
        """Write the table as CSV, workbook and page."""
        from autobalance.report.batch_files import results_csv, results_workbook, summary_page

        with Staging([self.folder]) as staging:
            staging.add(self.folder / "results.csv", results_csv(report))
            staging.add(self.folder / "results.xlsx", results_workbook(report))
            staging.add(self.folder / "summary.html", summary_page(report))
            staging.commit()


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
        return job, None, None, f"{file} cannot be read: {(error.strerror or str(error)).lower()}"


def _fingerprint(row: BatchRow, job: Job | None, digest: str | None, only: tuple[str, ...]) -> str:
    """Return a digest of what a row's results depend on."""
    told = {
        "job": None if job is None else _without_file(job.raw),
        "row": [row.job, row.settings] if job is None else None,
        "crank": digest,
        "version": __version__,
        "only": only,
    }
    return sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()


def _without_file(raw: Mapping[str, Any]) -> Values:
    crankshaft = raw.get("crankshaft", {})
    kept = {key: value for key, value in crankshaft.items() if key != "file"} if crankshaft else {}
    return {**raw, "crankshaft": kept}


def _numbers(values: Values) -> Values:
    """Return what the table tells of a report."""
    tolerance, residual = values["tolerance"], values["residual"]
    shares = [residual["magnitude_g_mm"] / tolerance["permissible_g_mm"]]
    if tolerance["judge"] == "dynamic":
        shares += [
            plane["magnitude_g_mm"] / permitted["permissible_g_mm"]
            for plane, permitted in zip(residual["planes"], tolerance["planes"], strict=True)
        ]
    solid = values["outputs"]["solid"]
    return {
        "mass_g": values["crank"]["mass_g"],
        "initial_g_mm": values["initial"]["magnitude_g_mm"],
        "residual_g_mm": residual["magnitude_g_mm"],
        "permissible_g_mm": tolerance["permissible_g_mm"],
        "worst_share": max(shares),
        "removed_g": sum(cut["removed_mass_g"] for cut in values["corrections"]),
        "cuts": len(values["corrections"]),
        "solid_sha256": None if solid is None else solid["sha256"],
    }
