"""Runs of a project: waiting, running in separate processes, done, failed or cancelled."""

from __future__ import annotations

import contextlib
import hashlib
import json
import multiprocessing
import os
import re
import secrets
import signal
import sys
import threading
import time
import tomllib
from dataclasses import field
from datetime import UTC, datetime
from functools import cached_property
from typing import TYPE_CHECKING, Any

from autobalance import registry
from autobalance.browser.guard import jsonable
from autobalance.browser.opening import crank_of, job_of, job_of_crank
from autobalance.browser.project import ABOVE_EXIT_CODE, APP_FOLDER, RUN_ID, RUNS, STATE, Project
from autobalance.browser.work import SHEET, nothing, work
from autobalance.errors import AutobalanceError
from autobalance.job.from_options import Difference, differences
from autobalance.paper.verb import DONE
from autobalance.runtime import held_signals
from autobalance.toml_files.document import toml_text
from autobalance.value_classes import dataclass

if TYPE_CHECKING:
    from collections.abc import Iterator
    from multiprocessing.connection import Connection
    from multiprocessing.context import ForkServerContext, SpawnContext
    from multiprocessing.process import BaseProcess
    from pathlib import Path

REPORT = "report.json"
GRACE_S = 1.0
"""Time for a process to end before it is killed [s]."""
ENDED_STATES = ("done", "failed", "cancelled")
MOST_CHANGES = 20
"""Changed keys of the job that a run lists."""
OF_PAPERS = ("job", "shop.name", "shop.logo", "shop.units")
"""Keys and tables of a job that appear on sheets only: after a change a result still belongs to the job."""
OF_LOADS = (
    "engine.rod_length_mm",
    "engine.layout.bank_deg",
    "engine.layout.rod_pitch_mm",
    "engine.layout.offset_mm",
    "engine.throw.bank_deg",
    "engine.rod.big_end_g",
    "engine.rod.small_end_g",
    "engine.rod.inertia_kg_mm2",
    "shafts",
    *registry.JOB_TABLES,
)
"""Keys and tables that change loads and no cut: no plan reads them, nor the tables of add-ons."""
CUTTING = ("balance", "recut", "compare")
"""Verbs that plan cuts."""
STAGES = ("balance", "recut")
"""Verbs whose result is a stage of a crank."""
PRELOADED_MODULES = (
    "autobalance.browser.preload",
    "PIL.ImageDraw",
    "ezdxf",
    "reportlab.platypus",
    "xlsxwriter",
)
"""Modules that runs need; missing ones are skipped."""


@dataclass
class Run:
    """One command on one request."""

    id: str
    verb: str
    asked: dict[str, Any]
    state: str = "waiting"
    share: float = 0.0
    words: str = "waiting"
    exit_code: int | None = None
    error: str | None = None
    started: float = field(default_factory=time.time)

    @cached_property
    def job(self) -> dict[str, Any] | None:
        """The requested job, as a file would hold it; None if the run had no separate job."""
        job = self.asked.get("job")
        try:
            return tomllib.loads(toml_text(job)) if isinstance(job, dict) else None
        except (AutobalanceError, ValueError):
            return None


class Runs:
    """All runs of a project; at most one a processor at a time."""

    def __init__(self, project: Project, memory_mb: int) -> None:
        """Take up the runs that the project's folder holds."""
        self._project, self._memory_mb = project, memory_mb
        self._places = threading.Semaphore(max(1, os.cpu_count() or 1))
        self._lock, self._sheets = threading.Lock(), threading.Lock()
        self._runs: dict[str, Run] = {}
        self._processes: dict[str, BaseProcess] = {}
        self._threads: list[threading.Thread] = []
        self._loading, self._context = threading.Lock(), processes()
        self._closed = self._loaded = False
        self.take_up()
        for folder in (project.folder / APP_FOLDER).iterdir():
            if RUN_ID.fullmatch(folder.name) and folder.name not in self._runs:
                project.forget(folder.name)

    def start(self, verb: str, request: dict[str, Any]) -> str:
        """Begin a run; return its id."""
        run = Run(secrets.token_hex(6), verb, request)
        with self._lock:
            self._runs[run.id] = run
        thread = threading.Thread(target=self._go, args=(run,), daemon=True)
        self._threads.append(thread)
        thread.start()
        return run.id

    def all(self) -> list[dict[str, Any]]:
        """Return every run, the latest last."""
        with self._lock:
            runs = sorted(self._runs.values(), key=lambda run: run.started)
        jobs: dict[str | None, dict[str, Any] | None] = {}
        return [self._state(run, jobs) for run in runs]

    def state_of(self, run_id: str) -> dict[str, Any] | None:
        """Return one run; None if it is unknown."""
        run = self._runs.get(run_id)
        return None if run is None else self._state(run, {})

    def asked(self, run_id: str) -> dict[str, Any] | None:
        """Return the request of a run; None if there is no such run."""
        run = self._runs.get(run_id)
        return None if run is None else run.asked

    def job(self, run_id: str) -> dict[str, Any] | None:
        """Return the job that made a run's result; None if the run or its job is unknown."""
        run = self._runs.get(run_id)
        return None if run is None else self._made_of(run)

    def cancel(self, run_id: str) -> bool:
        """End a run and remove its files; False if it is unknown."""
        run = self._runs.get(run_id)
        if run is None:
            return False
        with self._lock:
            if run.state in ENDED_STATES:
                return True
            run.state, run.words = "cancelled", "cancelled"
            process = self._processes.get(run_id)
        _end(process)
        self._project.forget(run_id)
        return True

    def delete(self, run_id: str) -> bool:
        """Remove a run with its files; False if it is unknown."""
        if not self.cancel(run_id):
            return False
        with self._lock:
            self._runs.pop(run_id, None)
        self._project.forget(run_id)
        return True

    def close(self) -> None:
        """End all work; no process is left."""
        self._closed = True
        for run_id in list(self._runs):
            self.cancel(run_id)
        if sys.platform != "win32":
            end_preloaded()
        for thread in self._threads:
            thread.join(timeout=3.0)

    def sheet_with_ticks(self, run_id: str) -> Path | None:
        """Return the shop sheet of a result with the cuts that are done; None where none is."""
        ticked = self._project.result(run_id, DONE)
        if ticked is None or not json.loads(ticked.read_text(encoding="utf-8")):
            return None
        with self._sheets:
            sheet = self._project.own(run_id, SHEET)
            if sheet is None or sheet.stat().st_mtime_ns <= ticked.stat().st_mtime_ns:
                if sheet is not None:
                    sheet.unlink()  # older ticks are not shown where it cannot be drawn
                self._aside("sheet", run_id)
        return self._project.own(run_id, SHEET)

    def _aside(self, verb: str, run_id: str) -> None:
        """Run a command on a result in a separate process, with a limit to its memory, to its end."""
        self._load()
        process, ours, theirs = self._process(verb, {}, run_id)
        process.start()
        theirs.close()
        with contextlib.suppress(EOFError, OSError):
            while ours.recv()[0] == "progress":
                pass
        process.join()

    def _process(
        self, verb: str, asked: dict[str, Any], run_id: str
    ) -> tuple[BaseProcess, Connection, Connection]:
        """Return a process that is not started, and the two ends of its pipe: ours and its own."""
        ours, theirs = self._context.Pipe(duplex=False)
        project = self._project
        places = (project.folder, project.run_folder(run_id), project.own_folder(run_id))
        arguments = (verb, asked, tuple(map(str, places)), self._memory_mb, theirs)
        return self._context.Process(target=work, args=arguments, daemon=True), ours, theirs

    def prepare(self) -> None:
        """Load the modules of runs before the first is requested."""
        if not self._loaded:
            thread = threading.Thread(target=self._load, daemon=True)
            self._threads.append(thread)
            thread.start()

    def _load(self) -> None:
        """Begin the process that runs are copies of, once; return when it has loaded all."""
        _deaf_to_ctrl_c()
        with self._loading:
            if self._loaded or self._closed:
                return
            try:
                self._context.Process(target=nothing, daemon=True).start()
            except (EOFError, OSError):  # ended while it loads; or the name of its socket is too long here
                self._context = multiprocessing.get_context("spawn")
            self._loaded = True

    def take_up(self) -> None:
        """Find the runs of before and results put here by hand; what was cut off in the middle goes."""
        for folder in sorted((self._project.folder / RUNS).iterdir()):
            if not RUN_ID.fullmatch(folder.name) or folder.is_symlink() or folder.name in self._runs:
                continue
            run = _kept_run(self._project, folder.name)
            if run is None:
                self._project.forget(folder.name)
            else:
                self._runs[run.id] = run

    def _made_of(self, run: Run) -> dict[str, Any] | None:
        """Return the job behind a run: its own, or that of the run it continues."""
        return next((each.job for each in self._course(run) if each.job is not None), None)

    def _course(self, run: Run) -> list[Run]:
        """Return a run, the one that it continues, and so on; the first stage last."""
        course = [run]
        while (earlier := self._runs.get(str(course[-1].asked.get("run")))) and earlier not in course:
            course.append(earlier)
        return course

    def _state(self, run: Run, jobs: dict[str | None, dict[str, Any] | None]) -> dict[str, Any]:
        """Return a run as the page has it; ``changes`` are the later differences of its crank's own job.

        ``jobs`` are the jobs of cranks that were read so far; this one's is added.
        """
        made_of = self._made_of(run)
        crank = None if made_of is None else crank_of(made_of)
        if crank not in jobs:
            jobs[crank] = job_of(self._project) if crank is None else job_of_crank(self._project, crank)
        job = jobs[crank]
        changes = [] if made_of is None or job is None else _changes(run.verb, made_of, job)
        folder = self._project.run_folder(run.id)
        whole = run.state == "done" and folder.is_dir()
        return {
            "id": run.id,
            "verb": run.verb,
            "state": run.state,
            "share": run.share,
            "words": run.words,
            "exit_code": run.exit_code,
            "error": run.error,
            "started": datetime.fromtimestamp(run.started, UTC).isoformat(timespec="seconds"),
            "crank": crank,
            "stage": sum(each.verb in STAGES for each in self._course(run)),
            "job_sha256": None if made_of is None else _fingerprint(made_of),
            "job_changed": None if made_of is None or job is None else bool(changes),
            "changes": jsonable([each._asdict() for each in changes[:MOST_CHANGES]]),
            "files": sorted(_written(folder)) if whole else [],
        }

    def _go(self, run: Run) -> None:
        with self._places:
            with self._lock:
                if self._closed or run.state != "waiting":
                    return
                run.state, run.words = "running", "starting"
            self._load()
            process, ours, theirs = self._process(run.verb, run.asked, run.id)
            with self._lock:
                if run.state != "running":
                    return
                process.start()
                self._processes[run.id] = process
            theirs.close()
            self._listen(run, ours)
            process.join()
            self._finish(run)

    def _listen(self, run: Run, pipe: Connection) -> None:
        """Take in what the process sends until it ends."""
        while True:
            try:
                kind, *rest = pipe.recv()
            except (EOFError, OSError):
                return
            with self._lock:
                if run.state != "running":
                    continue
                if kind == "progress":
                    run.words, run.share = rest[0], max(run.share, float(rest[1]))
                elif kind == "done":
                    run.exit_code = rest[0]
                else:
                    run.exit_code, run.error = rest

    def _finish(self, run: Run) -> None:
        with self._lock:
            self._processes.pop(run.id, None)
            if run.state == "running":
                if run.exit_code is None:
                    run.exit_code, run.error = 1, "the work ended without a word: out of memory?"
                run.state = "failed" if run.error is not None else "done"
                run.share = 1.0 if run.state == "done" else run.share
                run.words = run.state
        if run.state == "done":
            own = self._project.own_folder(run.id)
            own.mkdir(parents=True, exist_ok=True)
            kept = {"verb": run.verb, "exit_code": run.exit_code, "started": run.started, "asked": run.asked}
            (own / STATE).write_text(json.dumps(kept), encoding="utf-8")
        elif run.state == "cancelled":
            self._project.forget(run.id)


def _written(folder: Path) -> Iterator[str]:
    """Yield the names of the files that a command wrote into a result's folder."""
    return (path.name for path in folder.iterdir() if path.is_file() and path.name != DONE)


def _changes(verb: str, was: dict[str, Any], now: dict[str, Any]) -> list[Difference]:
    """Return the changes of a job after which a verb's result is of an earlier job."""
    without = (*OF_PAPERS, *(OF_LOADS if verb in CUTTING else ()))

    def is_read(change: Difference) -> bool:
        path = re.sub(r"\[\d+\]", "", change.key)
        return not any(f"{path}.".startswith(f"{key}.") for key in without)

    return [*filter(is_read, differences(was, now))]


def _fingerprint(job: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(job, sort_keys=True, default=str).encode()).hexdigest()


def _kept_run(project: Project, run_id: str) -> Run | None:
    """Return a run by what is kept of it, or by its report alone; None where it was cut off."""
    report = project.result(run_id, REPORT)
    if report is None:
        return None
    state = project.own(run_id, STATE)
    try:
        if state is None:
            return _by_its_report(run_id, report)
        kept = json.loads(state.read_text(encoding="utf-8"))
        run = Run(run_id, kept["verb"], kept["asked"], "done", 1.0, "done", kept["exit_code"])
        run.started = float(kept["started"])
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return run


def _by_its_report(run_id: str, path: Path) -> Run:
    values = json.loads(path.read_text(encoding="utf-8"))
    code = ABOVE_EXIT_CODE if values.get("outcome") == "above_tolerance" else 0
    run = Run(run_id, str(values["command"]), {}, "done", 1.0, "done", code)
    run.started = path.stat().st_mtime
    return run


def _deaf_to_ctrl_c() -> None:
    """Keep Ctrl-C, which a terminal sends to every process, from what this thread starts."""
    held_signals([signal.SIGINT])


def processes() -> SpawnContext | ForkServerContext:
    """Return the start method of processes: copies of one that has loaded the modules, if possible."""
    if sys.platform == "win32":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([*PRELOADED_MODULES])
    return context


def end_preloaded() -> None:
    """End the process that others are copies of, though it be in the middle of loading."""
    from multiprocessing import forkserver

    server: Any = getattr(forkserver, "_forkserver", None)
    if getattr(server, "_forkserver_pid", None) is not None:
        os.kill(server._forkserver_pid, signal.SIGTERM)
        server._stop()


def _end(process: BaseProcess | None) -> None:
    if process is None:
        return
    process.terminate()
    process.join(GRACE_S)
    if process.is_alive():
        process.kill()
        process.join(GRACE_S)
