"""The section table of ``inspect``: a crank's metal and holes, the parts that a job adds, and a verdict."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from autobalance.balancing.oil_from_job import with_oil
from autobalance.balancing.plausibility import oddities
from autobalance.balancing.rotor_from_job import (
    check_engine,
    crank_factor,
    default_planes_mm,
    hung_on,
    target_factor,
)
from autobalance.balancing.section_rows import SectionTable, loaded_table, section_table
from autobalance.crank.sections import Section
from autobalance.declare import ABSENT, Absent
from autobalance.errors import AutobalanceError, JobError
from autobalance.job import Job
from autobalance.job.read import STAND_INS, WORKBOOKS, load, tables_of
from autobalance.toml_files.settings import with_settings
from autobalance.toml_files.typed_units import FILL_IN, leaves, length_mm
from autobalance.verbs.crank import Crank

DATUMS = ("A", "B", "front", "rear", "centre")
WITHOUT_VERDICT = "is not filled in: the section table is of the bare crank, without verdict"


@dataclass(frozen=True)
class TableOptions:
    """Options of the section table.

    Attributes
    ----------
    datum : float or str
        Plane about which couples count: z in the rotor frame [mm], or a length with its unit. ``"A"`` or
        ``"B"`` is a tolerance plane. ``"front"`` or ``"rear"`` is the end of the crank of smallest or largest
        z. ``"centre"`` is the centre of mass.
    oil_density_kg_m3 : float or None
        Of the oil that fills bores and drillings; None: the job's, ``[engine.oil]``, if it has any.
    """

    datum: float | str = 0.0
    oil_density_kg_m3: float | None = None


def weighed_table(
    crank: Crank,
    parts: Sequence[Section],
    source: Crank | Job | str | Path,
    settings: Sequence[str],
    options: TableOptions,
) -> tuple[tuple[SectionTable, float], list[str]]:
    """Return the section table with the plane that its moments are about [mm], and warnings.

    Raises
    ------
    AutobalanceError If the job is wrong, the oil counts twice, or the datum is unknown.
    """
    job, warnings = _whole_job(source, settings)
    if job is not None and job.lacks:
        key = min(job.lacks)
        warnings = [f"{job.path}: {key} {WITHOUT_VERDICT}"]
        job = None
    measured, oil, factor = crank.measured, options.oil_density_kg_m3, 0.0
    if oil is not None and not 0.0 < oil < math.inf:
        raise JobError(f"oil_density_kg_m3 is {oil:g}; must be > 0")
    if job is not None:
        check_engine(job, measured.anatomy)
        if oil is not None:
            _refuse_oil_twice(job, len(measured.anatomy.throws))
        oiled = with_oil(job, measured)
        warnings += oddities(oiled, measured)
        factor = target_factor(oiled, measured.anatomy, measured.moments)
    table = section_table(measured, parts, job, factor, oil)
    return (table, _datum_mm(options.datum, crank, table)), warnings


class Loaded(NamedTuple):
    """Parts that a job adds to its crank.

    ``table`` is the crank with all of them, None if the job has no permissible unbalance. ``present`` is the
    balance factor of the crank with these parts: None if its throws cancel, absent without weights.
    ``warnings`` are the reasons.
    """

    table: SectionTable | None = None
    present: float | Absent | None = ABSENT
    warnings: Sequence[str] = ()


def loaded(crank: Crank, source: Crank | Job | str | Path, settings: Sequence[str]) -> Loaded:
    """Return a job's crank with its parts; nothing if no job was given, or its weights are missing.

    What is wrong with the job's other tables is a warning: a crank can be inspected without them.
    """
    present: float | Absent | None = ABSENT
    try:
        job, _ = _whole_job(source, settings)
        if job is None:
            return Loaded()
        measured = crank.measured
        check_engine(job, measured.anatomy)
        _refuse_no_crankpin(job, crank)
        oiled = with_oil(job, measured)
        loads, beside = hung_on(oiled, measured.anatomy)
        if any(each.parts.reciprocating_on_throw_g > 0.0 for each in loads):
            present = crank_factor(measured.moments, loads, beside)
        if job.lacks:
            return Loaded(present=present)
        factor = target_factor(oiled, measured.anatomy, measured.moments)
        return Loaded(loaded_table(measured, job, factor), present)
    except AutobalanceError as error:
        return Loaded(None, present, [f"{error}; the crank is inspected without its bob-weights"])


def _refuse_no_crankpin(job: Job, crank: Crank) -> None:
    """Refuse the weights of a crank that is without its crankpins in the file and in the job."""
    if not crank.measured.holds_crankpins and job.crankshaft.crankpin_in_file:
        raise JobError(
            f"{crank.file}: the file is without crankpins, and their weight is missing: --crankpin-g, or in a"
            " job engine.crankpin_g.crankpin with crankshaft.crankpin_in_file = false"
        )


def whole_job(source: Crank | Job | str | Path, settings: Sequence[str]) -> Job | None:
    """Return the job of an inspected crank, if one was given with all its tables."""
    try:
        job = _whole_job(source, settings)[0]
    except AutobalanceError:  # reported by ``loaded``
        return None
    return None if job is None or job.lacks else job


def _whole_job(source: Crank | Job | str | Path, settings: Sequence[str]) -> tuple[Job | None, list[str]]:
    """Return the job, and the reason for its absence if one was given."""
    if isinstance(source, Job):
        return source, []
    if isinstance(source, Crank) or Path(source).suffix.lower() not in (".toml", *WORKBOOKS):
        return None, []
    values = with_settings(tables_of(Path(source)), settings)
    left = [key for key, value in leaves(values) if value == FILL_IN and key not in STAND_INS]
    left = [key for key in left if not key.startswith("original.")]
    left += ["[engine]"] if "engine" not in values else []
    if left:
        return None, [f"{source}: {left[0]} {WITHOUT_VERDICT}"]
    return load(source, settings, STAND_INS), []


def _refuse_oil_twice(job: Job, throws: int) -> None:
    if any("oil" in job.engine.of_throw(number).weights.crankpin for number in range(1, throws + 1)):
        raise JobError(
            f"{job.path.name}: engine.crankpin_g.oil is given beside --oil-density-kg-m3; must be one or"
            " the other: the oil would count twice"
        )


def _datum_mm(datum: float | str, crank: Crank, table: SectionTable) -> float:
    """Return z of the plane about which couples count [mm]."""
    if isinstance(datum, int | float):
        if not math.isfinite(datum):
            raise JobError(f"datum is {datum:g}; must be a number [mm] or one of {', '.join(DATUMS)}")
        return float(datum)
    if datum in ("A", "B"):
        own = default_planes_mm(crank.measured.anatomy)
        planes = own if table.tolerance is None else table.tolerance.places_mm
        if planes is None:
            raise JobError(f"datum is {datum}, but there are no tolerance planes; give a number [mm]")
        return planes["AB".index(datum)]
    if datum == "centre":
        return float(crank.centre_of_mass_mm[2])
    if datum in ("front", "rear"):
        turn = crank.file_to_rotor[2]
        heights = crank.vertices_mm @ turn[:3] + turn[3]
        return float(heights.min() if datum == "front" else heights.max())
    return length_mm(datum, "datum")
