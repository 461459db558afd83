"""``autobalance shafts JOB.toml``: shafts that would cancel orders 1 and 2, and what the job's own leave."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots, add_units
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "engines.shafts.verb:shafts",
    examples=("autobalance shafts job.toml --speed-rpm 9000",),
    options={"job": Option(metavar="JOB.toml")},
    writes=(add_json, add_units, add_plots),
)
