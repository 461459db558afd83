"""``autobalance parts JOB.toml``: the weights of a job rolled up, and its bob-weights."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots, add_units
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "engines.parts.verb:parts",
    examples=("autobalance parts job.toml --set balance.factor=0.5",),
    options={"job": Option(metavar="JOB.toml")},
    writes=(add_json, add_units, add_plots),
)
