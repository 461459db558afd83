"""Add-ons by name: this alone knows them, as text, so that nothing is loaded before it is needed."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Final, NamedTuple


class RunSection(NamedTuple):
    """Place of a ``Section``, and the table of a job that asks for it; empty: only an option does."""

    place: str
    table: str = ""


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
VIEW: Final = "api.views:view"
"""The view of a crank in a notebook."""


def loaded(place: str) -> Any:
    """Return what stands at a place, as ``"job.cycle:TABLES"``."""
    module, name = place.split(":")
    return getattr(import_module(f"autobalance.{module}"), name)
