"""``autobalance bench BENCH.toml``: a rotor under speed control in its bearings."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_plots


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("bench", metavar="BENCH.toml", help="rotor, bearings, control, schedule, readings")
    parser.add_argument("--series", metavar="FILE.csv", help="write speed and torque over time")
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print runs and comparison; 0 unless something is wrong with the file."""
    from autobalance.api.bench import bench
    from autobalance.command.finish import finish

    result = bench(arguments.bench)
    series = {} if arguments.series is None else {Path(arguments.series): result.series()}
    return finish(arguments, result, (arguments.bench,), series)
