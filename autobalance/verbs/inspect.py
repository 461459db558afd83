"""``inspect``: measure a crank, say what was recognised in it, and add up its sections."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from autobalance.balancing.engine_from_job import with_oil
from autobalance.balancing.measured import Crank as MeasuredSolid
from autobalance.balancing.measured_crank import input_file, measure_crank, offered_faces, surfaces_entry
from autobalance.balancing.plausibility import oddities
from autobalance.balancing.record import MeasuredCrank, Record, facet_entry
from autobalance.balancing.rotor_from_job import (
    check_engine,
    crank_factor,
    default_planes_mm,
    hung_on,
    target_factor,
)
from autobalance.balancing.section_rows import SectionTable, loaded_table, section_table
from autobalance.crank.sections import Section, sections, web_weights
from autobalance.declare import ABSENT, Absent, present
from autobalance.errors import AutobalanceError, FileError, JobError
from autobalance.job import Job
from autobalance.job.from_options import KEYS, WEIGHTS, refuse_beside_job, refuse_missing, tables_of_options
from autobalance.job.read import STAND_INS, WORKBOOKS, load, load_crankshaft, tables_of
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.runtime import Progress, Stopwatch
from autobalance.solid.formats.registry import needs_unit
from autobalance.toml_files.document import with_settings
from autobalance.toml_files.typed_units import FILL_IN, leaves, length_mm
from autobalance.units import STEEL_KG_M3
from autobalance.value_classes import dataclass
from autobalance.verbs.crank import Crank, plain, read_crank
from autobalance.verbs.crank_job import OPEN, crankshaft_of_tables, job_of_tables
from autobalance.verbs.declaration import documented
from autobalance.verbs.progress import INSPECTED_BEFORE, telling
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.balancing.suggestions.wanted import Aim, Refused, Suggestion
    from autobalance.crank.against import Against
    from autobalance.crank.anatomy import Face
    from autobalance.report.records.report import Report


# The section table of ``inspect``: a crank's metal and holes, the parts that a job adds, and a verdict.


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


# ``inspect``: measure a crank and say what was recognised in it.


@dataclass(frozen=True, eq=False, repr=False)
class InspectResult(VerbResult):
    """The measured and recognised crank, with its report; ``job`` is the one that options stood for."""

    content: Report
    crank: Crank
    faces: tuple[Face, ...]
    against: Against | None = None
    job: Job | None = None

    def text(self, units: str = "metric") -> str:
        """Return the summary that the command prints."""
        from autobalance.report.balance.crank_text import inspect_text
        from autobalance.report.display_units import ON_SCREEN

        return inspect_text(self.content, ON_SCREEN[units])

    def sections_text(self, units: str = "metric") -> str:
        """Return the table of sections: with what hangs on the crank, where that was requested."""
        from autobalance.report.balance.crank_text import sections_text
        from autobalance.report.balance.sections_text import section_table_text
        from autobalance.report.display_units import ON_SCREEN

        table, u = present(self.content.section_table), ON_SCREEN[units]
        return sections_text(self.content, u) if table is None else section_table_text(table, u)

    def picture(self) -> bytes:
        """Return a PNG of the crank with its axis, pins, and faces by their ids.

        Of a scan, or compared with a drawing, it is seen a second time in the colours of its distance from
        the surfaces recognised in it, or from the drawing.
        """
        from autobalance.report.pictures.picture import crank_picture, surface_image

        measured = self.crank.measured
        below = surface_image(measured, self.against)
        return crank_picture(measured.source.solid.mesh, measured.anatomy, self.faces, below=below)


@documented
def inspect(
    crank: Crank | Job | str | Path,
    *,
    settings: Sequence[str] = (),
    table: TableOptions | None = None,
    suggest: Mapping[str, Any] | None = None,
    against: str | Path | Crank | None = None,
    progress: Progress | None = None,
    **keywords: Any,
) -> InspectResult:
    """Measure a crank and say what was recognised in it: mass, axis, journals, throws, webs, faces.

    Parameters
    ----------
    crank : Crank, Job or path
        Crank file, or a job; a job needs only its [crankshaft]. Or a crank or a job as an object.
    settings : sequence of str
        Key of the job to set before it is checked, for example crankshaft.body=1. Each as text.
    table : TableOptions or None
        Given, the report has ``section_table``: the crank's metal with its holes filled, the holes, and with
        a job its bob-weights, what sits on the crankpins and attached parts, with sums and a verdict.
    suggest : mapping or None
        Wanted inertia_kg_mm2, or balance_factor of a job, for example inertia_kg_mm2=2900, for which changes
        are suggested; alone: the job's factor. ``report["suggestions"]`` then lists the bores, weights or
        turned rims that reach it, each one tried. Empty: the job's own factor.
    against : path, Crank or None
        CAD model or another crank to compare with: distances of its surface, mass, unbalance.
    **keywords
        Arguments of ``read_crank``, if ``crank`` is a path, and keys of a job as for ``balance``. With
        rotating_g and reciprocating_g the report has ``present``, the balance factor of the crank as it is.

    Raises
    ------
    AutobalanceError
        As ``read_crank``.

    Examples
    --------
    >>> from autobalance.bundled import bundled_folder
    >>> file = bundled_folder() / "crf250r" / "drafted" / "crank.stl"
    >>> len(inspect(file, unit="mm", crankpin_in_file=False).report["crank"]["webs"])
    2
    """
    notify, watch, of_options = telling(progress, INSPECTED_BEFORE), Stopwatch(), None
    source: Crank | Job | str | Path = crank
    if not isinstance(crank, Crank):
        notify("reading and measuring the crank")
        with watch.stage("load"):
            crank, job = _read(crank, settings, keywords)
        if job is not None:
            source, settings = job, ()
        of_options = job
    elif keywords:
        raise TypeError(f"{', '.join(keywords)}: a crank that is read already takes no keywords")
    with watch.stage("plan"):
        notify("looking for faces")
        crank = crank.with_faces()
        measured = crank.measured
        faces = offered_faces(measured)
        notify("weighing the sections")
        parts = sections(measured.source.solid, measured.anatomy, measured.density_g_mm3)
    warnings = measured.warnings(crank.file, whole_job(source, settings))
    weighed = None
    if table is not None:
        notify("weighing attached parts")
        weighed, more = weighed_table(crank, parts, source, settings, table)
        warnings = (*warnings, *more)
    hung_on = loaded(crank, source, settings)
    warnings = (*warnings, *hung_on.warnings)
    suggested = None
    if suggest is not None:
        notify("trying changes that would reach it")
        suggested = _suggested(measured, _job_of(source, settings), suggest)
    held = None
    if against is not None:
        notify("holding the crank against the drawing")
        held = _held_against(crank, against)
    record = Record(
        command="inspect",
        input=input_file(crank.file, measured),
        crank=MeasuredCrank(
            measured.moments,
            measured.volume_mm3,
            measured.anatomy,
            facet_entry(measured.facets, measured.correction),
            measured.calibration,
            measured.mass_pm_g,
        ),
        initial=Unbalance.of(measured.moments),
        surfaces=surfaces_entry(measured),
        planes_z_mm=default_planes_mm(measured.anatomy),
        faces=faces,
        sections=parts,
        web_weights=web_weights(parts, measured.anatomy),
        warnings=warnings,
        seconds=watch.seconds,
        job_set=tuple(settings),
        section_table=weighed,
        loaded=hung_on.table,
        present=hung_on.present,
        suggested=suggested,
        against=measured.beside.against if held is None and measured.beside is not None else held,
    )
    from autobalance.report.records.report import Report

    offered = tuple(candidates.face for candidates in faces)
    return InspectResult(Report.of(record), crank, offered, held, of_options)


def _held_against(crank: Crank, against: Crank | str | Path) -> Against:
    """Compare a crank with its CAD model, in the same unit if the model's format carries no unit."""
    from autobalance.balancing.measured_crank import against_drawing

    own = crank.crankshaft
    if not isinstance(against, Crank):
        path = Path(against)
        against = read_crank(
            path,
            unit=(own.unit or "mm") if needs_unit(path) else None,
            density_kg_m3=crank.density_kg_m3,
            crankpin_in_file=own.overrides.crankpin_in_file,
        )
    return against_drawing(crank.measured, against.measured, str(against.file or "in memory"))


def _job_of(source: Crank | Job | str | Path, settings: Sequence[str]) -> Job | None:
    """Return the whole job that was given, if one was."""
    if isinstance(source, Job):
        return source
    if isinstance(source, Crank) or Path(source).suffix.lower() not in (".toml", *WORKBOOKS):
        return None
    return load(source, settings)


def _suggested(
    measured: MeasuredSolid, job: Job | None, suggest: Mapping[str, Any]
) -> tuple[Aim, Sequence[Suggestion], Sequence[Refused]]:
    """Return changes of a crank for a wanted factor or inertia: bores, weights, turned rims."""
    from autobalance.balancing.engine_from_job import with_oil
    from autobalance.balancing.rotor_from_job import target_factor
    from autobalance.balancing.suggestions.metal import suggested_metal
    from autobalance.balancing.suggestions.wanted import Aim, Wanted

    job = None if job is None else with_oil(job, measured)
    if not suggest and job is not None:
        suggest = {"balance_factor": target_factor(job, measured.anatomy, measured.moments)}
    aim = Aim.of(Wanted.of(suggest), measured.moments, measured.anatomy, None if job is None else job.engine)
    solid = measured.source.solid.moved(measured.anatomy.file_to_rotor)
    return (aim, *suggested_metal(solid, measured.density_g_mm3, aim))


def _read(
    source: Job | str | Path, settings: Sequence[str], keywords: dict[str, Any]
) -> tuple[Crank, Job | None]:
    """Read the crank of a file or of a job; with a file and weights, the job that these stand for too."""
    if not isinstance(source, Job) and Path(source).suffix.lower() not in (".toml", *WORKBOOKS):
        options = {name: value for name in KEYS if (value := keywords.get(name)) is not None}
        if not settings and not set(options) - {"unit", "density_kg_m3"}:
            return read_crank(
                source, **{name: keywords[name] for name in keywords if name not in KEYS}, **options
            ), None
        return _read_with_options(Path(source), settings, keywords, options)
    refuse_beside_job({name: value for name, value in keywords.items() if name in KEYS}, source)
    if keywords:
        raise TypeError(f"{', '.join(keywords)}: set it in the job instead")
    crankshaft = source.crankshaft if isinstance(source, Job) else load_crankshaft(source, settings)
    return Crank(measure_crank(crankshaft, Stopwatch()), crankshaft), None


def _read_with_options(
    path: Path, settings: Sequence[str], keywords: Mapping[str, Any], options: Mapping[str, Any]
) -> tuple[Crank, Job | None]:
    """Read the crank of a file with options, as ``_read``."""
    if not path.exists():  # before its unit is asked for
        raise FileError(f"{path} does not exist")
    tables = tables_of_options(options, settings)
    said = tables["crankshaft"]
    for name, value in keywords.items():
        if name not in KEYS and value is not None and (name, value) != ("fill_holes_mm", 0.0):
            said.setdefault(name, plain(value))
    if not {"density", "density_kg_m3"} & set(said):
        said["density_kg_m3"] = STEEL_KG_M3
    crankshaft = crankshaft_of_tables(path, said)
    weights = [name for name in WEIGHTS if tables["engine"].get(name)]
    if weights:
        missing = [name for name in WEIGHTS if name not in weights]
        refuse_missing("inspect", path, missing, options, settings)
    crank = Crank(measure_crank(crankshaft, Stopwatch()), crankshaft)
    job = job_of_tables(path, tables, may_lack=OPEN["inspect"]) if weights else None
    return crank, job
