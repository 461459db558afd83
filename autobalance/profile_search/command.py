"""``autobalance design DESIGN.toml -o DIR``: counterweight profiles searched for the best."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.verb import Option, Verb

VERB = Verb(
    "profile_search.verb:design",
    examples=("autobalance design design.toml -o designs --workers 4",),
    options={
        "source": Option(metavar="DESIGN.toml"),
        "output": Option(("-o", "--output"), metavar="DIR", required=True),
    },
)


def run(arguments: argparse.Namespace) -> int:
    """Search; 0 where a design keeps everything, else 4."""
    from autobalance.command.console import shown
    from autobalance.command.finish import finish_in_place
    from autobalance.profile_search.verb import design

    with shown() as progress:
        result = design(**VERB.keywords(arguments), progress=progress)
    folder = Path(arguments.output)
    written = f"{folder / 'design.json'} and {len(result.files())} more in {folder}"
    return finish_in_place(arguments, result, (arguments.source,), written)
