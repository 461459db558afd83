"""``autobalance influence TRIALS.toml``: weights that correct, from readings with trial weights."""

from __future__ import annotations

from autobalance.command.options import add_json, add_output, add_plots, add_units
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "test_stands.influence.verb:influence",
    examples=("autobalance influence trials.toml --plots plots",),
    options={"trials": Option(metavar="TRIALS.toml")},
    writes=(
        add_output("the report, and with [reading] a reading.toml for recut"), add_json, add_units, add_plots,
    ),
)  # fmt: skip
