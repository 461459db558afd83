"""``autobalance machine MACHINE.toml``: what a balancing machine would read."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_output, add_plots, add_units
from autobalance.command.verb import Option, Verb

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


VERB = Verb(
    "test_stands.machine.verb:machine",
    examples=(
        "autobalance machine machine.toml -o readings",
        "autobalance machine machine.toml --watch serial:/dev/ttyUSB0 --report job-balanced/report.json",
        "autobalance machine machine.toml --wizard",
    ),
    options={"machine_file": Option(metavar="MACHINE.toml")},
    writes=(add_output("the report and reading.toml, for recut"), add_json, add_units, add_plots, add_live),
)


def run(arguments: argparse.Namespace) -> int:
    """Simulate a machine, follow a real one, or find how exact it is."""
    from autobalance.errors import UsageError

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
    return VERB.run(arguments)
