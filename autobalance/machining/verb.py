"""``ab.nc``: programs for machine tools that make a report's cuts, simulated from their own text."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.runtime import Progress
from autobalance.value_classes import dataclass
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.machining.answer import NcReport
    from autobalance.machining.area_moves import MachinedCrank
    from autobalance.machining.run import NcRun

LEFT_OUT = 4
TOOL_TABLE = "tools.tbl"
SHEET = "setup.pdf"


@dataclass(frozen=True, eq=False, repr=False)
class NcResult(VerbResult):
    """NC programs and what they do to the solid."""

    content: NcReport
    run: NcRun

    @property
    def programs(self) -> dict[str, str]:
        """File name → text of each program."""
        return {program.file: program.text for program in self.run.programs}

    @property
    def exit_code(self) -> int:
        """0; 4 where the simulated residual is above tolerance, or cuts are left out."""
        return 0 if self.run.is_complete else LEFT_OUT

    @cached_property
    def _files(self) -> dict[str, bytes]:
        from autobalance.machining.answer import setup_sheet
        from autobalance.machining.run import tool_table

        files = {name: text.encode("ascii") for name, text in self.programs.items()}
        if self.run.machine.spindle.post == "linuxcnc":
            files[TOOL_TABLE] = tool_table(self.run.machine.tools).encode("ascii", "replace")
        return {**files, SHEET: setup_sheet(self.run)}

    def files(self) -> Mapping[str, bytes]:
        """Return the programs, the tool table and the set-up sheet."""
        return dict(self._files)

    def text(self, units: str = "metric") -> str:
        """Return a summary of the programs, and of the residual after them."""
        from autobalance.machining.answer import nc_text

        return nc_text(self.run)


def nc(
    report: str | Path,
    machine: str | Path | Mapping[str, Any],
    *,
    finish_mm: float | None = None,
    progress: Progress | None = None,
) -> NcResult:
    """Write NC programs for a report's cuts, and simulate them on the solid from their own text.

    Nothing is written to disk until ``write`` of the result.

    Parameters
    ----------
    report : path
        Report of ``balance`` or ``recut``, its solids where it names them; every claim is checked first.
    machine : path or dict
        Machine file: the machine tool, its zero and its tools; or its structure.
    finish_mm : float or None
        Metal left on every depth, for a first try.
    progress : callable or None
        Called with what runs and the share done, 0 to 1.

    Returns
    -------
    NcResult

    Raises
    ------
    JobError
        If a key of the machine file is wrong, a tool is missing or too short, or a move would hit.
    AutobalanceError
        If the report or its solids do not hold.
    """
    from dataclasses import replace

    from autobalance.errors import JobError, UsageError
    from autobalance.machining.answer import nc_report
    from autobalance.machining.input import read_machine_tool
    from autobalance.machining.run import nc_run

    tool = read_machine_tool(machine)
    if finish_mm is not None:
        if not 0.0 <= finish_mm < 1e4:
            raise UsageError(f"finish_mm is {finish_mm:g}; expected 0 or more")
        tool = replace(tool, zero=replace(tool.zero, finish_mm=float(finish_mm)))
    notify = telling(progress)
    notify("checking the report")
    part = verified_part(Path(report))
    try:
        run = nc_run(part, tool, notify)
    except JobError as error:
        name = "" if isinstance(machine, Mapping) else f"{Path(machine).name}: "
        raise JobError(f"{name}{error}") from None
    return NcResult(nc_report(run), run)


def verified_part(path: Path) -> MachinedCrank:
    """Return the cuts of a report as a part to machine, after all its claims were checked.

    Raises
    ------
    ClaimError
        If one does not hold.
    """
    from autobalance.machining.area_moves import MachinedCrank, listed
    from autobalance.report.balance.values import report as as_report
    from autobalance.report.balance.values import schema
    from autobalance.verification import premises, solids
    from autobalance.verification.check import check_claims
    from autobalance.verification.claims import Claims
    from autobalance.verification.report_file import read_report
    from autobalance.verification.solids import Files

    claims, files = Claims(path.name, read_report(path)), Files()
    checked = check_claims(claims, path.parent, False, as_report, files, schema())
    job, anatomy = premises.claimed_job(claims, path.parent), premises.claimed_anatomy(claims)
    frame = anatomy.file_to_rotor
    before = solids.source_before(claims, path.parent, job, files)
    left = solids.measured_files(claims, path.parent, job, frame, files)
    data = path.read_bytes()
    return MachinedCrank(
        name=Path(claims.get("input.file", str)).name,
        report=path,
        sha256=hashlib.sha256(data).hexdigest(),
        before=before.solid.moved(frame),
        after=left.source.solid.moved(frame),
        anatomy=anatomy,
        density_g_mm3=job.crankshaft.density_g_mm3,
        tolerance=checked.tolerance,
        residual=checked.residual,
        cuts=tuple(listed(item) for item in claims.get("corrections", list)),
    )
