"""``autobalance compare JOB.toml``: every kind of correction and the useful mixes on one crank."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_units
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "verbs.compare:compare",
    examples=("autobalance compare job.toml --json comparison.json",),
    options={"job": Option(metavar="JOB.toml")},
    writes=(add_json, add_units),
)


def run(arguments: argparse.Namespace) -> int:
    """Compare; 0 if some kind comes within tolerance (or no cut is needed), 4 if none does."""
    from pathlib import Path

    from autobalance.command.finish import finish
    from autobalance.command.progress import shown
    from autobalance.report.files import Staging
    from autobalance.verbs.compare import compare

    copy = None if arguments.json in (None, "-") else Path(arguments.json)
    with Staging([] if copy is None else [copy.parent]), shown() as progress:  # that it can be written
        result = compare(**VERB.keywords(arguments), progress=progress)
    return finish(arguments, result, sources=(arguments.job,))
