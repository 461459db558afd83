"""Files named on the command line, or dropped on the page, as part of the project."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from autobalance.browser.cranks import copied_crank, kept_jobs
from autobalance.browser.guard import jsonable
from autobalance.browser.project import ABOVE_EXIT_CODE, FILE_KEYS, JOB, STATE, Project, is_plain
from autobalance.errors import FileError, FormatError
from autobalance.toml_files.document import toml_of, toml_text

REPORT = "report.json"
JOBS = (".toml", ".xlsx")
JOB_BEFORE = "job-before.toml"
"""The job of the crank that was open before another one."""
OF_ANY_CRANK = ("shop",)
"""Tables of a job that are the same for every crank."""
WORKBOOK_MB = 1024
"""Memory in which a workbook that was uploaded must be read."""


def open_in(source: Path, project: Project) -> None:
    """Copy a crank, a job with its files, a report with its results, or a folder of those into the project.

    Raises
    ------
    AutobalanceError If it cannot be read, or its content does not match its name.
    """
    if source.is_dir():
        _open_folder(source, project)
    elif source.suffix.lower() in JOBS:
        open_job(source, project)
    elif source.suffix.lower() == ".json":
        open_report(source, project)
    else:
        open_crank(project.copied(source), project)


def _open_folder(folder: Path, project: Project) -> None:
    if (folder / REPORT).is_file():
        open_report(folder / REPORT, project)
        return
    files = [path for path in sorted(folder.iterdir()) if path.is_file() and is_plain(path.name)]
    jobs = [path for path in files if path.suffix.lower() == ".toml"]
    for path in files:
        if path not in jobs:
            project.copied(path)
    if jobs:
        open_job(next((path for path in jobs if path.name == JOB), jobs[0]), project)


def open_crank(name: str, project: Project) -> None:
    """Use a file of the project as the job's crank; a job of another crank is removed, its shop keys stay.

    Unit, weights, the original's parts and limits belong to the crank that they were typed for. What goes is
    kept as a file of the project, `JOB_BEFORE`, and comes back with its crank.
    """
    if job_of(project).get("crankshaft", {}).get("file") == name:
        return
    kept = _kept_job(project, name)
    before = kept.read_text(encoding="utf-8") if kept.is_file() else ""
    tables = {**for_another(project), "crankshaft": {"file": name}}
    project.write_job(before or toml_text(tables))


def duplicate_crank(project: Project) -> str:
    """Make a second job beside the first: a copy of the crank by another name, with its job; return the file.

    Raises
    ------
    FileError
        If no crank is open.
    """
    tables = job_of(project)
    file = str(tables.get("crankshaft", {}).get("file", ""))
    if project.file(file) is None:
        raise FileError("open a crank first; then its job can be duplicated")
    for_another(project)
    name = copied_crank(project, file)
    project.write_job(toml_text({**tables, "crankshaft": {**tables["crankshaft"], "file": name}}))
    return name


def _kept_job(project: Project, crank: str) -> Path:
    """Return the file that keeps the last job of a crank while another one is open."""
    return kept_jobs(project) / f"{crank}.toml"


def for_another(project: Project) -> dict[str, Any]:
    """Return the keys of the project's job that another crank's job keeps: all, if that has no crank yet."""
    tables = job_of(project)
    if not crank_of(tables):
        return tables
    project.write_text(JOB_BEFORE, toml_text(tables))
    kept = _kept_job(project, str(tables["crankshaft"]["file"]))
    kept.parent.mkdir(exist_ok=True)
    project.write_text(str(kept.relative_to(project.folder)), toml_text(tables))
    return {key: value for key, value in tables.items() if key in OF_ANY_CRANK}


def _write_job_of_another(tables: Mapping[str, Any], project: Project) -> None:
    """Make tables the project's job; that of another crank is kept for when its crank is opened again."""
    if crank_of(job_of(project)) not in (None, crank_of(tables)):
        for_another(project)
    project.write_job(toml_text(tables))


def job_of(project: Project) -> dict[str, Any]:
    """Return the project's job as tables; empty without a job."""
    path = project.file(JOB)
    return {} if path is None else _tables_of(path)


def job_told(project: Project) -> dict[str, Any]:
    """Return the project's job as the page takes it, with its version."""
    return {"job": jsonable(job_of(project)), "job_version": project.job_version}


def job_of_crank(project: Project, crank: str) -> dict[str, Any] | None:
    """Return the job of a crank as it is now: the project's, or the one kept while another crank is open."""
    tables = job_of(project)
    if crank_of(tables) == crank:
        return tables
    kept = _kept_job(project, crank)
    return _tables_of(kept) if is_plain(crank) and kept.is_file() else None


def crank_of(tables: Mapping[str, Any]) -> str | None:
    """Return the file of a job's crank; None if the job names no file."""
    table = tables.get("crankshaft")  # as it was typed
    file = table.get("file") if isinstance(table, dict) else None
    return str(file) if file else None


def _tables_of(path: Path) -> dict[str, Any]:
    try:
        return toml_of(path.read_text(encoding="utf-8"), JOB)
    except ValueError:  # no UTF-8, or no TOML
        return {}


def open_job(path: Path, project: Project) -> None:
    """Make a job the project's, with copies of the files that it names.

    Raises
    ------
    AutobalanceError
        If it cannot be read.
    """
    from autobalance.job.read import tables_of

    def here(name: str) -> str:
        file = path.parent / name
        if file.parent.resolve() == project.folder and project.file(file.name) is not None:
            return file.name
        return project.copied(file) if file.is_file() else Path(name).name

    _write_job_of_another(_named(tables_of(path), here), project)


def open_own_job(name: str, project: Project) -> None:
    """Make a job that was uploaded the project's; only files of the project count.

    Raises
    ------
    AutobalanceError
        If it cannot be read.
    """
    tables = _named(
        _tables_apart(project.folder / name), lambda file: file.replace("\\", "/").rpartition("/")[2]
    )
    _write_job_of_another(tables, project)


def _tables_apart(path: Path) -> dict[str, Any]:
    """Return an uploaded job's tables; a workbook is read in a process with a limit to its memory."""
    from autobalance.job.read import tables_of

    if path.suffix.lower() == ".toml":
        return tables_of(path)
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    from autobalance.browser.work import limit_memory

    with ProcessPoolExecutor(1, get_context("spawn"), limit_memory, (WORKBOOK_MB,)) as pool:
        try:
            return pool.submit(tables_of, path).result()
        except (BrokenProcessPool, MemoryError):
            raise FormatError(
                f"{path.name}: found a workbook that takes more than {WORKBOOK_MB} MB to read; expected a job"
            ) from None


def _named(values: Any, name: Callable[[str], str]) -> Any:
    """Return a job whose files have other names."""
    if isinstance(values, dict):
        return {
            key: name(value) if key in FILE_KEYS and isinstance(value, str) else _named(value, name)
            for key, value in values.items()
        }
    return [_named(item, name) for item in values] if isinstance(values, list) else values


def open_report(path: Path, project: Project, anywhere: bool = True) -> str:
    """Take a result in as a run of the project, with its job; return the run's id.

    The crank that it started from is copied too where it is found, ``anywhere`` or beside the report alone.

    Raises
    ------
    AutobalanceError
        If it is not a report of ``balance`` or ``recut``, or its solid is gone.
    """
    from autobalance.verification.premises import without_nulls
    from autobalance.verification.report_file import read_report

    report = read_report(path)
    if report.get("command") not in ("balance", "recut") or not isinstance(report.get("job"), dict):
        raise FormatError(f"{path.name} is not a report of balance or recut")
    names = [REPORT, *(str(each["file"]) for each in _outputs(report))]
    run = hashlib.sha256(path.read_bytes()).hexdigest()[:12]
    folder = project.run_folder(run)
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        source = path if name == REPORT else path.parent / name
        if not is_plain(name) or source.is_symlink() or not source.is_file():
            project.forget(run)
            raise FileError(f"{path.name}: {name}, which it names, is not beside it")
        (folder / name).write_bytes(source.read_bytes())
    tables = without_nulls(report["job"])
    tables.pop("file", None)
    named = str(report["input"]["file"]).replace("\\", "/")
    crank = path.parent / (named if anywhere else named.rpartition("/")[2])
    if crank.is_file() and not crank.is_symlink():
        tables["crankshaft"]["file"] = project.copied(crank)
    _write_job_of_another(tables, project)
    own = project.own_folder(run)
    own.mkdir(parents=True, exist_ok=True)
    ended = {"exit_code": ABOVE_EXIT_CODE if report.get("outcome") == "above_tolerance" else 0}
    begun = {"verb": report["command"], "started": path.stat().st_mtime, "asked": {"job": tables}}
    (own / STATE).write_text(json.dumps({**begun, **ended}), encoding="utf-8")
    return run


def open_job_of(made_of: Mapping[str, Any], project: Project) -> None:
    """Make the job that made a result the project's; the one of before is kept as a file, `JOB_BEFORE`.

    Raises
    ------
    FileError
        If its crank is gone.
    """
    name = str(made_of.get("crankshaft", {}).get("file", ""))
    if project.file(name) is None:
        raise FileError(f"{name or 'the crank'} of that result is not in the project any more; drop it again")
    if job_of(project).get("crankshaft", {}).get("file") != name:
        for_another(project)
    project.write_text(JOB_BEFORE, project.job_text)
    project.write_job(toml_text(dict(made_of)))


def _outputs(report: Any) -> list[Any]:
    return [each for each in (report.get("outputs") or {}).values() if isinstance(each, dict)]
