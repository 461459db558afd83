"""``autobalance design DESIGN.toml -o DIR``: counterweight profiles searched for the best."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_workers, workers_given


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
    from autobalance.command.finish import finish_in_place
    from autobalance.command.progress import shown

    with shown() as progress:
        result = design(
            arguments.design,
            arguments.output,
            fresh=arguments.fresh,
            progress=progress,
            **workers_given(arguments),
        )
    folder = Path(arguments.output)
    written = f"{folder / 'design.json'} and {len(result.files())} more in {folder}"
    return finish_in_place(arguments, result, (arguments.design,), written)
