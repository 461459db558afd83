"""``autobalance schema [NAME]``: the JSON Schema of a file that the program reads or writes."""

from __future__ import annotations

import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = "examples:\n  autobalance schema\n  autobalance schema job > job.schema.json"
    parser.add_argument(
        "name", metavar="NAME", nargs="?", help="name of the kind of file (default: the names are listed)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print a schema, or the names of all; 2 for an unknown name."""
    from autobalance.command.console import say_as_it_is
    from autobalance.report.balance.values import dumps
    from autobalance.verbs.schema import NAMES, schema

    if arguments.name is None:
        say_as_it_is("\n".join(NAMES))
    else:
        say_as_it_is(dumps(schema(arguments.name)).removesuffix("\n"))
    return 0
