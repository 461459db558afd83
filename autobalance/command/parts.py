"""``autobalance parts JOB.toml``: the weights of a job rolled up, and its bob-weights."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots, add_set, add_units


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "job", metavar="JOB.toml", help="the job; its crank is read for factor = original only"
    )
    add_set(parser)
    add_json(parser)
    add_units(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Roll up the weights; 0 unless the job is bad."""
    from autobalance.api.job import read_job
    from autobalance.api.parts import parts
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown

    with shown() as progress:
        result = parts(read_job(arguments.job, arguments.settings), progress=progress)
    return finish(arguments, result, sources=(arguments.job,))
