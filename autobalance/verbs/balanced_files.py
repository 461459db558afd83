"""``balance`` of the command: what it writes, and what of earlier runs it leaves beside that."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from autobalance.errors import FileError
from autobalance.job import Job, describe
from autobalance.report.job_header import file_prefix
from autobalance.report.material import Choice
from autobalance.report.output_kinds import names_to_fill, page_names
from autobalance.report.records.job import Job as JobEcho
from autobalance.runtime import Notify, Stopwatch
from autobalance.value_classes import dataclass
from autobalance.verbs.balance import BalanceResult, run
from autobalance.verbs.crank_job import refuse_changed
from autobalance.verbs.result_files import REPORT, committed, solid_name, staging_for


@dataclass(frozen=True, eq=False)
class BalancedFiles:
    """A run whose files are in place."""

    result: BalanceResult
    report: dict[str, Any]
    files: tuple[Path, ...]
    warnings: tuple[str, ...]


def balance_to_files(
    job: Job,
    folder: Path,
    json_file: str | None,
    notify: Notify,
    choice: Choice | None = None,
    fem: bool = False,
) -> BalancedFiles:
    """Balance the crank of a job and write its files to ``folder``, all of them or none.

    That they can be written is proved before the work begins.

    Parameters
    ----------
    job : Job
    folder : Path
        Made where it is missing.
    json_file : str or None
        Path of a copy of the report; ``-`` writes no file.
    notify : callable
        Called with what runs, in a few words.
    choice : Choice or None
        The pages, sheets and pictures to write beside the report; None: none.
    fem : bool
        Whether the stress of the webs is computed too.

    Raises
    ------
    AutobalanceError
        For anything wrong with the job, the crank or the folder; nothing is left behind then.
    """
    copy = None if json_file in (None, "-") else Path(str(json_file))
    choice = choice or Choice(kinds=())
    pages = [folder / name for name in page_names(file_prefix(JobEcho.read(describe(job)).job))]
    solid_path = folder / solid_name(job)
    targets = [folder / REPORT, solid_path, *pages] + ([copy] if copy else [])
    refuse_changed(job, folder)
    _refuse_overwriting(targets, [job.path, *([job.crankshaft.file] if job.crankshaft.file else [])])
    with staging_for(folder, copy) as staging:
        result = run(job, None, notify, Stopwatch(), fem)
        values, files, notes = committed(result, folder, choice, notify, staging, copy)
    warnings = [*result.warnings, *notes]
    if values["outputs"]["solid"] is None and solid_path.exists():
        warnings.append(f"{solid_path} is not of this run, which cut nothing; no report here lists it")
    kept = names_to_fill()
    old = [page.name for page in pages if page.exists() and page not in files and page.name not in kept]
    if old:
        warnings.append(
            f"{folder} holds {', '.join(old)}, which this run did not write; no report here lists them"
        )
    return BalancedFiles(result, values, files, tuple(warnings))


def _refuse_overwriting(targets: list[Path], sources: list[Path]) -> None:
    places = [target.resolve() for target in targets]
    for place in places:
        if places.count(place) > 1:
            raise FileError(f"two outputs share the path {place}; choose another path for --json")
    for target in targets:
        if target.is_dir():
            raise FileError(f"cannot write {target}: a folder has this name")
        for source in sources:
            if target.resolve() == source.resolve():
                raise FileError(
                    f"writing {target} would destroy a file that the job reads; choose another place"
                )
