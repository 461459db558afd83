"""``autobalance design DESIGN.toml -o DIR``: counterweight profiles searched for the best."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_workers


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("design", metavar="DESIGN.toml", help="the start, what is free, what must be kept")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="folder of the designs")
    parser.add_argument("--fresh", action="store_true", help="forget what DIR holds of another search")
    add_workers(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Search; 0 where a design keeps everything, else 4."""
    from autobalance.api.design import design
    from autobalance.command.console import say
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown

    with shown() as progress:
        result = design(
            arguments.design,
            arguments.output,
            fresh=arguments.fresh,
            workers=arguments.workers,
            cluster=arguments.cluster,
            cluster_timeout_s=arguments.cluster_timeout,
            progress=progress,
        )
    folder = Path(arguments.output)
    arguments.output = None  # its files are in place already
    code = finish(arguments, result, sources=(arguments.design,))
    if arguments.json != "-":
        say(f"\nWritten: {folder / 'design.json'} and {len(result.files())} more in {folder}")
    return code
