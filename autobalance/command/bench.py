"""``autobalance bench BENCH.toml``: a rotor under speed control, or crank variants in an engine."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_output, add_plots, add_series
from autobalance.command.verb import NOT_TYPED, Keywords, Option, Verb


def _with_solids(given: Keywords, arguments: argparse.Namespace) -> None:
    given["solids"] = arguments.output is not None


VERB = Verb(
    "api.bench:bench",
    examples=("autobalance bench bench.toml --series runs.csv -o bench",),
    options={"bench_file": Option(metavar="BENCH.toml"), "solids": NOT_TYPED},
    writes=(
        add_series("speed and torque over time, or torque by angle"),
        add_output("the report, the series and the rotor as STL, STEP and drawing"),
        add_json, add_plots,
    ),
    adjust=_with_solids,
    series=lambda result: result.series(),
)  # fmt: skip
