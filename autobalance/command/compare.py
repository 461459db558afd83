"""``autobalance compare JOB.toml``: every kind of correction and the useful mixes on one crank."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_set, add_units


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "job",
        metavar="JOB.toml",
        help="the job; each kind takes its limits from its own table there, else their defaults",
    )
    add_set(parser)
    parser.add_argument(
        "--json", metavar="FILE", help="write the comparison to FILE too; - prints it, and nothing else"
    )
    add_units(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compare; 0 if some kind comes within tolerance (or nothing is to be cut), 4 if none does."""
    from pathlib import Path

    from autobalance.api.compare import compare
    from autobalance.api.job import read_job
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown
    from autobalance.report.files import Staging

    copy = None if arguments.json in (None, "-") else Path(arguments.json)
    with Staging([] if copy is None else [copy.parent]), shown() as progress:  # that it can be written
        result = compare(read_job(arguments.job, arguments.settings), progress=progress)
    return finish(arguments, result, sources=(arguments.job,))
