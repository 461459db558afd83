"""``autobalance bench BENCH.toml``: a rotor under speed control, or crank variants in an engine."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_plots


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "bench",
        metavar="BENCH.toml",
        help="rotor, bearings, control, schedule, readings; or an engine and its crank variants",
    )
    parser.add_argument(
        "--series", metavar="FILE.csv", help="write speed and torque over time, or torque by angle"
    )
    parser.add_argument(
        "-o", "--output", metavar="DIR", help="write report, series and the rotor as STL, STEP and drawing"
    )
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print runs and comparison; 0 unless something is wrong with the file."""
    from autobalance.api.bench import bench
    from autobalance.command.finish import finish

    result = bench(arguments.bench, solids=arguments.output is not None)
    series = {} if arguments.series is None else {Path(arguments.series): result.series()}
    return finish(arguments, result, (arguments.bench,), series)
