"""A crank's file in place of a job: the job that options stand for, and its file beside the results."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeGuard

from autobalance.balancing.measured_crank import measure_crank
from autobalance.errors import AutobalanceError, BodiesError, FileError, JobError, RecognitionError
from autobalance.job import Job, JobSource, as_job, from_options, parse
from autobalance.job.layout import with_shop
from autobalance.job.model import Crankshaft
from autobalance.job.read import STAND_INS, load
from autobalance.job.read_crankshaft import read_crankshaft
from autobalance.report.files import Staging, seen_from
from autobalance.runtime import Stopwatch
from autobalance.solid.formats.table import endings
from autobalance.toml_files.typed_units import in_base_units

OPEN: Mapping[str, Collection[str]] = {
    "balance": (),
    "compare": (),
    "study": (),
    "forces": ("balance.factor", "balance.grade", "correction.method"),
    "parts": tuple(STAND_INS),
    "factor": tuple(STAND_INS),
    "inspect": tuple(STAND_INS),
}
"""Verb → keys of its job that may be missing or left to fill in."""


def options_of_crank(
    *,
    unit: str | None = None,
    density_kg_m3: float | str | None = None,
    material: str | None = None,
    rotating_g: float | str | None = None,
    reciprocating_g: float | str | None = None,
    crankpin_g: float | str | None = None,
    rods_per_throw: int | None = None,
    stroke_mm: float | str | None = None,
    rod_length_mm: float | str | None = None,
    factor: float | str | None = None,
    grade: float | str | None = None,
    speed_rpm: float | str | None = None,
    method: str | Sequence[str] | None = None,
) -> from_options.Options:
    """Return the options of a crank's file in place of a job, by name; each stands for a key of the job.

    Parameters
    ----------
    unit : {"mm", "cm", "m", "inch"} or None
        Unit of length, required if the format has no unit; None: the format's.
    density_kg_m3 : float or str or None
        Density [kg/m³], required unless the material is named.
    material : str or None
        Name of a material, in place of the density; ``autobalance calc density`` lists them.
    rotating_g : float or str or None
        Rotating mass of one rod, in g or with its unit, such as 4.7 oz.
    reciprocating_g : float or str or None
        Reciprocating mass of one rod with its piston, in g or with its unit.
    crankpin_g : float or str or None
        Mass of the crankpin in g or with its unit, for a pressed-up crank whose file has
        no crankpin.
    rods_per_throw : int or None
        Number of rods on each crankpin; None: 1.
    stroke_mm : float or str or None
        Stroke to check the file against [mm].
    rod_length_mm : float or str or None
        Rod length, eye to eye [mm]; for forces.
    factor : float or str or None
        Balance factor, 0 to 1, or original; None: original if original weights are set.
    grade : float or str or None
        Balance quality grade G, as 6.3 or G6.3.
    speed_rpm : float or str or None
        Maximum service speed [rpm].
    method : str or sequence of str or None
        Correction method, or several with commas; None: drill.
    """
    return {
        "unit": unit,
        "density_kg_m3": density_kg_m3,
        "material": material,
        "rotating_g": rotating_g,
        "reciprocating_g": reciprocating_g,
        "crankpin_g": crankpin_g,
        "rods_per_throw": rods_per_throw,
        "stroke_mm": stroke_mm,
        "rod_length_mm": rod_length_mm,
        "factor": factor,
        "grade": grade,
        "speed_rpm": speed_rpm,
        "method": method,
    }


def is_crank(source: object) -> TypeGuard[str | Path]:
    """Return whether a verb's source is a crank's file rather than a job."""
    return isinstance(source, str | os.PathLike) and Path(source).suffix.lower() in endings()


def job_given(
    verb: str,
    source: JobSource,
    options: from_options.Options,
    settings: Sequence[str] = (),
    folder: str | Path | None = None,
    more_open: Collection[str] = (),
) -> Job:
    """Return the job of a verb: as it was given, or the one that options on a crank's file stand for.

    Parameters
    ----------
    verb : str
        Its name, for what it needs.
    source : Job, path or dict
        Job, or the file of a crank.
    options : mapping
        Options of ``options_of_crank``.
    settings : sequence of str
        Keys of the job to set.
    folder : path or None
        Folder of the results, where the job's file will be; None: ``NAME-balanced`` in the working folder.
    more_open : collection of str
        Further keys that may be missing.

    Raises
    ------
    UsageError
        If options that stand for keys are given beside a job, or are unknown.
    AutobalanceError
        For anything missing or wrong.
    """
    _refuse_unknown(verb, options)
    may_lack = (*OPEN[verb], *more_open)
    if not is_crank(source):
        if from_options.given(options):
            named = Path(source).name if isinstance(source, str | os.PathLike) else "what was given"
            from_options.refuse_beside_job(options, named)
        return as_job(source, settings, may_lack)
    crank = Path(source)
    if not crank.exists():
        raise FileError(f"{crank} does not exist")
    tables = from_options.tables_of_options(options, settings)
    missing = from_options.missing_options(verb, crank, tables)
    from_options.refuse_missing(
        verb, crank, [n for n in missing if from_options.KEYS[n] not in may_lack], options, settings
    )
    return job_of_tables(crank, tables, folder, may_lack)


def _refuse_unknown(verb: str, options: from_options.Options) -> None:
    unknown = [name for name in options if name not in from_options.KEYS]
    if unknown:
        raise TypeError(f"{verb}() got an unexpected keyword argument {unknown[0]!r}")


def job_of_tables(
    crank: Path, tables: Mapping[str, Any], folder: str | Path | None = None, may_lack: Collection[str] = ()
) -> Job:
    """Return the job of a crank's file with tables of keys; its file will be in the folder of the results."""
    place = (default_folder(crank) if folder is None else Path(folder)) / from_options.JOB_NAME
    named = {"file": seen_from(place.parent, crank), **tables["crankshaft"]}
    own = from_options.with_shop_of({**tables, "crankshaft": named}, crank)
    job = parse(with_shop(own, place.parent), place, may_lack=may_lack)
    crankshaft = replace(job.crankshaft, file=crank)  # the folder of the results may not be there yet
    return replace(
        job,
        crankshaft=crankshaft,
        unwritten=from_options.filled_in(own, [key for key in STAND_INS if key in job.lacks]),
    )


def crankshaft_of_tables(crank: Path, said: Mapping[str, Any]) -> Crankshaft:
    """Return a crank's file with its keys; whether it holds the crankpins is left open unless stated."""
    named = {"file": str(crank), **said}
    read_as = read_crankshaft(in_base_units({"crankshaft": named})["crankshaft"], Path())
    if "crankpin_in_file" in said:
        return read_as
    return replace(read_as, overrides=replace(read_as.overrides, crankpin_in_file=None))


@contextmanager
def pressed_up_told(job: Job) -> Iterator[None]:
    """Ask for the crankpin's weight where the crank of a job of options turns out to be without its crankpin.

    Raises
    ------
    JobError
        In place of an error about the file's bodies or journals.
    """
    try:
        yield
    except (BodiesError, RecognitionError):
        tables = {} if job.unwritten is None else job.unwritten["crankshaft"]
        if job.unwritten is None or "crankpin_in_file" in tables or not _is_pressed_up(job):
            raise
        raise JobError(
            f"{job.crankshaft.file} holds a pressed-up crank without its crankpin: --crankpin-g is missing,"
            " the weight of the crankpin"
        ) from None


def _is_pressed_up(job: Job) -> bool:
    """Return whether a crank's file holds the pieces of a pressed-up crank without its crankpins."""
    overrides = replace(job.crankshaft.overrides, crankpin_in_file=False)
    try:
        measure_crank(replace(job.crankshaft, overrides=overrides), Stopwatch())
    except AutobalanceError:
        return False
    return True


def default_folder(crank: Path) -> Path:
    """Return the folder of the results of a crank's file: in the working folder."""
    return Path(f"{crank.stem}-balanced")


def job_file(job: Job, folder: Path) -> bytes:
    """Return the file of a job that stands for options, with its crank as seen from a folder."""
    assert job.unwritten is not None
    tables = dict(job.unwritten)
    if job.crankshaft.file is not None:
        tables["crankshaft"] = {**tables["crankshaft"], "file": seen_from(folder, job.crankshaft.file)}
    return from_options.job_text(tables).encode()


def refuse_changed(job: Job, folder: Path) -> None:
    """Refuse to write the job of options over a job that somebody changed.

    Raises
    ------
    FileError
        If the job file exists.
    """
    place = folder / from_options.JOB_NAME
    if job.unwritten is not None and from_options.was_changed(place):
        raise FileError(
            f"{place} was changed and would be lost; run `autobalance balance {place}`, or choose another"
            " folder with -o"
        )


def staged_job(job: Job, folder: Path, staging: Staging) -> tuple[Path, ...]:
    """Stage the file of a job that stands for options; nothing of one that has its file."""
    if job.unwritten is None:
        return ()
    staging.add(folder / from_options.JOB_NAME, job_file(job, folder))
    return (folder / from_options.JOB_NAME,)


def write_job(job: Job | None) -> None:
    """Write the file of a job that stands for options, if no other exists."""
    files = {} if job is None else new_job_file(job)
    with Staging(sorted({path.parent for path in files})) as staging:
        for path, data in files.items():
            staging.add(path, data)
        staging.commit()


def new_job_file(job: Job) -> dict[Path, bytes]:
    """Return the file of a job that stands for options, if no other exists; for verbs that only compute."""
    if job.unwritten is None or job.path.exists():
        return {}
    return {job.path: job_file(job, job.path.parent)}


# Jobs as objects.


def read_job(path: str | Path, settings: Sequence[str] = ()) -> Job:
    """Read a job file.

    Parameters
    ----------
    path : path
        A TOML file, or a workbook as ``init`` writes it; the crank file it names is relative to it.
    settings : sequence of str
        Keys to set before anything is checked: ``["balance.factor=0.5"]``.

    Returns
    -------
    Job
        ``Job.from_dict`` makes one of a mapping.

    Raises
    ------
    FileError
        If it cannot be read.
    JobError
        If it is not TOML, or a key is unknown, missing, of the wrong type or impossible.

    Examples
    --------
    >>> from autobalance.bundled import bundled_folder
    >>> file = bundled_folder() / "crf250r" / "drafted" / "factor-0.28.toml"
    >>> read_job(file, ["balance.factor=0.5"]).balance.factor
    0.5
    """
    return load(path, settings)
