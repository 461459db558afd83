"""``autobalance init CRANK``: a commented job for a crank, or a job in its other form."""

from __future__ import annotations

import argparse

from autobalance.command.verb import OPTIONS_OF_CRANK, Option, Verb, tell_commas
from autobalance.errors import FileError
from autobalance.solid.formats.table import endings


def _add_force(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--force", action="store_true", help="overwrite an existing file")


VERB = Verb(
    "verbs.init:init",
    examples=(
        "autobalance init crank.stl --unit mm                 write the job crank.toml",
        "autobalance init crank.stl --unit mm -o crank.xlsx   write it as a workbook",
        "autobalance init crank.toml -o crank.xlsx            convert a job, here or back",
        "autobalance init halves.stl --unit mm --set crankshaft.crankpin_in_file=false",
        "autobalance init --shop                              write shop.toml",
    ),
    options={
        "source": Option(metavar="CRANK|JOB", positional=True, endings=endings),
        "file": Option(("-o", "--output"), metavar="FILE"),
        "method": Option(metavar="M,M,..."),
    },
    also=(OPTIONS_OF_CRANK,),
    writes=(_add_force,),
)


def run(arguments: argparse.Namespace) -> int:
    """Write a job; 0 unless the crank is bad."""
    from autobalance.command.console import say, shown
    from autobalance.job.from_options import KEYS
    from autobalance.report.files import Staging
    from autobalance.verbs.init import init

    with shown() as progress:
        keywords = {name: value for name, value in VERB.keywords(arguments).items() if value is not None}
        tell_commas({name: value for name, value in keywords.items() if name in KEYS})
        result = init(**keywords, progress=progress)
    if result.file.exists() and not arguments.force:
        raise FileError(f"{result.file} exists; --force writes over it, -o FILE another")
    with Staging([result.file.parent]) as staging:
        staging.add(result.file, result.data)
        staging.commit()
    say(result.text())
    return 0
