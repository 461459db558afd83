"""``autobalance bearing BEARING.toml``: friction, film, stiffness and damping; the film through a cycle."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_plots
from autobalance.errors import UsageError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("bearing", metavar="BEARING.toml", help="the bearing, and its loads by angle if any")
    parser.add_argument(
        "--series", metavar="FILE.csv", help="write the journal's orbit by angle; needs [history]"
    )
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Find friction and film; 0 unless something is wrong with the bearing."""
    from autobalance.api.bearing import bearing
    from autobalance.command.finish import finish

    result = bearing(arguments.bearing)
    files: dict[Path, bytes] = {}
    if arguments.series is not None:
        series = result.series()
        if series is None:
            raise UsageError("--series needs a [history] of loads: without one there is no orbit")
        files[Path(arguments.series)] = series
    return finish(arguments, result, (arguments.bearing,), files)
