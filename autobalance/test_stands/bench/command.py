"""``autobalance bench BENCH.toml``: a rotor under speed control, or crank variants in an engine."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from autobalance.command.options import add_json, add_output, add_plots, add_series
from autobalance.command.verb import NOT_TYPED, Keywords, Option, Verb
from autobalance.errors import UsageError

if TYPE_CHECKING:
    from autobalance.test_stands.bench.engine_verb import EngineBenchResult
    from autobalance.test_stands.bench.verb import BenchResult


def _series(result: BenchResult | EngineBenchResult) -> bytes:
    if not result.report.get("runs", True):
        raise UsageError("--series needs runs, and a [bearing] in the file for them")
    return result.series()


def _with_solids(keywords: Keywords, arguments: argparse.Namespace) -> None:
    keywords["solids"] = arguments.output is not None


VERB = Verb(
    "test_stands.bench.verb:bench",
    examples=("autobalance bench bench.toml --series runs.csv -o bench",),
    options={"bench_file": Option(metavar="BENCH.toml"), "solids": NOT_TYPED},
    writes=(
        add_series("speed and torque over time, or torque by angle"),
        add_output("the report, the series and the rotor as STL, STEP and drawing"),
        add_json, add_plots,
    ),
    adjust=_with_solids,
    series=_series,
)  # fmt: skip
