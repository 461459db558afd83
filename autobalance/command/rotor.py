"""``autobalance rotor ROTOR.toml``: a shaft on bearings, its critical speeds, modes and response."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("rotor", metavar="ROTOR.toml", help="shaft, discs, bearings, unbalances")
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compute; 0 unless the file is bad."""
    from autobalance.api.rotor import rotor
    from autobalance.command.finish import finish

    return finish(arguments, rotor(arguments.rotor), sources=(arguments.rotor,))
