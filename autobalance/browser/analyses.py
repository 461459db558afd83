"""Verbs that cut nothing, as the page offers them: input, keys, options and files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, field
from importlib import resources
from typing import TYPE_CHECKING, Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from autobalance import registry
from autobalance.browser.forms import Form, file_tables
from autobalance.browser.guard import body_of, file_of, jsonable, refused
from autobalance.browser.project import FILE_KEYS, Project, named_files
from autobalance.declare import UNIT_BY_ENDING
from autobalance.errors import AutobalanceError, UsageError
from autobalance.toml_files.document import text_of, toml_of, toml_text
from autobalance.value_classes import dataclass
from autobalance.verbs.declaration import REQUIRED, Parameter, parameters_of

if TYPE_CHECKING:
    from autobalance.browser.project import Project


# Verbs that cut nothing, as the page offers them: input, keys and options of each as forms.


@dataclass(frozen=True)
class Number:
    """The one number of an analysis: what it is, and where a report holds it.

    ``path`` leads through the report, ``*`` to every entry of a list or table; ``of`` is ``first``, ``last``,
    ``least`` or ``greatest`` of the numbers found. Shown is the number times ``factor``, in ``unit``.
    """

    words: str
    path: str
    unit: str
    digits: int = 0
    of: str = "first"
    factor: float = 1.0


@dataclass(frozen=True)
class AnalysisQuestion:
    """A verb as a question: what it reads, what the job must have for it, and the number that answers it.

    It reads the page's job, the solid of the job's crank alone, a separate file (the name of its schema) or a
    record; without any of them, its options. ``needs`` are keys of the job: ``a|b`` is one of them, and the
    page asks for the first; ``*pm*`` is any uncertainty. ``given`` fills options from the job, or from the
    crank that is shown.
    """

    group: str
    question: str
    numbers: tuple[Number, ...]
    job: bool = False
    crank: bool = False
    schema: str = ""
    record: bool = False
    needs: tuple[str, ...] = ()
    given: Mapping[str, str] = field(default_factory=dict)

    @property
    def reads(self) -> str:
        """``job``, ``crank``, ``file``, ``both``, ``records`` or ``options``."""
        if self.crank:
            return "crank"
        if self.record:
            return "records"
        names = {(True, False): "job", (False, True): "file", (True, True): "both"}
        return names.get((self.job, bool(self.schema)), "options")


ENGINE, RUNNING, MEASURING = "The engine", "Strength and running", "Making and measuring"
TARGET = ("balance.factor", "balance.grade", "balance.speed_rpm")
ROD = (*TARGET, "engine.rod_length_mm")
CYCLE = (*ROD, "cycle.bore_mm", "cycle.compression_ratio|cycle.trace", "cycle.heat_J|cycle.trace|cycle.model")
ANALYSES: Mapping[str, AnalysisQuestion] = {
    "forces": AnalysisQuestion(
        ENGINE,
        "How hard does it shake?",
        (Number("largest force", "states.*.force.greatest_n", "N", of="last"),),
        job=True,
        needs=ROD,
    ),
    "factor": AnalysisQuestion(
        ENGINE,
        "Which balance factor?",
        (Number("factor today", "present", "", 3),),
        job=True,
        needs=TARGET,
    ),
    "cycle": AnalysisQuestion(
        ENGINE,
        "Loads and torque over a cycle",
        (Number("mean torque", "torque.mean_N_m", "N·m", 1),),
        job=True,
        needs=CYCLE,
    ),
    "shafts": AnalysisQuestion(
        ENGINE,
        "Balance shafts",
        (Number("largest shaft", "proposals.*.shafts.*.product_g_mm", "g·mm", of="greatest"),),
        job=True,
        needs=ROD,
    ),
    "parts": AnalysisQuestion(
        ENGINE,
        "What do the parts weigh?",
        (Number("bob-weight", "throws.*.bob_weight_g", "g", 2, of="greatest"),),
        job=True,
        needs=TARGET,
    ),
    "design": AnalysisQuestion(
        ENGINE,
        "Lighter counterweights",
        (Number("lightest crank", "designs.*.objectives.mass_g", "g", of="least"),),
        job=True,
        schema="design-file",
        needs=TARGET,
    ),
    "strength": AnalysisQuestion(
        RUNNING,
        "Will it break?",
        (Number("minimum safety", "fillets.*.safety.*", "", 2, of="least"),),
        job=True,
        needs=(*CYCLE, "strength.pin_fillet_mm", "strength.material.tensile_MPa"),
    ),
    "fem": AnalysisQuestion(
        RUNNING,
        "Natural modes of the solid",
        (Number("lowest mode", "modes.*.frequency_hz", "Hz", of="least"),),
        job=True,
        crank=True,
    ),
    "torsion": AnalysisQuestion(
        RUNNING,
        "Torsional vibration",
        (Number("lowest mode", "natural_frequencies_hz.*", "Hz", of="least"),),
        job=True,
        needs=TARGET,
    ),
    "rotor": AnalysisQuestion(
        RUNNING,
        "Critical speeds",
        (Number("lowest critical speed", "critical_speeds_rpm.*", "rpm", of="least"),),
        schema="rotor-file",
    ),
    "bearing": AnalysisQuestion(
        RUNNING,
        "Oil film of a bearing",
        (
            Number("least film", "film.least_film_mm", "µm", 2, factor=1000.0),
            Number("friction", "friction.moment_N_m", "N·m", 3),
        ),
        schema="bearing-file",
    ),
    "study": AnalysisQuestion(
        MEASURING,
        "How many of 1000 pass?",
        (Number("within tolerance", "probability_within", "%", 1, factor=100.0),),
        job=True,
        needs=(*TARGET, "crankshaft.density_pm_kg_m3|*pm*"),
    ),
    "orders": AnalysisQuestion(
        MEASURING,
        "Orders in a recorded signal",
        (Number("speed", "speed.mean_rpm", "rpm"), Number("sample rate", "record.sample_rate_hz", "Hz")),
        record=True,
    ),
    "bench": AnalysisQuestion(
        MEASURING,
        "Test bench",
        (Number("largest mean torque", "runs.*.mean_torque_N_m", "N·m", 3, of="greatest"),),
        schema="bench-file",
    ),
    "grade": AnalysisQuestion(
        MEASURING,
        "Grade of a crank",
        (
            Number("achieved grade G", "achieved_grade_mm_s", "", 2),
            Number("permitted", "permissible_g_mm", "g·mm", 2),
        ),
        given={"grade": "balance.grade", "speed_rpm": "balance.speed_rpm", "mass": "crank.mass_g"},
    ),
}
FILES_OF = {"bench": ("job", "crank")}
"""Further keys of a verb's file that name a file."""
NOT_ASKED = (
    "crank",
    "settings",
    "progress",
    "workers",
    "cluster",
    "cluster_timeout_s",
    "output",
    "fresh",
    "solids",
)
"""Parameters that are for Python, for the command line, or that the page has its own answer to."""
FROM_JOB = {"fem": ("unit", "body", "density_kg_m3", "crankpin_in_file")}
"""Parameters of a verb that follow from the crank in the job."""
KINDS = {
    "bool": "bool",
    **dict.fromkeys(("int", "float"), "number"),
    **dict.fromkeys(("Sequence[float]", "tuple[float, float]", "tuple[str, str]"), "list"),
    **dict.fromkeys(("Mapping[str, float]", "Mapping[str, float | str]"), "named"),
}
"""Type of a parameter → kind of its field; a choice and text are what is not here."""
EXPECTED = {
    "int": (int,),
    "float": (int, float),
    "bool": (bool,),
    "Sequence[float]": (list,),
    "tuple[float, float]": (list,),
    "tuple[str, str]": (list,),
    **dict.fromkeys(("Mapping[str, float]", "Mapping[str, float | str]"), (dict,)),
}
"""Type of a parameter → of its value as JSON; text of all others."""


def analyses() -> list[Form]:
    """Return every verb with what it reads, the forms of its file and of its options."""
    return [
        {
            "verb": verb,
            "says": registry.VERBS[verb].says,
            "reads": analysis.reads,
            "group": analysis.group,
            "question": analysis.question,
            "needs": list(analysis.needs),
            "given": dict(analysis.given),
            "numbers": [asdict(each) for each in analysis.numbers],
            "tables": file_tables(analysis.schema) if analysis.schema else [],
            "options": [_field(each) for each in _options(verb)],
        }
        for verb, analysis in ANALYSES.items()
    ]


def example(verb: str) -> str:
    """Return a file that a verb can read, to begin with."""
    return (resources.files("autobalance.browser") / f"examples/{verb}.toml").read_text(encoding="utf-8")


def _options(verb: str) -> Iterator[Parameter]:
    """Yield the parameters that the page asks for: not the job or the file, which it has."""
    declared = list(parameters_of(f"{registry.VERBS[verb].function}:{verb}").values())
    own = declared if ANALYSES[verb].reads in ("records", "options") else declared[1:]
    asked = (each for each in own if each.name not in (*NOT_ASKED, *FROM_JOB.get(verb, ())))
    if verb != "rotor":  # whose options are for a crank in place of its file
        yield from asked


def _is_file(parameter: Parameter) -> bool:
    return "Path" in parameter.type


def _field(parameter: Parameter) -> Form:
    words, _, absent = parameter.meaning.partition("; None: ")
    kind = (
        "choice"
        if parameter.choices
        else KINDS.get(parameter.type, "file" if _is_file(parameter) else "text")
    )
    usual = absent if parameter.default in (None, REQUIRED) else _shown(parameter.default)
    ending = next((each for each in UNIT_BY_ENDING if parameter.name.endswith(each)), "")
    return {
        "key": parameter.name,
        "words": parameter.name.removesuffix(ending).replace("_", " "),
        "unit": UNIT_BY_ENDING.get(ending, ""),
        "kind": kind,
        "choices": list(parameter.choices),
        "default": usual,
        "says": words,
        "required": parameter.default is REQUIRED,
    }


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return ", ".join(f"{each:g}" for each in value) if isinstance(value, tuple) else str(value)


def keywords_of(verb: str, values: Mapping[str, Any], project: Project) -> dict[str, Any]:
    """Return a function's keywords from the page's options; files are those of the project.

    Raises
    ------
    UsageError
        If an option is unknown, of another type than declared, or names what is not a file of the project.
    """
    declared = {each.name: each for each in _options(verb)}
    unknown = set(values) - set(declared)
    if unknown:
        raise UsageError(
            f"{verb} has no option {sorted(unknown)[0]}; expected {', '.join(declared) or 'none'}"
        )
    missing = [name for name, each in declared.items() if each.default is REQUIRED and name not in values]
    if missing:
        raise UsageError(f"{verb}: {missing[0]} is missing; choose a file")
    return {name: _value(declared[name], value, project) for name, value in values.items()}


def _value(parameter: Parameter, value: Any, project: Project) -> Any:
    expected = EXPECTED.get(parameter.type, (str,))
    is_of_type = isinstance(value, expected) and (not isinstance(value, bool) or bool in expected)
    if not is_of_type or (parameter.choices and value not in parameter.choices):
        what = ", ".join(parameter.choices) or parameter.type
        raise UsageError(f"{parameter.name} is {value!r}; expected {what}")
    numbers = parameter.type in ("Sequence[float]", "tuple[float, float]")
    if numbers and not all(isinstance(each, int | float) for each in value):
        raise UsageError(f"{parameter.name} is {value!r}; expected numbers")
    if parameter.type.startswith("tuple") and len(value) != 2:
        raise UsageError(f"{parameter.name} has {len(value)} entries; expected 2")
    if _is_file(parameter):
        wrong = outside(value, parameter.name, project)
        if wrong:
            raise UsageError(wrong)
        return str(project.folder / value)
    return tuple(value) if isinstance(value, list) else value


def outside(name: Any, where: str, project: Project, seen: tuple[str, ...] = ()) -> str:
    """Return an error where a file, or one that it names, is none of the project's; else ""."""
    path = project.file(name) if isinstance(name, str) else None
    if path is None:
        return f"{where} must be the name of a file in the project"
    if path.suffix.lower() != ".toml" or name in seen:
        return ""
    try:
        values = toml_of(text_of(path, "file"), path.name)
    except AutobalanceError as error:
        return project.as_named(str(error))
    known = (*seen, path.name)
    named = (outside(file, f"{path.name}: {key}", project, known) for key, file in named_files(values))
    return next((wrong for wrong in named if wrong), "")


def wrong_request(verb: str, values: Mapping[str, Any], project: Project) -> str:
    """Return the error in an analysis' request, "" if it is correct; the job is not looked into."""
    analysis, options = ANALYSES[verb], values.get("options", {})
    parts = {"job": analysis.job, "file": bool(analysis.schema)}
    reads = [name for name, is_read in parts.items() if is_read]
    whole = all(isinstance(values.get(name), dict) for name in reads)
    if set(values) - {*reads, "options"} or not isinstance(options, dict) or not whole:
        body = ", ".join(f'"{name}": {{...}}' for name in (*reads, "options"))
        return f'the body must be {{"verb": "{verb}", {body}}}'
    try:
        keywords_of(verb, options, project)
    except AutobalanceError as error:
        return str(error)
    named = named_files(values.get("file", {}), (*FILE_KEYS, *FILES_OF.get(verb, ())))
    found = (outside(name, where, project) for where, name in named)
    return next((wrong for wrong in found if wrong), "")


# Endpoints of the files that verbs read beside the job: a rotor, a bearing, a bench, a design.


class AnalysisFiles:
    """The endpoints; the file of a verb is ``VERB.toml`` in the project."""

    def __init__(self, project: Project) -> None:
        self._project = project

    def routes(self) -> list[Route]:
        return [
            Route("/api/analyses/{verb}", self.read),
            Route("/api/analyses/{verb}", self.keep, methods=["PUT"]),
        ]

    async def read(self, request: Request) -> Response:
        """Give the file of a verb: the project's, else an example."""
        verb = request.path_params["verb"]
        if not _has_file(verb):
            return file_of(None)
        path = self._project.file(f"{verb}.toml")
        if path is None or "example" in request.query_params:
            return _document(example(verb), verb)
        return _document(path.read_text(encoding="utf-8", errors="replace"), verb)

    async def keep(self, request: Request) -> Response:
        """Keep the file of a verb, as tables or as it was typed."""
        verb, values = request.path_params["verb"], await body_of(request)
        if not _has_file(verb):
            return file_of(None)
        tables, text = (values.get(name) if isinstance(values, dict) else None for name in ("tables", "toml"))
        if not isinstance(tables, dict) and not isinstance(text, str):
            return refused('the body must be {"tables": {...}} or {"toml": TEXT}', 400)
        try:
            kept = toml_text(tables) if isinstance(tables, dict) else str(text)
            toml_of(kept, f"{verb}.toml")
        except AutobalanceError as error:
            return refused(str(error), 400)
        self._project.write_text(f"{verb}.toml", kept)
        return _document(kept, verb)


def _has_file(verb: str) -> bool:
    return verb in ANALYSES and bool(ANALYSES[verb].schema)


def _document(text: str, verb: str) -> Response:
    """Return the text of a verb's file with its tables; without those where it is not TOML."""
    try:
        tables = jsonable(toml_of(text, f"{verb}.toml"))
    except AutobalanceError:
        tables = {}
    return JSONResponse({"text": text, "tables": tables})
