"""Verbs and add-ons by name: this alone knows them, as text, so that nothing is loaded before its time."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Final, NamedTuple


class Verb(NamedTuple):
    """A function ``ab.NAME`` and a command ``autobalance NAME``: what it does, and the modules of both.

    The command follows from the function's signature and docstring; ``command`` says what these cannot, and
    is empty where they say all. A verb that is no function has no module of one.
    """

    says: str
    function: str
    command: str = ""


class RunSection(NamedTuple):
    """Place of a ``Section``, and the table of a job that asks for it; empty: only an option does."""

    place: str
    table: str = ""


VERBS: Final[dict[str, Verb]] = {
    "demo": Verb(
        "balance the bundled motocross crank twice and compare with the published result",
        "",
        "command.demo",
    ),
    "init": Verb(
        "write a commented job for a crank, or convert a job to a workbook and back",
        "api.init",
        "command.init",
    ),
    "inspect": Verb(
        "measure a crank file: mass, axis, journals, throws, webs, unbalance, faces",
        "api.inspect",
        "command.inspect",
    ),
    "balance": Verb(
        "the main job: measure, plan, cut, measure again until within tolerance",
        "api.balance",
        "command.balance",
    ),
    "calc": Verb(
        "calculate any of the documented formulas, by its name",
        "api.calc",
        "command.calc",
    ),
    "compare": Verb(
        "try every kind of correction and the useful mixes on one crank, like for like",
        "api.compare",
        "command.compare",
    ),
    "generate": Verb(
        "build a crankshaft of any layout from its dimensions, as a mesh or as STEP",
        "api.generate",
        "command.generate",
    ),
    "verify": Verb(
        "read a corrected solid from disk again and check every number its report claims",
        "api.verify",
        "command.verify",
    ),
    "forces": Verb(
        "inertia forces of the job's engine: orders, bearing loads, effect of each balance factor",
        "api.forces",
        "command.forces",
    ),
    "cycle": Verb(
        "the working cycle: gas pressure, loads of pins and bearings, torque, speed",
        "api.cycle",
        "command.cycle",
    ),
    "strength": Verb(
        "stress and safety of crankpin and journal fillets over the cycle, before and after cuts",
        "api.strength",
        "command.strength",
    ),
    "shafts": Verb(
        "balance shafts: sizes that cancel the first and second order, residual of the job's shafts",
        "api.shafts",
        "command.shafts",
    ),
    "parts": Verb(
        "roll up the weights of the job: rotating, reciprocating, bob-weights, with their uncertainty",
        "api.parts",
        "command.parts",
    ),
    "rod": Verb(
        "measure a connecting rod: eyes, mass, end weights, inertia, and the couple that two masses miss",
        "api.rod",
        "command.rod",
    ),
    "influence": Verb(
        "balance by influence coefficients: weights to add in each plane, from trial weights",
        "api.influence",
        "command.influence",
    ),
    "machine": Verb(
        "simulate a balancing machine: predicted readings and the residual after correcting by them",
        "api.machine",
        "command.machine",
    ),
    "bench": Verb(
        "simulate a rotor under speed control in its bearings, beside measured torques",
        "api.bench",
        "command.bench",
    ),
    "rotor": Verb(
        "a shaft on bearings: critical speeds, modes, unbalance response, modal balancing",
        "api.rotor",
        "command.rotor",
    ),
    "recut": Verb(
        "plan further cuts on a corrected crank, from a balancing machine's readings",
        "api.recut",
        "command.recut",
    ),
    "jobs": Verb(
        "list the jobs of a folder of results, find some, statistics of a series",
        "api.jobs",
        "command.jobs",
    ),
    "nc": Verb(
        "write NC programs for a report's cuts, simulated on the solid from their own text",
        "api.nc",
        "command.nc",
    ),
    "sheet": Verb(
        "draw the shop sheet and the drawing again from a report, on other paper, in other units",
        "api.sheet",
        "command.sheet",
    ),
    "torsion": Verb(
        "torsional vibration of a crank or a chain: frequencies, critical orders, torque, stress",
        "api.torsion",
        "command.torsion",
    ),
    "schema": Verb(
        "print the JSON Schema of a file that the program reads or writes, for editors",
        "api.schema",
        "command.schema",
    ),
    "grade": Verb(
        "balance quality grades: permissible and achieved, and the list for crank drives",
        "api.grade",
        "command.grade",
    ),
    "design": Verb(
        "search counterweight profiles for the best that meet the balance exactly",
        "api.design",
        "command.design",
    ),
    "batch": Verb(
        "run many jobs from a list or a folder; resumable",
        "api.batch",
        "command.batch",
    ),
    "study": Verb(
        "Monte Carlo tolerance study: yield, and which tolerances matter most",
        "api.study",
        "command.study",
    ),
    "fem": Verb(
        "natural modes and static stress of a solid, by quadratic tetrahedra (extra)",
        "api.fem",
        "command.fem",
    ),
    "bearing": Verb(
        "friction, oil film, stiffness and damping of a bearing; its film through a cycle",
        "api.bearing",
        "command.bearing",
    ),
    "orders": Verb(
        "analyse a recorded signal: spectrum, orders, natural frequencies, bearings, possible sources",
        "api.orders",
        "command.orders",
    ),
    "app": Verb(
        "start the local web app: the whole program in a browser, on this machine",
        "web_app.serving",
        "command.app",
    ),
    "completion": Verb(
        "print a script for bash, zsh or fish that completes commands and options",
        "",
        "command.completion",
    ),
}
"""In the order of the help text."""
TORSION: Final = "job.torsion:TABLES"
JOB_TABLES: Final = {
    "study": "job.study:TABLES",
    "cycle": "job.cycle:TABLES",
    "drive": "job.drive:TABLES",
    "mounts": "job.mounts:TABLES",
    "mount": "job.mounts:TABLES",
    "strength": "job.strength:TABLES",
    "bearings": "job.bearings:TABLES",
    "torsion": TORSION,
    "excitation": TORSION,
    "pendulum": TORSION,
    "speed_rpm": TORSION,
    "points": TORSION,
    "gear": TORSION,
    "branch": TORSION,
    "coupling": TORSION,
    "damper": TORSION,
}
"""Key at the top level of a job → the ``AddonTables`` that it belongs to."""
FILES: Final = {
    "reading": "job.files.reading:READING_KEYS",
    "trials": "job.files.trials:TRIALS_KEYS",
    "machine": "job.files.machine:MACHINE_KEYS",
    "machine-tool-file": "job.files.machine_tool:MACHINE_TOOL_KEYS",
    "crank-file": "job.files.crank_keys:CRANK_FORMS",
    "bearing-file": "job.files.bearing_keys:BEARING_FORMS",
    "rotor-file": "job.files.rotor:ROTOR",
    "chain-file": "job.files.torsion:CHAIN",
    "drive-file": "job.drive:DRIVE_KEYS",
    "bench-file": "job.files.bench:BENCH_KEYS",
    "engine-bench-file": "job.files.engine_bench:ENGINE_BENCH_KEYS",
    "fem-file": "job.files.fem:FEM_KEYS",
    "design-file": "job.files.design_keys:design_keys",
}
"""Schema of a file that is read beside a job → its keys at the top level, by form, or what makes them."""
REPORTS: Final = {
    "generate": "report.records.generate:GenerateReport",
    "batch": "report.records.batch:BatchReport",
    "bearing": "report.records.bearing:BearingReport",
    "bench": "report.records.bench:BenchReport",
    "engine-bench": "report.records.bench:EngineBenchReport",
    "calc": "report.records.answers:CalcReport",
    "compare": "report.records.compare:CompareReport",
    "cycle": "report.records.cycle:CycleReport",
    "design": "report.records.design:DesignReport",
    "fem": "report.records.fem:FemReport",
    "forces": "report.records.forces:ForcesReport",
    "grade": "report.records.grade:GradeReport",
    "init": "report.records.answers:InitReport",
    "influence": "report.records.influence:InfluenceReport",
    "jobs": "report.records.jobs:JobsReport",
    "machine-report": "report.records.machine:MachineReport",
    "nc": "report.records.nc:NcReport",
    "orders": "report.records.orders:OrdersReport",
    "parts": "report.records.parts:PartsReport",
    "rod": "report.records.rod:RodReport",
    "rotor": "report.records.rotor:RotorReport",
    "shafts": "report.records.shafts:ShaftsReport",
    "sheet": "report.records.answers:SheetReport",
    "study": "report.records.study:StudyReport",
    "torsion": "report.records.torsion:TorsionReport",
    "strength": "report.records.strength:StrengthReport",
    "verify": "report.records.answers:VerifyReport",
}
"""Schema of what a verb writes with ``--json`` → its record."""
OUTPUT_KINDS: Final[list[str]] = [
    "report.kinds_of_report:PAGE",
    "report.sheet.kinds:SHEET",
    "report.sheet.kinds:WORKBOOK",
    "report.kinds_of_report:PICTURES",
    "report.sheet.kinds:CERTIFICATE",
    "report.sheet.kinds:CARD",
    "report.sheet.kinds:HOLE_LIST",
    "report.sheet.kinds:DRAWING",
    "report.kinds_of_report:TOOL_BODIES",
    "report.kinds_of_report:READING",
]
"""Kinds of files that a run writes for people, in the order in which they are made."""
RUN_SECTIONS: Final = {
    "bending": RunSection("report.balance.bending_section:SECTION"),
    "loads_with_gas": RunSection("report.engine.gas_section:SECTION", "cycle"),
}
"""Parts of the main report that add-ons compute, by key."""
DRAWINGS: Final = "report.sheet.drawing:drawings"
"""Outlines of the crank and of the removed metal, for the papers."""
ODDITIES: Final = {"cycle": "machine_models.firing_from_job:odd_firing"}
"""Table of a job → function of job and anatomy that says what is odd about it."""
OWN_HELP: Final = {"calc": "command.calc:help_for"}
"""Verb → function of the words of the command line that returns its help, or None."""
CYCLE_SECTIONS: Final = {"flexible": "report.engine.flexible_section:SECTION"}
"""Parts of a cycle's report that add-ons compute, by key."""
VIEW: Final = "api.views:view"
"""The view of a crank in a notebook."""


def functions() -> dict[str, str]:
    """Return the module of each verb that is a public function."""
    return {name: each.function for name, each in VERBS.items() if each.function}


def loaded(place: str) -> Any:
    """Return what stands at a place, as ``"job.cycle:TABLES"``."""
    module, name = place.split(":")
    return getattr(import_module(f"autobalance.{module}"), name)
