"""Commands and add-ons by name, as text, so that nothing is loaded before its time."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Final, NamedTuple


class Verb(NamedTuple):
    """A function ``ab.NAME`` and a command ``autobalance NAME``: what it does, and the modules of both.

    The command follows from the function's signature and docstring. ``command`` adds the rest, and is empty
    if these suffice: a module, or ``"module:NAME"`` where one has those of several verbs. A verb that is not
    a function has no separate module.
    """

    says: str
    function: str
    command: str = ""


class RunSection(NamedTuple):
    """Place of a ``Section``, and the table of a job that asks for it; empty: only an option does."""

    place: str
    table: str = ""


CRANK_READERS: Final = (
    *("balance", "batch", "compare", "cycle", "design", "factor", "forces", "init", "inspect", "nc", "parts"),
    *("recut", "shafts", "start", "strength", "study", "torsion", "verify"),
)
"""Commands that read cranks, from the cache unless ``--no-cache``."""
VERBS: Final[dict[str, Verb]] = {
    "demo": Verb(
        "balance the bundled motocross crank and compare with the published result",
        "",
        "command.demo",
    ),
    "start": Verb(
        "ask for the values of a job, question by question, and balance the crank",
        "",
        "dialogue.command",
    ),
    "init": Verb(
        "write a commented job for a crank, or convert a job to a workbook and back",
        "verbs.init",
        "command.init",
    ),
    "inspect": Verb(
        "measure a crank: mass, axis, journals, throws, webs, unbalance, faces",
        "verbs.inspect",
        "command.inspect",
    ),
    "balance": Verb(
        "balance a crank: plan the cuts, make them in the model, measure the result",
        "verbs.balance",
        "command.balance:BALANCE",
    ),
    "calc": Verb(
        "compute any of the documented formulas by its name",
        "formulas.calc",
        "formulas.command",
    ),
    "compare": Verb(
        "compare all correction methods, and useful mixes, on one crank",
        "verbs.compare",
        "command.balance:COMPARE",
    ),
    "generate": Verb(
        "draw a crank of any layout from its dimensions, as a mesh or as STEP",
        "drawn_cranks.verb",
        "drawn_cranks.command",
    ),
    "verify": Verb(
        "check every number of a report against the corrected solid",
        "verbs.verify",
        "command.balance:VERIFY",
    ),
    "forces": Verb(
        "compute inertia forces and bearing loads, and the effect of each balance factor",
        "engines.forces.verb",
        "engines.command:FORCES",
    ),
    "factor": Verb(
        "show the present balance factor, and the loads, residual and metal of others",
        "engines.factor",
        "engines.command:FACTOR",
    ),
    "cycle": Verb(
        "compute gas pressure, loads of pins and bearings, torque and speed over the cycle",
        "engines.cycle.verb",
        "engines.command:CYCLE",
    ),
    "strength": Verb(
        "compute stress and safety of the fillets over the cycle, before and after cuts",
        "crank_dynamics.strength.verb",
        "crank_dynamics.command:STRENGTH",
    ),
    "shafts": Verb(
        "size balance shafts for the first and second order, and check those of the job",
        "engines.shafts.verb",
        "engines.command:SHAFTS",
    ),
    "parts": Verb(
        "add up the weights of the job: rotating, reciprocating, bob-weights, with uncertainty",
        "engines.parts",
        "engines.command:PARTS",
    ),
    "rod": Verb(
        "measure a connecting rod: eyes, mass, end weights, inertia",
        "engines.rod",
        "engines.command:ROD",
    ),
    "influence": Verb(
        "compute correction weights for each plane from trial weights",
        "test_stands.influence.verb",
        "test_stands.command:INFLUENCE",
    ),
    "machine": Verb(
        "simulate a balancing machine, or follow the readings of a real one",
        "test_stands.machine.verb",
        "test_stands.command:MACHINE",
    ),
    "bench": Verb(
        "simulate a rotor under speed control in its bearings, next to measured torques",
        "test_stands.bench.verb",
        "test_stands.command:BENCH",
    ),
    "rotor": Verb(
        "compute critical speeds, modes and unbalance response of a rotor, and balance it",
        "crank_dynamics.rotor.verb",
        "crank_dynamics.command:ROTOR",
    ),
    "recut": Verb(
        "plan further cuts on a corrected crank from a balancing machine's reading",
        "verbs.recut",
        "command.balance:RECUT",
    ),
    "jobs": Verb(
        "list and search finished jobs, with statistics for each engine",
        "studies.jobs",
        "studies.command:JOBS",
    ),
    "nc": Verb(
        "write NC programs for the cuts and simulate them on the solid",
        "machining.verb",
        "machining.command",
    ),
    "sheet": Verb(
        "draw the shop sheet and the drawing of a report again, on other paper or in other units",
        "paper.verb",
        "paper.command",
    ),
    "torsion": Verb(
        "compute torsional vibration of a crank or a chain: frequencies, torque, stress",
        "crank_dynamics.torsion.verb",
        "crank_dynamics.command:TORSION",
    ),
    "schema": Verb(
        "print the JSON Schema of a file that the program reads or writes, for editors",
        "verbs.schema",
        "command.schema",
    ),
    "grade": Verb(
        "compute the permissible unbalance of a grade, or the achieved grade",
        "formulas.grade",
        "formulas.command:GRADE",
    ),
    "design": Verb(
        "search for the best counterweight profiles that meet the balance exactly",
        "profile_search.verb",
        "profile_search.command",
    ),
    "batch": Verb(
        "run many jobs from a list or a folder; an interrupted batch resumes",
        "studies.batch.verb",
        "studies.command:BATCH",
    ),
    "study": Verb(
        "estimate the yield of a series, and the tolerances that matter most",
        "studies.study.verb",
        "studies.command:STUDY",
    ),
    "fem": Verb(
        "compute natural modes and static stress of a solid (extra fem)",
        "finite_elements.verb",
        "finite_elements.command",
    ),
    "bearing": Verb(
        "compute friction, oil film, stiffness and damping of a bearing",
        "engines.bearings.verb",
        "engines.command:BEARING",
    ),
    "orders": Verb(
        "analyse a recorded signal: spectrum, orders, natural frequencies, possible sources",
        "signals.verb",
        "signals.command",
    ),
    "app": Verb(
        "open the app in your browser (runs on this computer only)",
        "browser.serving",
        "browser.command",
    ),
    "completion": Verb(
        "print a script for bash, zsh or fish that completes commands and options",
        "",
        "command.completion",
    ),
}
"""Commands in the order of the help text."""
TORSION: Final = "crank_dynamics.torsion.input:TABLES"
JOB_TABLES: Final = {
    "study": "studies.study.input:TABLES",
    "cycle": "engines.cycle.input:TABLES",
    "drive": "signals.drive_input:TABLES",
    "mounts": "engines.mounts.input:TABLES",
    "mount": "engines.mounts.input:TABLES",
    "strength": "crank_dynamics.strength.input:TABLES",
    "bearings": "engines.bearings.main_springs:TABLES",
    "torsion": TORSION,
    "excitation": TORSION,
    "pendulum": TORSION,
    "run_up": TORSION,
    "speed_rpm": TORSION,
    "points": TORSION,
    "gear": TORSION,
    "branch": TORSION,
    "coupling": TORSION,
    "damper": TORSION,
}
"""Key at the top level of a job → the ``AddonTables`` that it belongs to."""
FILES: Final = {
    "reading": "job.reading:READING_KEYS",
    "trials": "test_stands.influence.input:TRIALS_KEYS",
    "machine": "test_stands.machine.input:MACHINE_KEYS",
    "machine-tool-file": "machining.input:MACHINE_TOOL_KEYS",
    "crank-file": "drawn_cranks.input:CRANK_FORMS",
    "bearing-file": "engines.bearings.keys:BEARING_FORMS",
    "rotor-file": "crank_dynamics.rotor.input:ROTOR",
    "chain-file": "crank_dynamics.torsion.verb:CHAIN",
    "drive-file": "signals.drive_input:DRIVE_KEYS",
    "bench-file": "test_stands.bench.input:BENCH_KEYS",
    "engine-bench-file": "test_stands.bench.engine_input:ENGINE_BENCH_KEYS",
    "fem-file": "finite_elements.input:FEM_KEYS",
    "design-file": "profile_search.input:design_keys",
}
"""Schema of a file that is read beside a job → its keys at the top level, by form, or what makes them."""
REPORTS: Final = {
    "generate": "drawn_cranks.answer:GenerateReport",
    "batch": "studies.batch.answer:BatchReport",
    "bearing": "engines.bearings.report:BearingReport",
    "bench": "test_stands.bench.answer:BenchReport",
    "engine-bench": "test_stands.bench.answer:EngineBenchReport",
    "calc": "report.records.answers:CalcReport",
    "compare": "report.records.compare:CompareReport",
    "cycle": "engines.cycle.films:CycleReport",
    "design": "profile_search.answer:DesignReport",
    "fem": "finite_elements.verb:FemReport",
    "factor": "engines.factor:FactorReport",
    "forces": "engines.forces.answer:ForcesReport",
    "grade": "formulas.grade:GradeReport",
    "init": "report.records.answers:InitReport",
    "influence": "test_stands.influence.answer:InfluenceReport",
    "jobs": "studies.jobs:JobsReport",
    "machine-report": "test_stands.machine.answer:MachineReport",
    "nc": "machining.answer:NcReport",
    "orders": "signals.answer:OrdersReport",
    "parts": "engines.parts:PartsReport",
    "rod": "engines.rod:RodReport",
    "rotor": "crank_dynamics.rotor.answer:RotorReport",
    "shafts": "engines.shafts.answer:ShaftsReport",
    "sheet": "report.records.answers:SheetReport",
    "study": "studies.study.answer:StudyReport",
    "torsion": "crank_dynamics.torsion.answer:TorsionReport",
    "strength": "crank_dynamics.strength.answer:StrengthReport",
    "verify": "report.records.answers:VerifyReport",
}
"""Schema of what a verb writes with ``--json`` → its record."""
OUTPUT_KINDS: Final[list[str]] = [
    "report.kinds_of_report:PAGE",
    "paper.kinds:SHEET",
    "paper.kinds:WORKBOOK",
    "report.kinds_of_report:PICTURES",
    "paper.kinds:CERTIFICATE",
    "paper.kinds:CARD",
    "paper.kinds:HOLE_LIST",
    "paper.kinds:DRAWING",
    "report.kinds_of_report:TOOL_BODIES",
    "report.kinds_of_report:READING",
]
"""Kinds of files that a run writes for people, in the order in which they are made."""
RUN_SECTIONS: Final = {
    "bending": RunSection("crank_dynamics.strength.bending:SECTION"),
    "loads_with_gas": RunSection("engines.cycle.section:SECTION", "cycle"),
}
"""Parts of the main report that add-ons compute, by key."""
DRAWINGS: Final = "paper.drawing:drawings"
"""Outlines of the crank and of the removed metal, for the papers."""
ODDITIES: Final = {"cycle": "engines.cycle.firing:odd_firing"}
"""Table of a job → function of job and anatomy that returns its oddities."""
OWN_HELP: Final = {"calc": "formulas.command:help_for"}
"""Verb → function of the words of the command line that returns its help, or None."""
CYCLE_SECTIONS: Final = {
    "roll": RunSection("engines.cycle.block_roll:SECTION", "cycle"),
    "weight": RunSection("engines.cycle.weight_section:SECTION", "cycle"),
    "drives": RunSection("engines.cycle.drive_section:SECTION", "cycle"),
    "piston_friction": RunSection("engines.cycle.piston_section:SECTION", "cycle"),
    "heat": RunSection("engines.cycle.bearing_heat:SECTION", "cycle"),
    "windage": RunSection("engines.cycle.windage_section:SECTION", "cycle"),
    "flexible": RunSection("crank_dynamics.flexible.section:SECTION"),
}
"""Parts of a cycle's report besides its summary, by key; the section itself decides for a job."""
VIEW: Final = "browser.meshes:view"
"""The view of a crank in a notebook."""


def functions() -> dict[str, str]:
    """Return the module of each verb that is a public function."""
    return {name: each.function for name, each in VERBS.items() if each.function}


def loaded(place: str) -> Any:
    """Return the object at a place, as ``"engines.cycle.input:TABLES"``."""
    module, name = place.split(":")
    return getattr(import_module(f"autobalance.{module}"), name)
