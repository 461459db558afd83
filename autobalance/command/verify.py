"""``autobalance verify REPORT.json``: read the corrected solid again and check every number claimed of it."""

from __future__ import annotations

from autobalance.command.console import add_objects
from autobalance.command.options import add_json, add_units, add_verbose
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "verbs.verify:verify",
    examples=("autobalance verify job-balanced/report.json --independent",),
    options={"report": Option(metavar="REPORT.json")},
    writes=(add_json, add_units, add_verbose, add_objects),
)
