"""``autobalance torsion FILE.toml``: torsional vibration of a job's crank, or of a chain of its own."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots, add_set


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("file", metavar="FILE.toml", help="a job, or a chain of [[inertia]] and [[spring]]")
    add_set(parser)
    parser.add_argument(
        "--fem", action="store_true", help="twist each throw's own metal by finite elements too (extra fem)"
    )
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compute; 0 unless the file or the crank is bad."""
    from autobalance.api.torsion import torsion
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown

    with shown() as progress:
        result = torsion(
            arguments.file,
            settings=arguments.settings,
            fem=True if arguments.fem else None,
            progress=progress,
        )
    return finish(arguments, result, sources=(arguments.file,))
