"""``autobalance factor JOB.toml|CRANK``: the balance factor of a crank, and others to choose from."""

from __future__ import annotations

from autobalance.command.options import add_json, add_units
from autobalance.command.readers import numbers
from autobalance.command.verb import Option, Verb
from autobalance.solid.formats.table import endings

VERB = Verb(
    "engines.factor.verb:factor",
    examples=(
        "autobalance factor job.toml",
        "autobalance factor crank.stl --unit mm --material steel --rotating-g 134.04 --reciprocating-g 261.5",
        "autobalance factor job.toml --factors 0.28,0.6",
    ),
    options={
        "job": Option(metavar="JOB.toml|CRANK", endings=endings),
        "factors": Option(metavar="F,F,...", read=numbers, usual="none"),
    },
    writes=(add_json, add_units),
    of_crank=True,
)
