"""``autobalance jobs``: the archive of a shop."""

from __future__ import annotations

from autobalance.command.options import add_json, add_output, add_units
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "studies.jobs.verb:jobs",
    examples=("autobalance jobs results", "autobalance jobs results --find CRF250R -o archive"),
    options={"folder": Option(positional=True, metavar="FOLDER"), "find": Option(metavar="TEXT")},
    writes=(add_output("the report and jobs.csv"), add_json, add_units),
)
