"""The work of a separate process: one verb on one job, its progress sent through a pipe."""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance import registry
from autobalance.browser.analyses import ANALYSES, keywords_of
from autobalance.browser.project import Project
from autobalance.profile_search.input import START_TABLES
from autobalance.runtime import own_standard_output
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import parameters_of

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from autobalance.report.material import FileMaterial
    from autobalance.runtime import Progress
    from autobalance.verbs.balance import BalanceResult
    from autobalance.verbs.crank import Crank
    from autobalance.verbs.result import VerbResult

MESH = "mesh.bin"
VIEW = "view.bin"
MODEL = "model.json"
CARDS = "cards.json"
WEBS = "webs.json"
SHEET = "sheet.pdf"
DRAWING = "dxf"
REPORT = "report.json"
SUMMARY = "summary.txt"
PAPERS = ("certificate", "card", "csv")
"""Kinds of files that the page gives beside those that the command writes."""
MEGABYTE = 1 << 20
CARD_PIXELS = (560, 380)
"""Size of a picture on the board of alternatives."""
SOLID_READ_SHARE = 0.2
"""The share of ``inspect`` at which its solid can be looked at."""

DRAWING_SHARE = 0.6
"""The share of an analysis at which its plots are drawn."""

Asked = dict[str, Any]


@dataclass(frozen=True)
class RunFolders:
    """Folders of a run's files and results; ``own`` is for the page alone."""

    project: Path
    results: Path
    own: Path

    def keep(self, name: str, data: bytes) -> None:
        """Write one of the page's own files: whole, for the page may ask for it at any time."""
        self.own.mkdir(parents=True, exist_ok=True)
        (self.own / f"{name}.part").write_bytes(data)
        (self.own / f"{name}.part").replace(self.own / name)


def work(verb: str, request: Asked, folders: tuple[str, ...], memory_mb: int, pipe: Connection) -> None:
    """Run a verb and write its results; send words, share and the end through ``pipe``."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's to deal with
    own_standard_output()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("MPLBACKEND", "agg")
    limit_memory(memory_mb)
    from autobalance.errors import AutobalanceError

    def notify(words: str, share: float) -> None:
        pipe.send(("progress", words, share))

    try:
        code = {**VERBS, **ASIDE}[verb](request, RunFolders(*(Path(each) for each in folders)), notify)
        pipe.send(("done", code))
    except AutobalanceError as error:
        pipe.send(("failed", error.exit_code, Project(Path(folders[0])).as_named(str(error))))
    except MemoryError:
        pipe.send(
            ("failed", AutobalanceError.exit_code, f"not enough memory for this file in {memory_mb} MB")
        )
    finally:
        pipe.close()


def nothing() -> None:
    """Do nothing: the first process of all loads what the others need."""


def limit_memory(memory_mb: int) -> None:
    """Keep a file that unpacks without end from taking the machine's memory."""
    if sys.platform == "win32":
        return
    import resource

    resource.setrlimit(resource.RLIMIT_AS, (memory_mb * MEGABYTE, memory_mb * MEGABYTE))


# --- verbs --------------------------------------------------------------------------------------------------


def _inspect(request: Asked, place: RunFolders, notify: Progress) -> int:
    import autobalance as ab
    from autobalance.browser.meshes import recognised_mesh

    notify("reading", 0.0)
    result = ab.inspect(_read(request["job"].get("crankshaft", {}), place, notify), progress=notify)
    notify("drawing", 0.9)
    place.keep(MESH, recognised_mesh(result))
    place.keep(MODEL, json.dumps({"crankpin_in_file": result.crank.measured.holds_crankpins}).encode())
    _report(place, result)
    return 0


def _read(table: Asked, place: RunFolders, notify: Progress) -> Crank:
    """Read and measure the crank of a job; its solid is there to be looked at before it is recognised."""
    from autobalance.balancing.measured_crank import read_crank, recognise_and_measure
    from autobalance.browser.meshes import bare_mesh
    from autobalance.errors import BodiesError, RecognitionError
    from autobalance.job.read_crankshaft import read_crankshaft
    from autobalance.toml_files.typed_units import in_base_units
    from autobalance.verbs.crank import Crank

    crankshaft = read_crankshaft(in_base_units({"crankshaft": table})["crankshaft"], place.project)
    if "crankpin_in_file" not in table:
        crankshaft = replace(crankshaft, overrides=replace(crankshaft.overrides, crankpin_in_file=None))

    try:
        source = read_crank(crankshaft)
    except BodiesError:  # for a user to say which of them is the crank
        united = read_crank(replace(crankshaft, body="all"))
        place.keep(MESH, bare_mesh(united.solid.mesh, ()))
        raise
    mesh = source.solid.mesh
    place.keep(MESH, bare_mesh(mesh, ()))
    notify("recognising", SOLID_READ_SHARE)
    try:
        return Crank(recognise_and_measure(crankshaft, source), crankshaft)
    except RecognitionError:  # for a user to say what is what
        from autobalance.crank.recognition.candidates import cylinder_candidates

        place.keep(MESH, bare_mesh(mesh, cylinder_candidates(mesh)))
        raise


def _scale(request: Asked, place: RunFolders, notify: Progress) -> int:
    """Write the file of a crank scaled to a known stroke; the earlier file stays."""
    from autobalance.browser.cranks import scaled_crank

    notify("scaling", 0.1)
    stroke = float(request["stroke_mm"])
    file = str(request["job"]["crankshaft"]["file"])
    name = scaled_crank(Project(place.project), file, float(request["factor"]), stroke)
    place.results.mkdir(parents=True, exist_ok=True)
    values = {"command": "scale", "scaled": file, "factor": request["factor"], "stroke_mm": stroke}
    (place.results / REPORT).write_text(json.dumps({**values, "file": name}), encoding="utf-8")
    return 0


def _balance(request: Asked, place: RunFolders, notify: Progress) -> int:
    import autobalance as ab

    result = ab.balance(ab.Job.from_dict(request["job"], folder=place.project), progress=notify)
    return _written(result, place, notify)


def _recut(request: Asked, place: RunFolders, notify: Progress) -> int:
    """Cut further by a reading; what it leaves empty of the machine is as in a reading.toml to fill in."""
    import autobalance as ab
    from autobalance.report.reading_template import UMAR_G_MM, URR_PERCENT

    report = place.results.parent / request["run"] / REPORT
    usual = {"urr_percent": URR_PERCENT, "umar_g_mm": UMAR_G_MM}
    reading = {key: value for key, value in request["reading"].items() if key not in usual or value != ""}
    trusted = bool(request.get("trust_reading"))
    result = ab.recut(
        report, {**usual, **reading}, folder=place.results, trust_reading=trusted, progress=notify
    )
    return _written(result, place, notify)


def _nc(request: Asked, place: RunFolders, notify: Progress) -> int:
    """Write the NC programs of a result on a machine whose file was pasted into the page."""
    import autobalance as ab
    from autobalance.toml_files.document import toml_of

    report = place.results.parent / request["run"] / REPORT
    result = ab.nc(report, toml_of(request["machine"], "machine file"), progress=notify)
    result.write(place.results)
    _report(place, result)
    return result.exit_code


def _written(result: BalanceResult, place: RunFolders, notify: Progress) -> int:
    """Write the command's files, and the page's view of them."""
    from autobalance.browser.meshes import result_view
    from autobalance.browser.prediction import linear_model
    from autobalance.declare import encoded
    from autobalance.paper.sheet import set_up_letter
    from autobalance.report.balance.zero import with_design_radii
    from autobalance.report.bundle import bundle

    result.write(place.results, progress=notify)
    notify("writing certificate, card and drawing", 0.97)
    material = _material(result)
    papers = dict(bundle(material).values())
    for name, data in papers.items():
        place.keep(name, data)
    place.keep(WEBS, _webs(material))
    drawn = with_design_radii(material.balanced).corrections  # the radii that the papers have
    radii = [each.shown_radius_mm for each in drawn]
    setups = [set_up_letter(each) for each in drawn]
    model = {**encoded(linear_model(result)), "papers": list(papers), "radii_mm": radii, "setups": setups}
    place.keep(MODEL, json.dumps(model, allow_nan=False).encode())
    place.keep(VIEW, result_view(result))
    return result.exit_code


def _material(result: BalanceResult) -> FileMaterial:
    """Return the material of what the command writes only on request; of the drawing with its extra."""
    from autobalance.errors import FormatError
    from autobalance.report.balance.values import showable
    from autobalance.report.bundle import choice_of
    from autobalance.report.material import FileMaterial
    from autobalance.report.output_kinds import KINDS

    record = result.record.balanced
    assert record is not None
    kinds = [*PAPERS]
    try:
        KINDS[DRAWING].require()
        kinds += [DRAWING] if result.corrections else []
    except FormatError:  # without its extra
        pass
    before, report = result.before.measured.source.solid, showable(result.report)
    units = result.typed_report.given.shop.units or "metric"
    ended = record.result
    return FileMaterial(
        report, choice_of(kinds, "A4", units), before, ended.solid, ended.tools, lambda _: None
    )


def _webs(material: FileMaterial) -> bytes:
    """Return the webs that are cut on their degree wheels, and sections, as the sheet draws them; as JSON."""
    from dataclasses import asdict

    from autobalance.paper.svg_pen import section_drawings, web_drawings
    from autobalance.report.balance.zero import with_design_radii

    report = with_design_radii(material.balanced)
    given = report, material.drawings, material.choice.units
    drawn = [*web_drawings(*given), *section_drawings(*given)] if report.corrections else []
    return json.dumps([asdict(each) for each in drawn]).encode()


def _compare(request: Asked, place: RunFolders, notify: Progress) -> int:
    """Compare the kinds; those that come within tolerance are drawn. Cards are there as they are done."""
    import autobalance as ab
    from autobalance.balancing.measured_crank import measure_crank
    from autobalance.runtime import Stopwatch
    from autobalance.verbs.compare import CompareResult, compared
    from autobalance.verbs.crank import Crank

    job = ab.Job.from_dict(request["job"], folder=place.project)
    notify("reading the crank", 0.0)
    crank = Crank(measure_crank(job.crankshaft, Stopwatch(), job.balance, with_faces=True), job.crankshaft)
    drawn: list[str] = []

    def keep(some: CompareResult) -> None:
        names = ("rows", "recommended", "why", "prefer", "ranking", "unbeaten")
        cards = {name: some.report[name] for name in names}
        if cards["recommended"] is not None:
            cards["recommended"] = "+".join(cards["recommended"])
        place.keep(CARDS, json.dumps({**cards, "pictures": drawn}, allow_nan=False).encode())

    result = compared(job, crank, lambda words, _: notify(words, 0.1), keep)
    rows = [row for row in result.report["rows"] if row["outcome"] == "within_tolerance"]
    place.results.mkdir(parents=True, exist_ok=True)
    for done, row in enumerate(rows):
        name = "+".join(row["method"])
        notify(f"drawing {name}", 0.4 + 0.6 * done / len(rows))
        tables = {
            **request["job"],
            "correction": {**request["job"].get("correction", {}), "method": row["method"]},
        }
        picture = _picture(ab.balance(ab.Job.from_dict(tables, folder=place.project), crank))
        place.keep(f"{name}.png", picture)
        (place.results / f"{name}.png").write_bytes(picture)
        drawn.append(name)
        keep(result)
    _report(place, result)
    return result.exit_code


def _picture(result: BalanceResult) -> bytes:
    """Return the corrected crank as a card of the board shows it."""
    from autobalance.report.balance.values import showable
    from autobalance.report.page.view import Shown
    from autobalance.report.pictures.picture import pictures
    from autobalance.report.records.balanced import BalancedReport

    record = result.record.balanced
    assert record is not None
    report, before = BalancedReport.read(showable(result.report)), result.before.measured.source.solid
    shown = Shown.of(report, before, record.result.solid, record.result.tools)
    return pictures(report, before.mesh, shown.body, shown.pieces, CARD_PIXELS)[1]


def _analysed(verb: str) -> Callable[[Asked, RunFolders, Progress], int]:
    """Return a function that runs an analysis: of the page's job, of a separate file, or of records."""

    def run(request: Asked, place: RunFolders, notify: Progress) -> int:
        import autobalance as ab

        def notify_of_verb(words: str, share: float) -> None:
            notify(words, DRAWING_SHARE * share)

        os.chdir(place.project)  # what a file names is in the project; the run is a separate process
        keywords = {
            **keywords_of(verb, request.get("options", {}), Project(place.project)),
            **_of_crank(verb, request, place.project),
        }
        declared = parameters_of(f"{registry.VERBS[verb].function}:{verb}")
        if "workers" in declared:
            keywords["workers"] = 1  # the run is a separate process already
        if "progress" in declared:
            keywords["progress"] = notify_of_verb
        notify(f"computing {verb}", 0.0)
        return _plotted(getattr(ab, verb)(*_subject(verb, request, place.project), **keywords), place, notify)

    return run


def _subject(verb: str, request: Asked, folder: Path) -> tuple[Any, ...]:
    """Return the subject of an analysis: a job, a file, a file beside a job; none where an option has it."""
    from autobalance.job import Job

    match ANALYSES[verb].reads:
        case "job":
            return (Job.from_dict(request["job"], folder=folder),)
        case "crank":
            return (str(folder / request["job"]["crankshaft"]["file"]),)
        case "file":
            return (request["file"],)
        case "both":
            return ({**_start(request["job"]), **request["file"]},)
    return ()


def _of_crank(verb: str, request: Asked, folder: Path) -> Asked:
    """Return the keywords of an analysis of a crank's solid that the job has."""
    if not ANALYSES[verb].crank:
        return {}
    from autobalance.job.read_crankshaft import read_crankshaft
    from autobalance.toml_files.typed_units import in_base_units
    from autobalance.units import G_PER_MM3_PER_KG_M3

    table = request["job"]["crankshaft"]
    crank = read_crankshaft(in_base_units({"crankshaft": table})["crankshaft"], folder)
    density_kg_m3 = crank.density_g_mm3 / G_PER_MM3_PER_KG_M3
    return {
        "unit": crank.unit,
        "body": crank.body,
        "density_kg_m3": density_kg_m3,
        "crankpin_in_file": crank.overrides.crankpin_in_file,
    }


def _start(job: Asked) -> Asked:
    """Return the tables of a job that a design starts from."""
    return {name: table for name, table in job.items() if name in START_TABLES}


def _plotted(result: VerbResult, place: RunFolders, notify: Progress) -> int:
    """Write a result's report, its words, its files and its plots, which take longest of some."""
    plots = result.plots()
    place.results.mkdir(parents=True, exist_ok=True)
    words = Project(place.project).as_named(result.text())
    (place.results / SUMMARY).write_text(words, encoding="utf-8")
    for number, (name, plot) in enumerate(plots.items()):
        notify(
            f"drawing {name.replace('-', ' ')}", DRAWING_SHARE + (1.0 - DRAWING_SHARE) * number / len(plots)
        )
        (place.results / f"{name}.svg").write_bytes(plot["svg"])
    for name, data in result.files().items():
        flat = name.removeprefix("designs/").replace("/", "-")  # a result's files are in one folder
        (place.results / flat).write_bytes(data)
    _report(place, result)
    return result.exit_code


def _report(place: RunFolders, result: VerbResult) -> None:
    """Write the report last: a run with one is whole."""
    place.results.mkdir(parents=True, exist_ok=True)
    (place.results / REPORT).write_text(result.json(), encoding="utf-8")


def _sheet(_: Asked, place: RunFolders, _notify: Progress) -> int:
    """Draw the shop sheet of a result again, with the cuts that are done."""
    import autobalance as ab

    for data in ab.sheet(place.results / REPORT).files().values():
        place.keep(SHEET, data)
    return 0


ASIDE: dict[str, Callable[[Asked, RunFolders, Progress], int]] = {"sheet": _sheet}
"""Commands that the server itself runs on a result: they are not runs."""
VERBS: dict[str, Callable[[Asked, RunFolders, Progress], int]] = {
    "inspect": _inspect,
    "scale": _scale,
    "balance": _balance,
    "recut": _recut,
    "nc": _nc,
    "compare": _compare,
    **{verb: _analysed(verb) for verb in ANALYSES},
}
"""Commands that the page may run."""
