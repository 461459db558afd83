"""``balance``: measure, plan, cut, measure again until within tolerance; nothing is written until asked."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from autobalance import registry
from autobalance.balancing.measured import Crank as MeasuredCrank
from autobalance.balancing.measured_crank import (
    measure_crank,
    measured_again,
    measured_source,
    work_on_faces,
)
from autobalance.errors import JobError
from autobalance.job import Job, JobSource
from autobalance.job.from_options import JOB_NAME
from autobalance.job.model import CrankReadings
from autobalance.job.read import with_cuts
from autobalance.report.bundle import choice_of
from autobalance.report.files import seen_from
from autobalance.report.material import Choice
from autobalance.runtime import Notify, Progress, Stopwatch
from autobalance.value_classes import dataclass
from autobalance.verbs.crank_job import job_given, pressed_up_told, refuse_changed, staged_job
from autobalance.verbs.declaration import documented
from autobalance.verbs.entry import Entries, Entry, entries
from autobalance.verbs.progress import telling
from autobalance.verbs.result import VerbResult
from autobalance.verbs.result_files import (
    Staged,
    committed,
    measured_of,
    staged_files,
    staging_for,
    with_outputs,
)

if TYPE_CHECKING:
    from autobalance.balancing.kept import KeptPlan
    from autobalance.balancing.record import Record
    from autobalance.report.files import Staging
    from autobalance.report.records.balanced import BalancedReport
    from autobalance.verbs.crank import Crank
    from autobalance.verbs.entry import CutTool

ABOVE_TOLERANCE = 4
SAME_DENSITY = 1e-9


BENDING = "bending"
"""Section that `--fem` asks for."""


@dataclass(frozen=True, eq=False, repr=False)
class BalanceResult(VerbResult):
    """The end of a balancing run; what is read off it are values of its report.

    ``job`` is the job as it was run, ``record`` what was found, ``before`` the crank as it came.
    """

    job: Job
    record: Record
    before: Crank

    @property
    def outcome(self) -> str:
        """``within_tolerance``, ``already_within_tolerance`` or ``above_tolerance``."""
        return str(self.report["outcome"])

    @property
    def proven(self) -> bool:
        """Whether the residual and its uncertainty together are within what is permitted."""
        return bool(self.report["proven"])

    @property
    def reason(self) -> str | None:
        """Reason why the crank is above tolerance, with remedies."""
        reason: str | None = self.report["reason"]
        return reason

    @property
    def initial(self) -> Entry:
        """Unbalance before, as judged: keys as ``initial`` of the report."""
        return _unbalance(self.report["initial"])

    @property
    def residual(self) -> Entry:
        """Unbalance left, as judged: keys as ``residual`` of the report."""
        return _unbalance(self.report["residual"])

    @property
    def tolerance(self) -> Entry:
        """Permissible residual unbalance: keys as ``tolerance`` of the report."""
        return Entry(self.report["tolerance"])

    @property
    def corrections(self) -> Entries:
        """The cuts: keys as ``corrections`` of the report."""
        return entries(self.report["corrections"])

    @property
    def steps(self) -> Entries:
        """Planned, predicted and measured values of each pass."""
        return entries(self.report["steps"])

    @property
    def measured_on(self) -> Literal["file", "mesh", "surfaces"]:
        """Body whose measurement the verdict rests on.

        ``file``: the bytes that ``write`` writes in the input's format, read back. ``mesh``: the solid's own
        triangles in double precision, for a crank of no file. ``surfaces``: the true surfaces of the STEP
        file that ``write`` writes, read back.
        """
        source = self.before.measured.source
        if source.exact is not None:
            return "surfaces"
        return "mesh" if source.format is None else "file"

    @property
    def exit_code(self) -> int:
        """0, or 4 above tolerance."""
        return ABOVE_TOLERANCE if self.outcome == "above_tolerance" else 0

    def tools(self) -> tuple[CutTool, ...]:
        """Return the bodies of the tools, one a correction and in its order, file coordinates."""
        from autobalance.verbs.entry import tools_of

        assert self.record.balanced is not None  # a record of balance has it
        frame = self.before.measured.anatomy.rotor_to_file
        return tools_of(self.report["corrections"], self.record.balanced.result.tools, frame)

    @cached_property
    def crank(self) -> Crank:
        """The corrected crank, in the frame of the one that came; that one if nothing was cut."""
        return corrected_crank(self)

    def __repr__(self) -> str:
        balanced = self.record.balanced
        assert balanced is not None  # a record of balance has it
        worst = balanced.tolerance.worst(balanced.result.residual)
        cuts = len(self.report["corrections"])
        return (
            f"<autobalance balance: {self.outcome}, residual{worst.where} {worst.residual_g_mm:.4g} of "
            f"permitted {worst.permissible_g_mm:.4g} g·mm, {cuts} correction{'s' * (cuts != 1)}, "
            f"measured on {self.measured_on}>"
        )

    @cached_property
    def typed_report(self) -> BalancedReport:
        """The report as a record, for what shows it."""
        from autobalance.report.records.balanced import BalancedReport

        return BalancedReport.read(self.report)

    def show(self) -> Any:
        """Return the app's view of what was cut for a notebook; a picture without anywidget."""
        return registry.loaded(registry.VIEW)(self, self.crank.measured)

    def _repr_html_(self) -> str:
        from autobalance.report import notebook

        return notebook.balance(self.typed_report)

    def text(self, units: str = "metric") -> str:
        """Return the summary that the command prints."""
        return self._text(units, verbose=False)

    def full_text(self, units: str = "metric") -> str:
        """Return the summary with uncertainty, factor, forces and inertia."""
        return self._text(units, verbose=True)

    def _text(self, units: str, verbose: bool) -> str:
        from autobalance.report.balance.text import balance_text
        from autobalance.report.display_units import ON_SCREEN
        from autobalance.report.tables import unglued

        return unglued(balance_text(self.typed_report, ON_SCREEN[units], verbose=verbose))

    def write(
        self,
        folder: str | Path,
        only: tuple[str, ...] | None = None,
        *,
        paper: str = "A4",
        units: str = "metric",
        date: str | None = None,
        zero: str = "keyway",
        progress: Progress | None = None,
    ) -> tuple[Path, ...]:
        """Write the corrected solid, ``report.json`` and the pages to a folder: all files or none.

        Parameters
        ----------
        folder : path
            Made where it is missing.
        only : tuple of str or None
            Kinds of file wanted beside the solid: ``html``, ``pdf``, ``xlsx``, ``png``, ``dxf``, ``tools``,
            ``certificate``, ``card`` (bob-weights), ``csv`` (hole list), ``reading`` (reading.toml, to fill
            in). ``json``, the report, is always written. None: ``html``, ``pdf``, ``xlsx``, ``png`` and
            ``reading``.
        paper : str
            ``A4`` or ``Letter``, for ``sheet.pdf``.
        units : str
            ``metric`` or ``inch``, for the pages.
        date : str or None
            Printed on the sheet; None: today.
        zero : str
            ``keyway`` or ``crankpin``: from where the sheet's angles count; without a keyway from crankpin 1.
        progress : callable or None
            Called with what runs and the share done, 0 to 1.

        Returns
        -------
        tuple of Path

        Raises
        ------
        FormatError
            If ``only`` names an unknown kind.
        FileError
            If a file cannot be written; nothing is left behind then.
        """
        folder, choice = Path(folder), choice_of(only, paper, units, date, zero)
        refuse_changed(self.job, folder)
        with staging_for(folder) as staging:
            return committed(self, folder, choice, telling(progress), staging).files

    def staged(self, folder: Path, choice: Choice, notify: Notify, staging: Staging) -> Staged:
        """Stage the solid, the pages and the report for a folder."""
        written = staged_job(self.job, folder, staging)
        record = self.record if self.job.unwritten is None else _with_job_in(self.record, folder)
        values, files = staged_files(record, self.before, folder, choice, notify, staging)
        return values, (*files, *written)


@documented
def balance(
    job: JobSource,
    crank: Crank | None = None,
    *,
    settings: Sequence[str] = (),
    keep: str | Path | Mapping[str, Any] | None = None,
    cuts: Sequence[Mapping[str, Any]] | None = None,
    fem: bool = False,
    progress: Progress | None = None,
    **options: Any,
) -> BalanceResult:
    """Cut a crank until its residual unbalance is within tolerance, or as near as the metal allows.

    Nothing is written and nothing is printed.

    Parameters
    ----------
    job : Job, path or dict
        Job file, or a crank file with options for the job's keys. A dict's crank file is looked for in the
        working folder.
    keep : path, dict or None
        Report whose cuts are kept with new depths: places, tools, faces and numbers stay; None: the job's
        ``correction.keep``.
    cuts : sequence of dict or None
        Cuts that are made exactly as listed, in the form of ``[[correction.cut]]`` of the job: entries of a
        report's ``corrections`` as they are, or changed. Nothing is planned then.
    fem : bool
        Compute how the rods bend the webs at service speed, before and after the cuts: the weakest section of
        each web, and by finite elements the throw that loses most (extra fem).
    **options
        With a crank file in place of the job, keys of the job: ``unit``, ``density_kg_m3`` or ``material``,
        ``rotating_g``, ``reciprocating_g``, ``crankpin_g``, ``rods_per_throw``, ``stroke_mm``,
        ``rod_length_mm``, ``factor``, ``grade``, ``speed_rpm``, ``method``.

    Returns
    -------
    BalanceResult
        Not reaching the tolerance is a result too.

    Raises
    ------
    AutobalanceError
        For anything wrong with the job or the crank.

    Examples
    --------
    >>> from autobalance.bundled import bundled_folder
    >>> import autobalance as ab
    >>> job = ab.read_job(bundled_folder() / "crf250r" / "drafted" / "factor-0.28.toml")
    >>> result = ab.balance(job)
    >>> result.outcome, round(result.corrections[0].depth_mm, 2)
    ('within_tolerance', 2.79)
    """
    watch = Stopwatch()
    with watch.stage("load"):
        read = job_given("balance", job, options, settings)
        if keep is not None:
            read = replace(read, keep=keep if isinstance(keep, Mapping) else Path(keep))
        if cuts is not None:
            read = with_cuts(read, cuts)
    return run(read, crank, telling(progress), watch, fem)


def run(job: Job, crank: Crank | None, notify: Notify, watch: Stopwatch, fem: bool = False) -> BalanceResult:
    """Balance a job's crank; the stopwatch may have counted what came before."""
    from autobalance.verbs.crank import Crank

    if fem:
        from autobalance.balancing.sections import section

        section(BENDING).require()
    notify("reading the crank")
    if crank is None:
        with pressed_up_told(job):
            measured = measure_crank(job.crankshaft, watch, job.balance, work_on_faces(job))
    else:
        job = with_crank(job, crank)
        with watch.stage("measure"):
            measured = measured_again(crank.measured, job)
    from autobalance.balancing.run import balanced_record

    record = balanced_record(job, measured, watch, notify, _kept(job))
    record = replace(record, warnings=(*_warnings(job, measured), *record.warnings))
    if fem:
        record = _with_bending(record, job, measured, notify)
    record = with_outputs(record, job, measured, watch)
    from autobalance.report.records.report import Report

    return BalanceResult(Report.of(record), job, record, Crank(measured, job.crankshaft))


def _with_job_in(record: Record, folder: Path) -> Record:
    """Return a run's record whose job lies in the folder of the results."""
    balanced = record.balanced
    assert balanced is not None  # a record of balance has it
    crankshaft = balanced.job["crankshaft"]
    file = Path(balanced.job["file"]).parent / crankshaft["file"]
    job = {
        **balanced.job,
        "file": str((folder / JOB_NAME).resolve()),
        "crankshaft": {**crankshaft, "file": seen_from(folder, Path(os.path.normpath(file)))},
    }
    return replace(record, balanced=replace(balanced, job=job))


def _with_bending(record: Record, job: Job, crank: MeasuredCrank, notify: Notify) -> Record:
    """Return a run's record with the stress of its webs."""
    from autobalance.balancing.sections import State, ended, section

    balanced = record.balanced
    assert balanced is not None  # a record of balance has it
    before = State(job, crank, crank.source.solid, crank.moments)
    after = before._replace(
        solid=balanced.result.solid or before.solid, moments=balanced.result.final_moments
    )
    found = ended({BENDING: section(BENDING).begun(before)}, after, notify)
    return replace(record, balanced=replace(balanced, sections={**balanced.sections, **found}))


def _kept(job: Job) -> KeptPlan | None:
    """Return the plan that a job keeps, if it keeps one."""
    if job.keep is None:
        return None
    from autobalance.balancing.kept import kept_plan
    from autobalance.verification.report_file import read_report, refuse_version

    if isinstance(job.keep, Mapping):
        refuse_version("keep", job.keep)
        return kept_plan("keep", json.dumps(job.keep, sort_keys=True).encode(), job.keep)
    values = read_report(job.keep)
    return kept_plan(job.keep.name, job.keep.read_bytes(), values)


def with_crank(job: Job, crank: Crank) -> Job:
    """Return a job whose crank is the one given.

    Raises
    ------
    JobError If the job has another density, or other data of the crankpin.
    """
    own, crankshaft = job.crankshaft, crank.crankshaft
    density, of_crank = own.density_g_mm3, crankshaft.density_g_mm3
    if density > 0.0 and abs(density - of_crank) > SAME_DENSITY * of_crank:
        raise JobError(
            f"{job.path.name}: crankshaft.density_kg_m3 is {density * 1e6:g}, the crank given has"
            f" {of_crank * 1e6:g}; expected the same, or none in the job"
        )
    overrides = replace(crankshaft.overrides, crankpin_in_file=own.overrides.crankpin_in_file)
    off = own.density_pm_g_mm3 if crankshaft.density_pm_g_mm3 is None else crankshaft.density_pm_g_mm3
    known, said = crankshaft.weighed, own.weighed
    accuracy = said.scan_accuracy_mm if known.scan_accuracy_mm is None else known.scan_accuracy_mm
    readings = known.readings if known.readings.any else said.readings
    scan = own.scan if crankshaft.scan is None else crankshaft.scan
    if scan is not None:
        scan = replace(scan, density_g_mm3=of_crank, density_pm_g_mm3=off)
    given = replace(crankshaft, overrides=overrides, density_pm_g_mm3=off, scan=scan)
    return replace(job, crankshaft=given.weighed_with(scan_accuracy_mm=accuracy, readings=readings))


def _unbalance(values: Mapping[str, Any]) -> Entry:
    return Entry({**values, "resultant_g_mm": values["unbalance_g_mm"]})


def _warnings(job: Job, crank: MeasuredCrank) -> tuple[str, ...]:
    weights = job.engine.default.weights
    empty = [name for name in ("rotating", "reciprocating") if not getattr(weights, name)]
    unnamed = [f"{job.path.name}: engine.{name}_g names no weight; its parts count as 0 g" for name in empty]
    weights_unnamed = () if job.engine.by_throw else unnamed
    return (*weights_unnamed, *crank.warnings(job.crankshaft.file, job), *_logo_warnings(job))


def _logo_warnings(job: Job) -> tuple[str, ...]:
    """Return a warning where the shop's picture cannot be printed."""
    from autobalance.report.job_header import picture_of

    path = (job.filled.get("shop") or {}).get("logo")
    if not path or picture_of(Path(path)) is not None:
        return ()
    return (f"{job.path.name}: shop.logo is {path}; expected a PNG or JPEG file there; pages go without it",)


def corrected_crank(result: BalanceResult) -> Crank:
    """Return the crank that a run leaves, read from the bytes that would be written, in the frame it had."""
    from autobalance.solid.formats.read import source_of, source_of_bytes
    from autobalance.solid.formats.registry import written_name
    from autobalance.verbs.crank import Crank

    measured, before = measured_of(result.record), result.before
    if measured is None:
        return before
    assert result.record.balanced is not None
    source = before.measured.source
    if measured.data is None:
        solid = result.record.balanced.result.solid
        assert solid is not None
        corners = solid.mesh.corners
        after = source_of(corners, "mm", "all")
    else:
        name = written_name(str(source.format)).removesuffix("-ascii")
        after = source_of_bytes(measured.data, name, before.crankshaft.unit, "all")
    was = before.measured
    crank = measured_source(after, was.anatomy, was.density_g_mm3, calibration=was.calibration)
    own = replace(before.crankshaft, file=None, readings=CrankReadings(), density_g_mm3=was.density_g_mm3)
    return Crank(crank, own)
