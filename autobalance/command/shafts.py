"""``autobalance shafts JOB.toml``: shafts that would cancel orders 1 and 2, and what the job's own leave."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots, add_reference, add_set, add_speed, add_units


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("job", metavar="JOB.toml", help="the job; engine.rod_length_mm is needed here")
    add_speed(parser)
    add_reference(parser)
    add_set(parser)
    add_json(parser)
    add_units(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compute the shafts; 0 unless the job or the crank is bad."""
    from autobalance.api.job import read_job
    from autobalance.api.shafts import shafts
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown

    with shown() as progress:
        result = shafts(
            read_job(arguments.job, arguments.settings),
            speed_rpm=arguments.speed_rpm,
            reference_z_mm=arguments.reference_z,
            progress=progress,
        )
    return finish(arguments, result, sources=(arguments.job,))
