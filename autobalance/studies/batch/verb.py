"""``ab.batch``: many jobs, one result row each, here or on a cluster, resumed after an interruption."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from autobalance.runtime import Progress
from autobalance.verbs.declaration import documented
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.studies.batch.answer import BatchReport

NOT_ALL_WITHIN = 4


class BatchResult(VerbResult):
    """One row for each job of a list."""

    content: BatchReport

    @property
    def exit_code(self) -> int:
        """0 where all rows are within tolerance, else 4."""
        return 0 if self.content.within == self.content.rows else NOT_ALL_WITHIN

    def text(self, units: str = "metric") -> str:
        """Return the counts and the reasons as lines for people."""
        from autobalance.studies.batch.answer import batch_text

        return batch_text(self.content)


@documented
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
        List of jobs (CSV or workbook), folder of jobs, or with a job given a folder of cranks.
    output : path
        Folder of the results, made where it is missing.
    job : path or None
        Job of all rows that name no job; None: each row names its own.
    only : sequence of str
        Kinds of file to write beside each solid, with commas between: json, html, pdf, xlsx, png. As for
        ``BalanceResult.write``.
    fresh : bool
        Discard what the folder holds of an earlier batch.

    Returns
    -------
    BatchResult
        Rows that fail are rows too, with their line.

    Raises
    ------
    JobError If the list is not valid. FileError If the folder is held by another batch, or the cluster does
    not answer.
    """
    from autobalance.studies.batch.input import read_batch_list
    from autobalance.studies.batch.journal import held, made_folder
    from autobalance.studies.batch.run import BatchRun, balance_row
    from autobalance.studies.workers import workers_of

    started = time.perf_counter()
    folder = Path(output)
    listed = read_batch_list(Path(source), None if job is None else Path(job)).with_set(settings)
    with workers_of(workers, cluster, cluster_timeout_s, alone=False) as pool:
        made_folder(folder)
        with held(folder):
            run = BatchRun(folder, listed, tuple(only), progress)
            run.take_over(fresh=fresh)
            todo = run.tasks()
            for done in pool.run(balance_row, todo):
                run.finish(todo.rows[done.number], done)
            result = BatchResult(run.report(time.perf_counter() - started))
            run.write(result.content)
    return result
