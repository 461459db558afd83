"""``autobalance machine MACHINE.toml``: what a balancing machine would read."""

from __future__ import annotations

from autobalance.command.options import add_json, add_output, add_plots, add_units
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "api.machine:machine",
    examples=("autobalance machine machine.toml -o readings",),
    options={"machine_file": Option(metavar="MACHINE.toml")},
    writes=(add_output("the report and reading.toml, for recut"), add_json, add_units, add_plots),
)
