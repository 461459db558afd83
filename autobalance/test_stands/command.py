"""Command lines of the verbs of balancing machines and test benches."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from autobalance.command.options import add_json, add_output, add_plots, add_series, add_units
from autobalance.command.verb import NOT_TYPED, Keywords, Option, Verb
from autobalance.errors import UsageError

if TYPE_CHECKING:
    from autobalance.test_stands.bench.engine_verb import EngineBenchResult
    from autobalance.test_stands.bench.verb import BenchResult


# ``autobalance influence TRIALS.toml``: weights that correct, from readings with trial weights.


INFLUENCE = Verb(
    "test_stands.influence.verb:influence",
    examples=("autobalance influence trials.toml --plots plots",),
    options={"trials": Option(metavar="TRIALS.toml")},
    writes=(
        add_output("the report, and with [reading] a reading.toml for recut"), add_json, add_units, add_plots,
    ),
)  # fmt: skip


# ``autobalance machine MACHINE.toml``: what a balancing machine would read.


WATCHED_S = 600.0


def add_live(parser: argparse.ArgumentParser) -> None:
    """Add the options for reading a real machine instead of simulating one."""
    parser.add_argument(
        "--watch",
        metavar="SOURCE",
        help="file or serial:DEVICE[:BAUD] whose lines are followed, in the form of [machine.line], until "
        "the vectors settle; writes reading.toml (default: the machine is simulated)",
    )
    parser.add_argument(
        "--report",
        metavar="REPORT.json",
        help="report that --watch hands the settled reading to, for recut (default: none)",
    )
    parser.add_argument(
        "--timeout",
        metavar="S",
        type=float,
        default=WATCHED_S,
        help=f"longest time that --watch waits [s] (default: {WATCHED_S:g})",
    )
    parser.add_argument(
        "--wizard",
        action="store_true",
        help="ask for three repeated readings and an index test, and compute urr_percent and umar_g_mm for "
        "[reading] (default: the machine is simulated)",
    )


def _machine(arguments: argparse.Namespace) -> int:
    """Simulate a machine, follow a real one, or find how exact it is."""
    if arguments.wizard:
        from autobalance.test_stands.machine.watch import wizard

        return wizard()
    if arguments.watch is not None:
        from autobalance.test_stands.machine.watch import watch

        return watch(
            arguments.machine_file, arguments.watch, arguments.output, arguments.report, arguments.timeout
        )
    if arguments.report is not None:
        raise UsageError("--report takes what --watch reads; name its source with --watch")
    return MACHINE.call(arguments)


MACHINE = Verb(
    "test_stands.machine.verb:machine",
    examples=(
        "autobalance machine machine.toml -o readings",
        "autobalance machine machine.toml --watch serial:/dev/ttyUSB0 --report job-balanced/report.json",
        "autobalance machine machine.toml --wizard",
    ),
    options={"machine_file": Option(metavar="MACHINE.toml")},
    writes=(add_output("the report and reading.toml, for recut"), add_json, add_units, add_plots, add_live),
    runs=_machine,
)


# ``autobalance bench BENCH.toml``: a rotor under speed control, or crank variants in an engine.


def _series(result: BenchResult | EngineBenchResult) -> bytes:
    if not result.report.get("runs", True):
        raise UsageError("--series needs runs, and a [bearing] in the file for them")
    return result.series()


def _with_solids(keywords: Keywords, arguments: argparse.Namespace) -> None:
    keywords["solids"] = arguments.output is not None


BENCH = Verb(
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
