"""``inspect``: measure a crank and say what was recognised in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.balancing.chordal_correction import facet_entry
from autobalance.balancing.faces import offered_faces
from autobalance.balancing.measured import Crank as MeasuredSolid
from autobalance.balancing.measured_crank import input_file, measure_crank, surfaces_entry
from autobalance.balancing.record import MeasuredCrank, Record
from autobalance.balancing.rotor_from_job import default_planes_mm
from autobalance.crank.sections import sections, web_weights
from autobalance.declare import present
from autobalance.errors import FileError
from autobalance.job import Job
from autobalance.job.from_options import KEYS, WEIGHTS, refuse_beside_job, refuse_missing, tables_of_options
from autobalance.job.read import WORKBOOKS, load, load_crankshaft
from autobalance.rigid_rotor.unbalance import Unbalance
from autobalance.runtime import Progress, Stopwatch
from autobalance.solid.formats.registry import needs_unit
from autobalance.units import STEEL_KG_M3
from autobalance.verbs.common_parameters import documented
from autobalance.verbs.crank import Crank, plain, read_crank
from autobalance.verbs.crank_job import OPEN, crankshaft_of_tables, job_of_tables
from autobalance.verbs.inspect_sections import TableOptions, loaded, weighed_table, whole_job
from autobalance.verbs.progress import INSPECTED_BEFORE, telling
from autobalance.verbs.result import VerbResult

if TYPE_CHECKING:
    from autobalance.balancing.suggestions.wanted import Aim, Refused, Suggestion
    from autobalance.crank.against import Against
    from autobalance.crank.anatomy import Face
    from autobalance.report.records.report import Report


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
        from autobalance.report.balance.section_text import section_table_text
        from autobalance.report.display_units import ON_SCREEN

        table, u = present(self.content.section_table), ON_SCREEN[units]
        return sections_text(self.content, u) if table is None else section_table_text(table, u)

    def picture(self) -> bytes:
        """Return a PNG of the crank with its axis, pins, and faces by their ids.

        Of a scan, or compared with a drawing, it is seen a second time in the colours of its distance from
        the surfaces recognised in it, or from the drawing.
        """
        from autobalance.report.pictures.anatomy import crank_picture
        from autobalance.report.pictures.deviation import surface_image

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
    from autobalance.balancing.against import against_drawing

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
    from autobalance.balancing.oil_from_job import with_oil
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
