"""``autobalance influence TRIALS.toml``: weights that correct, from readings with trial weights."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots, add_units


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("trials", metavar="TRIALS.toml", help="readings without and with trial weights")
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        help="write the report to DIR, and with [reading] reading.toml for recut",
    )
    add_json(parser)
    add_units(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print what to add; 4 where a reading stays above the target."""
    from autobalance.api.influence import influence
    from autobalance.command.finish import finish

    return finish(arguments, influence(arguments.trials), (arguments.trials,))
