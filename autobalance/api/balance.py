"""``balance``: measure, plan, cut, measure again until within tolerance; nothing is written until asked."""

from __future__ import annotations

import datetime
import hashlib
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from autobalance.api.entry import Entry, entries
from autobalance.api.progress import Progress, telling
from autobalance.api.result import VerbResult
from autobalance.balancing.measured_crank import Crank as MeasuredCrank
from autobalance.balancing.measured_crank import measure_crank, measured_source, work_on_faces
from autobalance.errors import FileError, FormatError, JobError
from autobalance.job.model import Job
from autobalance.report.bundle import FILES, KINDS, USUAL, Choice, bundle
from autobalance.report.files import Staging
from autobalance.runtime import Stopwatch, load_in_thread

if TYPE_CHECKING:
    from autobalance.api.crank import Crank
    from autobalance.balancing.measuring import Measured
    from autobalance.balancing.record import Record

REPORT = "report.json"
SOLID = "balanced"
ABOVE_TOLERANCE = 4
IN_MEMORY_FORMAT = "ply"
"""What a crank of no file is written as: double precision, so that what was measured is what is written."""
SAME_DENSITY = 1e-9

Tell = Callable[[str], None]


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
    def reason(self) -> str | None:
        """Why above tolerance and what would fix it."""
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
        """What is permitted: keys as ``tolerance`` of the report."""
        return Entry(self.report["tolerance"])

    @property
    def corrections(self) -> tuple[Entry, ...]:
        """The cuts: keys as ``corrections`` of the report."""
        return entries(self.report["corrections"])

    @property
    def steps(self) -> tuple[Entry, ...]:
        """What each pass planned, predicted and measured."""
        return entries(self.report["steps"])

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user should know of the job and the crank."""
        return tuple(self.report["warnings"])

    @property
    def measured_on(self) -> Literal["file", "mesh", "surfaces"]:
        """What the verdict was measured on.

        ``file``: the bytes that ``write`` writes in the input's format, read back; ``mesh``: the solid's own
        triangles in double precision, for a crank of no file; ``surfaces``: the true surfaces of the STEP
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

    @cached_property
    def crank(self) -> Crank:
        """The corrected crank, in the frame of the one that came; that one where nothing was cut."""
        return corrected_crank(self)

    def __repr__(self) -> str:
        left, permitted = (
            self.report["residual"]["magnitude_g_mm"],
            self.report["tolerance"]["permissible_g_mm"],
        )
        cuts = len(self.report["corrections"])
        return (
            f"<autobalance balance: {self.outcome}, residual {left:.4g} of permitted {permitted:.4g} g·mm,"
            f" {cuts} correction{'s' * (cuts != 1)}, measured on {self.measured_on}>"
        )

    def text(self, units: str = "metric") -> str:
        """Return the summary that the command prints."""
        from autobalance.report.text import UNITS, balance_text

        return balance_text(self.report, UNITS[units])

    def write(
        self,
        folder: str | Path,
        only: tuple[str, ...] | None = None,
        *,
        paper: str = "A4",
        units: str = "metric",
        date: str | None = None,
        progress: Progress | None = None,
    ) -> tuple[Path, ...]:
        """Write the corrected solid, ``report.json`` and the pages to a folder: all files or none.

        Parameters
        ----------
        folder : path
            Made where it is missing.
        only : tuple of str or None
            Pages wanted beside solid and report: ``html``, ``pdf``, ``xlsx``, ``png``, ``dxf``; ``json``
            alone is none of them; None: all but ``dxf``.
        paper : str
            ``A4`` or ``Letter``, for ``sheet.pdf``.
        units : str
            ``metric`` or ``inch``, for the pages.
        date : str or None
            Printed on the sheet; None: today.
        progress : callable or None
            Told words and the share done.

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
        choice = choice_of(only, paper, units, date)
        folder = Path(folder)
        with Staging([folder]) as staging:
            _, files = staged(self, folder, choice, telling(progress), staging)
            staging.commit()
        return files


def balance(job: Job, crank: Crank | None = None, *, progress: Progress | None = None) -> BalanceResult:
    """Cut a crank until its residual unbalance is within tolerance, or as near as the metal allows.

    Nothing is written and nothing is printed.

    Parameters
    ----------
    job : Job
        As ``read_job`` reads it, or ``Job.from_dict`` makes it.
    crank : Crank or None
        In place of the job's crank file.
    progress : callable or None
        Told words and the share done; may raise to stop.

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
    return run(job, crank, telling(progress), Stopwatch())


def run(job: Job, given: Crank | None, tell: Tell, watch: Stopwatch) -> BalanceResult:
    """Balance a job's crank; the stopwatch may have counted what came before."""
    from autobalance.api.crank import Crank

    load_in_thread("autobalance.balancing.run", "autobalance.report.json")
    tell("reading the crank")
    if given is None:
        measured = measure_crank(job.crankshaft, watch, job.balance, work_on_faces(job))
    else:
        job = with_crank(job, given)
        found = given.measured
        with watch.stage("measure"):
            measured = measured_source(
                found.source, found.anatomy, found.density_g_mm3, job.balance, work_on_faces(job)
            )
    from autobalance.balancing.run import balanced_record  # not before: it loads while the crank is read

    record = balanced_record(job, measured, watch, tell)
    record = replace(record, warnings=(*_warnings(job, measured), *record.warnings))
    started = time.perf_counter()
    outputs = {"solid": solid_entry_of(job, measured, record)}
    watch.add("write", time.perf_counter() - started)
    return _result(
        job, replace(record, outputs=outputs, seconds=watch.seconds), Crank(measured, job.crankshaft)
    )


def with_crank(job: Job, crank: Crank) -> Job:
    """Return a job whose crank is the one given.

    Raises
    ------
    JobError
        If the job says another density, or another thing of the crankpin.
    """
    own, given = job.crankshaft, crank.crankshaft
    density, found = own.density_g_mm3, crank.measured.density_g_mm3
    if density > 0.0 and abs(density - found) > SAME_DENSITY * found:
        raise JobError(
            f"{job.path.name}: crankshaft.density_kg_m3 is {density * 1e6:g}, the crank given has"
            f" {found * 1e6:g}; needed the same, or none in the job"
        )
    overrides = replace(given.overrides, crankpin_in_file=own.overrides.crankpin_in_file)
    off = own.density_pm_g_mm3 if given.density_pm_g_mm3 is None else given.density_pm_g_mm3
    return replace(job, crankshaft=replace(given, overrides=overrides, density_pm_g_mm3=off))


def _result(job: Job, record: Record, before: Crank) -> BalanceResult:
    from autobalance.report.json import report

    return BalanceResult(report(record), job, record, before)


def _unbalance(values: Mapping[str, Any]) -> Entry:
    return Entry({**values, "resultant_g_mm": values["unbalance_g_mm"]})


def _measured(record: Record) -> Measured | None:
    assert record.balanced is not None
    return record.balanced.result.measured


def _solid_name(source: MeasuredCrank, job: Job) -> str:
    file = job.crankshaft.file
    return SOLID + (f".{IN_MEMORY_FORMAT}" if file is None else file.suffix.lower())


def solid_entry_of(job: Job, crank: MeasuredCrank, record: Record) -> dict[str, Any] | None:
    """Return what ``outputs.solid`` says of the file as it would be written; no hash without bytes."""
    from autobalance.report.json import solid_entry

    measured = _measured(record)
    if measured is None:
        return None
    digest = None if measured.data is None else hashlib.sha256(measured.data).hexdigest()
    volume = measured.moments.mass_g / crank.density_g_mm3
    return solid_entry(_solid_name(crank, job), digest, measured.triangles, measured.moments, volume)


def _warnings(job: Job, crank: MeasuredCrank) -> tuple[str, ...]:
    weights = job.engine.default.weights
    empty = [name for name in ("rotating", "reciprocating") if not getattr(weights, name)]
    unnamed = [f"{job.path.name}: engine.{name}_g names no weight; its parts count as 0 g" for name in empty]
    return (*(() if job.engine.by_throw else unnamed), *crank.warnings(job.crankshaft.file))


def corrected_crank(result: BalanceResult) -> Crank:
    """Return the crank that a run leaves, read from the bytes that would be written, in the frame it had."""
    from autobalance.api.crank import Crank
    from autobalance.solid.formats.read import source_of, source_of_bytes

    measured, before = _measured(result.record), result.before
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
        name = str(source.format).removesuffix("-ascii")
        after = source_of_bytes(measured.data, name, before.crankshaft.unit, "all")
    crank = measured_source(after, before.measured.anatomy, before.measured.density_g_mm3)
    return Crank(crank, replace(before.crankshaft, file=None))


# --- files --------------------------------------------------------------------------------------------------


def choice_of(only: tuple[str, ...] | None, paper: str, units: str, date: str | None) -> Choice:
    """Return which pages are wanted.

    Raises
    ------
    FormatError
        If a kind, the paper or the units are not known.
    """
    known = ("json", *KINDS)
    for kind in only or ():
        if kind not in known:
            raise FormatError(f"only names {kind!r}; known are {', '.join(known)}")
    if paper not in ("A4", "Letter"):
        raise FormatError(f"paper is {paper!r}; needed A4 or Letter")
    if units not in ("metric", "inch"):
        raise FormatError(f"units are {units!r}; needed metric or inch")
    kinds = tuple(kind for kind in KINDS if kind in (USUAL if only is None else only))
    return Choice(kinds, paper, units, datetime.date.today().isoformat() if date is None else date)


def staged(
    result: BalanceResult, folder: Path, choice: Choice, tell: Tell, staging: Staging
) -> tuple[dict[str, Any], tuple[Path, ...]]:
    """Stage the solid, the pages and the report; return the report and the files."""
    started = time.perf_counter()
    tell("writing")
    record, written = result.record, _measured(result.record)
    outputs = dict(record.outputs)
    files: list[Path] = []
    if result.before.measured.source.format is None:
        record, more = _input_file(result)
        staging.add(folder / more[0], more[1])
        files.append(folder / more[0])
    if written is not None:
        data = written.data if written.data is not None else _in_memory_bytes(result)
        outputs["solid"] = {**outputs["solid"], "sha256": hashlib.sha256(data).hexdigest()}
        staging.add(folder / outputs["solid"]["file"], data)
        files.append(folder / outputs["solid"]["file"])
    record = replace(_named_from(record, result, folder), outputs=outputs)
    for key, (name, page) in _pages(record, result, choice, tell).items():
        staging.add(folder / name, page)
        files.append(folder / name)
        outputs[key] = {"file": name, "sha256": hashlib.sha256(page).hexdigest()}
    seconds = dict(record.seconds)
    spent = time.perf_counter() - started
    for stage in ("write", "total"):
        seconds[stage] = seconds.get(stage, 0.0) + spent
    from autobalance.report.json import dumps, report

    values = report(replace(record, outputs=outputs, seconds=seconds))
    staging.add(folder / REPORT, dumps(values).encode())
    return values, (*files, folder / REPORT)


def _named_from(record: Record, result: BalanceResult, folder: Path) -> Record:
    """Return the record with its crank file named from the report's folder, where that can be."""
    file = result.before.file
    if file is None:
        return record
    try:
        name = Path(os.path.relpath(file.resolve(), folder.resolve())).as_posix()
    except ValueError:  # another drive
        name = str(file.resolve())
    return replace(record, input=replace(record.input, file=name))


def _in_memory_bytes(result: BalanceResult) -> bytes:
    from autobalance.solid.formats.write import encode

    assert result.record.balanced is not None
    solid = result.record.balanced.result.solid
    assert solid is not None
    return encode(solid.mesh, IN_MEMORY_FORMAT, result.before.measured.source.mm_per_unit)


def _input_file(result: BalanceResult) -> tuple[Record, tuple[str, bytes]]:
    """Return the record of a crank of no file, and the file it names, so that it can be verified."""
    from autobalance.solid.formats.write import encode

    source = result.before.measured.source
    name = f"input.{IN_MEMORY_FORMAT}"
    data = encode(source.solid.mesh, IN_MEMORY_FORMAT, source.mm_per_unit)
    digest = hashlib.sha256(data).hexdigest()
    found = replace(result.record.input, file=name, sha256=digest, format=IN_MEMORY_FORMAT)
    return replace(result.record, input=found), (name, data)


def _pages(record: Record, result: BalanceResult, choice: Choice, tell: Tell) -> dict[str, tuple[str, bytes]]:
    """Return the pages, sheets and pictures of a run."""
    if not choice.kinds:
        return {}
    from autobalance.report.json import report, showable

    assert record.balanced is not None
    cut = record.balanced.result
    values = showable(report(record))
    return bundle(values, result.before.measured.source.solid, cut.solid, cut.tools, choice, tell)


@dataclass(frozen=True, eq=False)
class BalancedFiles:
    """A run whose files are in place."""

    result: BalanceResult
    report: dict[str, Any]
    files: tuple[Path, ...]
    warnings: tuple[str, ...]


def balance_to_files(
    job: Job, folder: Path, json_file: str | None, tell: Tell, choice: Choice | None = None
) -> BalancedFiles:
    """Balance the crank of a job and write its files to ``folder``, all of them or none.

    That they can be written is proved before the work begins.

    Parameters
    ----------
    job : Job
    folder : Path
        Made where it is missing.
    json_file : str or None
        Where a copy of the report goes; ``-`` is none.
    tell : callable
        Told in a few words what runs.
    choice : Choice or None
        The pages, sheets and pictures to write beside the report; None: none.

    Raises
    ------
    AutobalanceError
        For anything wrong with the job, the crank or the folder; nothing is left behind then.
    """
    copy = None if json_file in (None, "-") else Path(str(json_file))
    choice = choice or Choice(kinds=())
    pages = [folder / name for name in FILES.values()]
    suffix = f".{IN_MEMORY_FORMAT}" if job.crankshaft.file is None else job.crankshaft.file.suffix.lower()
    solid_path = folder / (SOLID + suffix)
    targets = [folder / REPORT, solid_path, *pages] + ([copy] if copy else [])
    _refuse_overwriting(targets, [job.path, *([job.crankshaft.file] if job.crankshaft.file else [])])
    with Staging([folder] + ([copy.parent] if copy else [])) as staging:
        result = run(job, None, tell, Stopwatch())
        values, files = staged(result, folder, choice, tell, staging)
        if copy is not None:
            from autobalance.report.json import dumps

            staging.add(copy, dumps(values).encode())
        staging.commit()
    warnings = list(result.warnings)
    if values["outputs"]["solid"] is None and solid_path.exists():
        warnings.append(f"{solid_path} is of an earlier run; this one cut nothing")
    old = [page.name for page in pages if page.exists() and page not in files]
    if old:
        warnings.append(f"of an earlier run in {folder}: {', '.join(old)}; this one did not write them")
    return BalancedFiles(result, values, (*files, *([copy] if copy else [])), tuple(warnings))


def _refuse_overwriting(targets: list[Path], sources: list[Path]) -> None:
    places = [target.resolve() for target in targets]
    for place in places:
        if places.count(place) > 1:
            raise FileError(f"{place} is asked for twice: the report's copy needs a place of its own")
    for target in targets:
        if target.is_dir():
            raise FileError(f"cannot write {target}: a folder has this name")
        for source in sources:
            if target.resolve() == source.resolve():
                raise FileError(
                    f"writing {target} would destroy a file that the job reads; choose another place"
                )
