"""A whole balancing run, from the job to the files in place; prints nothing."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.balancing.measured_crank import Crank, measure_crank, work_on_faces
from autobalance.errors import FileError
from autobalance.job import Job
from autobalance.report.bundle import FILES, Choice, bundle
from autobalance.report.files import Staging
from autobalance.runtime import Stopwatch, in_thread

if TYPE_CHECKING:
    from autobalance.balancing.record import Record

REPORT = "report.json"
SOLID = "balanced"
Progress = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Run:
    """A run whose files are in place."""

    report: dict[str, Any]
    files: tuple[Path, ...]
    warnings: tuple[str, ...]


def run_job(
    job: Job, folder: Path, json_file: str | None, progress: Progress, choice: Choice | None = None
) -> Run:
    """Balance the crank of a job and write its files to ``folder``, all of them or none.

    Parameters
    ----------
    job : Job
    folder : Path
        Made where it is missing.
    json_file : str or None
        Where a copy of the report goes; ``-`` is none.
    progress : callable
        Told in a few words what runs.
    choice : Choice or None
        The pages, sheets and pictures to write beside the report; None: none.

    Raises
    ------
    AutobalanceError
        For anything wrong with the job, the crank or the folder; nothing is left behind then.
    """
    watch = Stopwatch()
    in_thread(_prepare)
    copy = None if json_file in (None, "-") else Path(str(json_file))
    solid_path = folder / (SOLID + job.crankshaft.file.suffix.lower())
    choice = choice or Choice(kinds=())
    pages = [folder / name for name in FILES.values()]
    targets = [folder / REPORT, solid_path, *pages] + ([copy] if copy else [])
    _refuse_overwriting(targets, [job.path, job.crankshaft.file])
    with Staging([folder] + ([copy.parent] if copy else [])) as staging:
        progress("reading the crank")
        crank = measure_crank(job.crankshaft, watch, job.balance, work_on_faces(job))
        # not before: ``_prepare`` has loaded them by now
        from autobalance.balancing.run import balanced_record
        from autobalance.report.json import dumps, report, solid_entry

        record, written = balanced_record(job, crank, watch, progress)
        record = replace(record, warnings=_warnings(job, crank))
        started = time.perf_counter()
        progress("writing")
        entries: dict[str, Any] = {"solid": None}
        if written is not None:
            digest = in_thread(lambda: hashlib.sha256(written.data).hexdigest())
            staging.add(solid_path, written.data)
            entries["solid"] = solid_entry(
                solid_path.name,
                digest.result(),
                written.triangles,
                written.moments,
                written.moments.mass_g / job.crankshaft.density_g_mm3,
            )
        extras = _pages(entries, crank, record, choice, progress) if choice.kinds else {}
        for key, (name, data) in extras.items():
            staging.add(folder / name, data)
            entries[key] = {"file": name, "sha256": hashlib.sha256(data).hexdigest()}
        watch.add("write", time.perf_counter() - started)
        values = report(replace(record, outputs=entries, seconds=watch.seconds))
        text = dumps(values).encode()
        for path in [folder / REPORT] + ([copy] if copy else []):
            staging.add(path, text)
        staging.commit()
    stale = written is None and solid_path.exists()
    warnings = list(record.warnings)
    if stale:
        warnings.append(f"{solid_path} is of an earlier run; this one cut nothing")
    fresh = [folder / name for name, _ in extras.values()]
    old = [page.name for page in pages if page.exists() and page not in fresh]
    if old:
        warnings.append(f"of an earlier run in {folder}: {', '.join(old)}; this one did not write them")
    files = ([solid_path] if written is not None else []) + fresh
    return Run(values, (*files, folder / REPORT, *([copy] if copy else [])), tuple(warnings))


def _prepare() -> None:
    """Load what is needed once the crank is read, and what the report says of the libraries, meanwhile."""
    import_module("autobalance.balancing.run")
    import_module("autobalance.report.json").library_versions()


def _pages(
    entries: dict[str, Any], crank: Crank, record: Record, choice: Choice, progress: Progress
) -> dict[str, tuple[str, bytes]]:
    """Return the pages, sheets and pictures of a run."""
    from autobalance.report.json import report, showable

    assert record.balanced is not None
    result = record.balanced.result
    values = showable(report(replace(record, outputs=entries)))
    return bundle(values, crank.source.solid, result.solid, result.tools, choice, progress)


def _refuse_overwriting(targets: list[Path], sources: list[Path]) -> None:
    for target in targets:
        if target.is_dir():
            raise FileError(f"cannot write {target}: a folder has this name")
        for source in sources:
            if target.resolve() == source.resolve():
                raise FileError(
                    f"writing {target} would destroy a file that the job reads; choose another place"
                )


def _warnings(job: Job, crank: Crank) -> tuple[str, ...]:
    weights = job.engine.default.weights
    empty = [name for name in ("rotating", "reciprocating") if not getattr(weights, name)]
    unnamed = [f"{job.path.name}: engine.{name}_g names no weight; its parts count as 0 g" for name in empty]
    return (*(() if job.engine.by_throw else unnamed), *crank.warnings(job.crankshaft.file))
