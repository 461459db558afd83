"""List of the verbs, a line for each: a function ``ab.NAME`` and a command ``autobalance NAME``.

The function stands in ``autobalance/api/NAME.py``. The command follows from its signature and docstring; what
these cannot say stands in ``autobalance/command/NAME.py``.
"""

from __future__ import annotations

VERBS: dict[str, str] = {
    "demo": "balance the bundled motocross crank twice and compare with the published result",
    "init": "write a commented job for a crank, or convert a job to a workbook and back",
    "inspect": "measure a crank file: mass, axis, journals, throws, webs, unbalance, faces",
    "balance": "the main job: measure, plan, cut, measure again until within tolerance",
    "calc": "calculate any of the documented formulas, by its name",
    "compare": "try every kind of correction and the useful mixes on one crank, like for like",
    "generate": "build a crankshaft of any layout from its dimensions, as a mesh or as STEP",
    "verify": "read a corrected solid from disk again and check every number its report claims",
    "forces": "inertia forces of the job's engine: orders, bearing loads, effect of each balance factor",
    "cycle": "the working cycle: gas pressure, loads of pins and bearings, torque, speed",
    "strength": "stress and safety of crankpin and journal fillets over the cycle, before and after cuts",
    "shafts": "balance shafts: sizes that cancel the first and second order, residual of the job's shafts",
    "parts": "roll up the weights of the job: rotating, reciprocating, bob-weights, with their uncertainty",
    "rod": "measure a connecting rod: eyes, mass, end weights, inertia, and the couple that two masses miss",
    "influence": "balance by influence coefficients: weights to add in each plane, from trial weights",
    "machine": "simulate a balancing machine: predicted readings and the residual after correcting by them",
    "bench": "simulate a rotor under speed control in its bearings, beside measured torques",
    "rotor": "a shaft on bearings: critical speeds, modes, unbalance response, modal balancing",
    "recut": "plan further cuts on a corrected crank, from a balancing machine's readings",
    "jobs": "list the jobs of a folder of results, find some, statistics of a series",
    "nc": "write NC programs for a report's cuts, simulated on the solid from their own text",
    "sheet": "draw the shop sheet and the drawing again from a report, on other paper, in other units",
    "torsion": "torsional vibration of a crank or a chain: frequencies, critical orders, torque, stress",
    "schema": "print the JSON Schema of a file that the program reads or writes, for editors",
    "grade": "balance quality grades: permissible and achieved, and the list for crank drives",
    "design": "search counterweight profiles for the best that meet the balance exactly",
    "batch": "run many jobs from a list or a folder; resumable",
    "study": "Monte Carlo tolerance study: yield, and which tolerances matter most",
    "fem": "natural modes and static stress of a solid, by quadratic tetrahedra (extra)",
    "bearing": "friction, oil film, stiffness and damping of a bearing; its film through a cycle",
    "orders": "analyse a recorded signal: spectrum, orders, natural frequencies, bearings, possible sources",
    "app": "start the local web app: the whole program in a browser, on this machine",
    "completion": "print a script for bash, zsh or fish that completes commands and options",
}
"""Name → description, in the order of the help text."""
OTHER_PLACES: dict[str, str | None] = {"app": "web_app.serving", "demo": None, "completion": None}
"""Verbs that are no function (None), or a function of another module."""


def public() -> dict[str, str]:
    """Return the module of each verb that is a public function."""
    modules = {name: OTHER_PLACES.get(name, f"api.{name}") for name in VERBS}
    return {name: module for name, module in modules.items() if module is not None}
