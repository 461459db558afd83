"""``autobalance compare JOB.toml|CRANK``: every kind of correction and the useful mixes on one crank."""

from __future__ import annotations

import argparse

from autobalance.command.console import add_progress, mode_of
from autobalance.command.options import add_json, add_open, add_output, add_units
from autobalance.command.verb import Option, Verb
from autobalance.solid.formats.table import endings

VERB = Verb(
    "verbs.compare:compare",
    examples=("autobalance compare job.toml --json comparison.json",),
    options={"job": Option(metavar="JOB.toml|CRANK", endings=endings)},
    writes=(
        add_output("the page and the report", "the page in NAME-compare beside the job"),
        add_json,
        add_units,
        add_open,
        add_progress,
    ),
    of_crank=True,
)


def run(arguments: argparse.Namespace) -> int:
    """Compare; 0 if some kind comes within tolerance (or no cut is needed), 4 if none does."""
    from pathlib import Path

    from autobalance.command.console import shown
    from autobalance.command.finish import finish
    from autobalance.report.files import Staging
    from autobalance.verbs.compare import compare

    copy = None if arguments.json in (None, "-") else Path(arguments.json)
    that_can_be_written = Staging([] if copy is None else [copy.parent])
    with that_can_be_written, shown(mode_of(arguments)) as progress:
        keywords = VERB.keywords(arguments)
        result = compare(**keywords, progress=progress)
    return finish(arguments, result, sources=(arguments.job,), files=VERB.job_file(keywords))
