"""``autobalance machine MACHINE.toml``: what a balancing machine would read."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots, add_units


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("machine", metavar="MACHINE.toml", help="machine, rotor, its unbalance, noise")
    parser.add_argument("-o", dest="output", metavar="DIR", help="write reading.toml, for `recut`, to DIR")
    add_json(parser)
    add_units(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print the reading; 0 unless something is wrong with the file."""
    from autobalance.api.machine import machine
    from autobalance.command.finish import finish

    return finish(arguments, machine(arguments.machine), (arguments.machine,))
