"""``ab.recut``: a corrected crank was spun on a balancing machine; what is still to cut."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.errors import FileError, FormatError, JobError
from autobalance.runtime import Notify, Progress, Stopwatch
from autobalance.verbs.balance import BalanceResult
from autobalance.verbs.common_parameters import documented
from autobalance.verbs.progress import telling
from autobalance.verbs.result_files import REPORT, Staged, staged_files

if TYPE_CHECKING:
    from autobalance.report.balance.stage_values import StageNotes
    from autobalance.report.files import Staging
    from autobalance.report.material import Choice

MOST_STAGES = 10
HISTORY = "history.html"


@dataclass(frozen=True, eq=False, repr=False)
class RecutResult(BalanceResult):
    """The end of a stage; ``stages`` of the report has all of them so far."""

    notes: StageNotes
    folder: Path

    @property
    def stage(self) -> int:
        """Number of the stage."""
        return int(self.report["stages"][-1]["stage"])

    @cached_property
    def history(self) -> str:
        """The page of all stages."""
        from autobalance.report.page.history import history_page

        return history_page(self.report, stage_dates(self.report["stages"][:-1], self.folder))

    def _text(self, units: str, verbose: bool) -> str:
        from autobalance.report.balance.recut_text import recut_text
        from autobalance.report.display_units import ON_SCREEN
        from autobalance.report.wrapping import unglued

        return unglued(recut_text(self.report, ON_SCREEN[units], verbose=verbose))

    def write(
        self,
        folder: str | Path | None = None,
        only: tuple[str, ...] | None = None,
        *,
        paper: str = "A4",
        units: str = "metric",
        date: str | None = None,
        zero: str = "keyway",
        progress: Progress | None = None,
    ) -> tuple[Path, ...]:
        """Write the solid, ``report.json``, ``history.html`` and the pages: all files or none.

        ``folder`` is ``stage-N`` in the folder of the first stage's report unless given; for the rest see
        ``BalanceResult.write``.
        """
        target = self.folder if folder is None else folder
        return super().write(target, only, paper=paper, units=units, date=date, zero=zero, progress=progress)

    def staged(self, folder: Path, choice: Choice, notify: Notify, staging: Staging) -> Staged:
        """Stage all files for a folder, the page of all stages too; other reports are named from there."""
        from autobalance.report.balance.stage_values import stage_values
        from autobalance.report.balance.values import report
        from autobalance.report.page.history import history_page
        from autobalance.report.records.outputs import Page

        record = self.record
        assert record.balanced is not None
        record = replace(record, staged=stage_values(self.notes, folder, record.balanced.result))
        values = report(record)
        for each in values["stages"][:-1]:
            if (folder / each["report"]).resolve() == (folder / REPORT).resolve():
                raise FileError(
                    f"{folder} holds the report of stage {each['stage']} of this crank; choose another folder"
                )
        dates = [*stage_dates(values["stages"][:-1], folder), choice.date]
        page = history_page(values, dates, choice.units).encode()
        staging.add(folder / HISTORY, page)
        entry = Page(file=HISTORY, sha256=hashlib.sha256(page).hexdigest())
        record = replace(record, outputs={**record.outputs, "history": entry})
        written, files = staged_files(record, self.before, folder, choice, notify, staging)
        return written, (*files, folder / HISTORY)


def stage_dates(stages: Sequence[Mapping[str, Any]], folder: Path) -> list[str]:
    """Return the days on which the reports of earlier stages were written; "" of one that is gone."""
    reports = [folder / each["report"] for each in stages]
    return [
        date.fromtimestamp(path.stat().st_mtime).isoformat() if path.is_file() else "" for path in reports
    ]


@documented
def recut(
    report: str | Path,
    reading: str | Path | Mapping[str, Any],
    *,
    folder: str | Path | None = None,
    trust_reading: bool = False,
    progress: Progress | None = None,
) -> RecutResult:
    """Plan and make further cuts on a corrected crank, from what a balancing machine read on it.

    Nothing is written until ``write`` of the result.

    Parameters
    ----------
    report : path
        Report of balance or recut, its solid beside it.
    reading : path or dict
        Reading of the balancing machine, a READING.toml. Or its structure.
    folder : path or None
        Folder of the results; None: stage-N beside the first stage's report.
    trust_reading : bool
        Continue even if the reading looks like a known set-up error.

    Returns
    -------
    RecutResult

    Raises
    ------
    JobError
        If a key of the reading is wrong, or a likely mistake explains it.
    AutobalanceError
        If the report, its solid or the limits of the correction are.
    """
    from autobalance.job.files.reading import read_reading
    from autobalance.report.records.report import Report
    from autobalance.verbs.recut_stage import RecutStage
    from autobalance.verification.earlier_stage import earlier_stage

    notify, watch = telling(progress), Stopwatch()
    read = read_reading(reading)
    name = None if isinstance(reading, Mapping) else Path(reading).name
    notify("reading the crank")
    with watch.stage("load"):
        earlier = earlier_stage(Path(report))
    if earlier.number >= MOST_STAGES:
        raise FormatError(f"{earlier.path.name} is stage {earlier.number}; {MOST_STAGES} stages are the most")
    first = Path(os.path.normpath(earlier.first_report.parent))
    target = first / f"stage-{earlier.number + 1}" if folder is None else Path(folder)
    try:
        own, record, before, notes = RecutStage(earlier, read, trust_reading, notify, watch).made(target)
    except JobError as error:
        raise error if name is None else JobError(f"{name}: {error}") from None
    return RecutResult(Report.of(record), own, record, before, notes, target)
