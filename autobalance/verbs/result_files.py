"""The end of a balancing run: what is written and its report, staged, all files or none.

``balance``, ``recut``, a batch's rows and the commands end here, in a folder or in memory.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from autobalance.declare import ABSENT
from autobalance.report.bundle import bundle
from autobalance.report.files import Staging, earlier_report, remove_stale, seen_from
from autobalance.report.material import Choice, FileMaterial
from autobalance.runtime import Notify

if TYPE_CHECKING:
    from autobalance.balancing.measured import Crank as MeasuredCrank
    from autobalance.balancing.measuring import Measured
    from autobalance.balancing.record import Record
    from autobalance.job import Job
    from autobalance.report.records.outputs import Solid
    from autobalance.runtime import Stopwatch
    from autobalance.verbs.crank import Crank

REPORT = "report.json"
SOLID = "balanced"
IN_MEMORY_FORMAT = "ply"
"""Format of a crank of no file: double precision, so that the written crank is the measured one."""

Values = Mapping[str, Any]
Staged = tuple[dict[str, Any], tuple[Path, ...]]
"""The report as it is written, and the files."""


class Ended(Protocol):
    """The end of a run that can be staged."""

    def staged(self, folder: Path, choice: Choice, notify: Notify, staging: Staging) -> Staged:
        """Stage all files for a folder."""
        ...


# --- as it would be written ---------------------------------------------------------------------------------


def with_outputs(record: Record, job: Job, crank: MeasuredCrank, watch: Stopwatch) -> Record:
    """Return a record with the data of its solid's file, and the time of the whole run."""
    started = time.perf_counter()
    outputs = {"solid": _solid_entry(job, crank, record), **_without_slugs(record)}
    watch.add("write", time.perf_counter() - started)
    return replace(record, outputs=outputs, seconds=watch.seconds)


def solid_name(job: Job, held_as: str = IN_MEMORY_FORMAT) -> str:
    """Return the name of the corrected solid's file: it ends as the crank's, where that can be written.

    ``held_as`` is the format of a crank of no file.
    """
    from autobalance.solid.formats.registry import written_ending

    file = job.crankshaft.file
    return SOLID + written_ending(Path(f"crank.{held_as}") if file is None else file)


def measured_of(record: Record) -> Measured | None:
    """Return the measurement of the corrected solid; None if nothing was cut."""
    assert record.balanced is not None
    return record.balanced.result.measured


def _without_slugs(record: Record) -> dict[str, bool]:
    """Say that slugs are not in the written solid, if there are any."""
    from autobalance.correction import KINDS

    assert record.balanced is not None
    corrections = record.balanced.result.corrections
    return {"solid_holds_slugs": False} if any(KINDS[each.kind].pressed_in for each in corrections) else {}


def _solid_entry(job: Job, crank: MeasuredCrank, record: Record) -> Solid | None:
    """Return ``outputs.solid`` for the file as it would be written; no hash without bytes."""
    from autobalance.report.records.crank import MassProperties
    from autobalance.report.records.outputs import Solid

    measured = measured_of(record)
    if measured is None:
        return None
    digest = None if measured.data is None else _sha256(measured.data)
    volume = measured.moments.mass_g / crank.density_g_mm3
    held_as = IN_MEMORY_FORMAT if crank.source.exact is None else str(crank.source.format)
    return Solid(
        file=solid_name(job, held_as),
        sha256=digest,
        triangles=measured.triangles,
        body=MassProperties.of(measured.moments, volume),
    )


# --- files --------------------------------------------------------------------------------------------------


def staging_for(folder: Path, copy: Path | None = None) -> Staging:
    """Return the staging of a folder's files, and of the folder of a report's copy."""
    return Staging([folder] + ([copy.parent] if copy else []))


class Committed(NamedTuple):
    """Files that a run wrote; ``notes`` are files of an earlier run that stay, as warnings."""

    values: dict[str, Any]
    files: tuple[Path, ...]
    notes: tuple[str, ...]


def committed(
    ended: Ended, folder: Path, choice: Choice, notify: Notify, staging: Staging, copy: Path | None = None
) -> Committed:
    """Stage all files of a run, a copy of the report too where one is wanted, and put them in place.

    What the report of an earlier run in the folder lists and this run does not write is removed with that.
    """
    values, files = ended.staged(folder, choice, notify, staging)
    if copy is not None:
        from autobalance.report.balance.values import dumps

        staging.add(copy, dumps(values).encode())
        files = (*files, copy)
    notes = (*remove_stale(staging, folder / REPORT, values), *_forms_of_earlier(staging, folder, values))
    staging.commit()
    return Committed(values, files, notes)


def _forms_of_earlier(staging: Staging, folder: Path, values: Values) -> Iterator[str]:
    """Remove forms of the earlier run that nobody has filled in; yield a warning for one that was."""
    from autobalance.report.output_kinds import names_to_fill

    earlier = earlier_report(folder / REPORT)
    for name in names_to_fill() if earlier is not None else ():
        path = folder / name
        if staging.writes(path) or not path.is_file():
            continue
        blank = _blank_form(earlier)
        if path.read_bytes() == blank:
            staging.remove(path)
        elif blank != _blank_form(values):
            yield f"{path} was filled in for an earlier run and stays; check that it is for this crank"


def _blank_form(values: Mapping[str, Any] | None) -> bytes | None:
    """Return the form of a report as it was written; None if it is unknown."""
    from autobalance.report.reading_template import reading_template
    from autobalance.report.records.balanced import BalancedReport

    if values is None or values.get("command") not in ("balance", "recut"):
        return None
    try:
        return reading_template(BalancedReport.read(values)).encode()
    except (KeyError, TypeError, ValueError, AttributeError):  # of another version, or changed by hand
        return None


def staged_files(
    record: Record, before: Crank, folder: Path, choice: Choice, notify: Notify, staging: Staging
) -> Staged:
    """Stage the solid, the pages and the report; return the report and the files.

    Parameters
    ----------
    record : Record
    before : Crank
        The crank as it came.
    folder : Path
        Where the files will lie; the report names others as seen from there.
    choice : Choice
        The pages wanted.
    notify : callable
    staging : Staging
    """
    from autobalance.report.output_kinds import to_fill
    from autobalance.report.records.outputs import Page

    earlier_form = _blank_form(earlier_report(folder / REPORT))
    started = time.perf_counter()
    notify("writing")
    written, outputs = measured_of(record), dict(record.outputs)
    files: list[Path] = []

    def add(name: str, data: bytes) -> None:
        staging.add(folder / name, data)
        files.append(folder / name)

    source = before.measured.source
    if source.in_memory_file is not None:
        name = f"input.{source.format}"
        record = replace(record, input=replace(record.input, file=name))
        add(name, source.in_memory_file)
    elif source.format is None:
        record, data = _with_input_file(record, before)
        add(str(record.input.file), data)
    if written is not None:
        data = written.data if written.data is not None else _in_memory_bytes(record, before)
        outputs["solid"] = replace(outputs["solid"], sha256=_sha256(data))
        add(outputs["solid"].file, data)
    record = replace(_named_from(record, before.file, folder), outputs=outputs)
    for key, (name, page) in _pages(record, before, choice, notify).items():
        if key in to_fill():
            place = folder / name
            if not place.exists() or place.read_bytes() == earlier_form:  # a reading that was filled in stays
                add(name, page)
            continue
        add(name, page)
        outputs[key] = Page(file=name, sha256=_sha256(page))
    seconds = dict(record.seconds)
    spent = time.perf_counter() - started
    for stage in ("write", "total"):
        seconds[stage] = seconds.get(stage, 0.0) + spent
    from autobalance.report.balance.values import dumps, report

    values = report(replace(record, outputs=outputs, seconds=seconds))
    add(REPORT, dumps(values).encode())
    return values, tuple(files)


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _named_from(record: Record, file: Path | None, folder: Path) -> Record:
    """Return the record with its crank and its job named from the report's folder, where that can be."""
    if record.balanced is not None:
        job = record.balanced.job
        job = {**job, "file": seen_from(folder, Path(job["file"]))}
        record = replace(record, balanced=replace(record.balanced, job=job))
    if file is None:
        return record
    scan = record.input.scan
    if scan is not ABSENT and scan.file is not None:
        scan = replace(scan, file=seen_from(folder, Path(scan.file)))
    return replace(record, input=replace(record.input, file=seen_from(folder, file), scan=scan))


def _in_memory_bytes(record: Record, before: Crank) -> bytes:
    from autobalance.solid.formats.write import encode

    assert record.balanced is not None
    solid = record.balanced.result.solid
    assert solid is not None
    return encode(solid.mesh, IN_MEMORY_FORMAT, before.measured.source.mm_per_unit)


def _with_input_file(record: Record, before: Crank) -> tuple[Record, bytes]:
    """Return the record of a crank of no file, and the file it names, so that it can be verified."""
    from autobalance.solid.formats.write import encode

    source = before.measured.source
    data = encode(source.solid.mesh, IN_MEMORY_FORMAT, source.mm_per_unit)
    name = f"input.{IN_MEMORY_FORMAT}"
    entry = replace(record.input, file=name, sha256=_sha256(data), format=IN_MEMORY_FORMAT)
    return replace(record, input=entry), data


def _pages(record: Record, before: Crank, choice: Choice, notify: Notify) -> dict[str, tuple[str, bytes]]:
    """Return the pages, sheets and pictures of a run."""
    if not choice.kinds:
        return {}
    from autobalance.report.balance.values import report, showable

    assert record.balanced is not None
    cut = record.balanced.result
    values = showable(report(record))
    crank = before.measured
    return bundle(
        FileMaterial(values, choice, crank.source.solid, cut.to_show, cut.tools, notify, crank=crank)
    )
