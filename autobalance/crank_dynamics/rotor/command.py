"""``autobalance rotor ROTOR.toml|CRANK``: a shaft on bearings, its critical speeds, modes and response."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots
from autobalance.command.verb import Option, Verb
from autobalance.solid.formats.table import endings

VERB = Verb(
    "crank_dynamics.rotor.verb:rotor",
    examples=(
        "autobalance rotor rotor.toml --plots plots",
        "autobalance rotor crank.stl --unit mm --speed-rpm 12000 --bearing 1e8",
    ),
    options={
        "source": Option(metavar="ROTOR.toml|CRANK", endings=endings),
        "unit": Option(metavar="UNIT"),
        "bearing_n_m": Option(("--bearing",), metavar="N/M"),
    },
    writes=(add_json, add_plots),
)
