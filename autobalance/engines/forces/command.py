"""``autobalance forces JOB.toml|CRANK``: orders, bearing loads and balance factors of the job's engine."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots
from autobalance.command.readers import numbers
from autobalance.command.verb import Option, Verb
from autobalance.solid.formats.table import endings

VERB = Verb(
    "engines.forces.verb:forces",
    examples=(
        "autobalance forces job.toml",
        "autobalance forces job.toml --speed-rpm 9000 --factors 0,0.5,1 --plots plots",
    ),
    options={
        "job": Option(metavar="JOB.toml|CRANK", endings=endings),
        "factors": Option(metavar="F,F,...", read=numbers),
        "transverse_weight": Option(metavar="W"),
    },
    writes=(add_json, add_plots),
    of_crank=True,
)
