"""Command lines of the verbs of many jobs."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import (
    add_json,
    add_open,
    add_output,
    add_plots,
    add_series,
    add_units,
    kinds_of,
)
from autobalance.command.verb import Option, Verb
from autobalance.solid.formats.table import endings

# ``autobalance study JOB.toml|REPORT.json|CRANK``: Monte Carlo tolerance study, and its yield.


STUDY = Verb(
    "studies.study.verb:study",
    examples=(
        "autobalance study job.toml --target 0.95",
        "autobalance study job-balanced/report.json --samples 100000 --workers 4",
    ),
    options={
        "job": Option(metavar="JOB.toml|REPORT.json|CRANK", endings=endings),
        "seed": Option(metavar="S"),
        "target": Option(metavar="P"),
    },
    writes=(
        add_output("page, report and cranks", "the page in NAME-study beside the job"),
        add_series("the cranks, one row each"),
        add_json,
        add_plots,
        add_units,
        add_open,
    ),
    series=lambda result: result.series,
    of_crank=True,
)


# ``autobalance batch LIST|FOLDER -o DIR``: many jobs, resumable, one table.


def _batch(arguments: argparse.Namespace) -> int:
    """Run the batch; 0 where every row is within tolerance, else 4."""
    from autobalance.command.console import shown
    from autobalance.command.finish import finish_in_place, refuse_in_results
    from autobalance.studies.batch.journal import JOURNAL
    from autobalance.studies.batch.run import ROWS, TABLES
    from autobalance.studies.batch.verb import batch

    refuse_in_results(arguments, (f"{ROWS}/", *TABLES, JOURNAL))
    _refuse_over_rows(arguments)
    with shown() as progress:
        result = batch(**BATCH.keywords(arguments), progress=progress)
    folder = Path(arguments.output)
    written = ", ".join(str(folder / name) for name in ("results.csv", "results.xlsx", "summary.html"))
    return finish_in_place(arguments, result, (arguments.source,), written)


def _refuse_over_rows(arguments: argparse.Namespace) -> None:
    """Refuse a ``--json`` over the list, or over a job or a crank that it names, before any row is done."""
    from contextlib import suppress

    from autobalance.errors import AutobalanceError, UsageError
    from autobalance.studies.batch.input import read_batch_list

    if arguments.json in (None, "-"):
        return
    rows = read_batch_list(Path(arguments.source), arguments.job and Path(arguments.job)).rows
    read = {Path(arguments.source), *(row.job_file for row in rows), *(row.crank_file for row in rows)}
    for row in {row.job_file: row for row in rows if row.crank_file is None}.values():
        with suppress(AutobalanceError):  # a row that fails later is one of the results
            read.add(row.read().crankshaft.file)
    if Path(arguments.json).resolve() in {path.resolve() for path in read if path is not None}:
        raise UsageError(f"--json {arguments.json} would overwrite a file that is read; choose another place")


BATCH = Verb(
    "studies.batch.verb:batch",
    examples=(
        "autobalance batch jobs/ -o results",
        "autobalance batch list.csv -o results --job job.toml --workers 4",
    ),
    options={
        "source": Option(metavar="LIST|FOLDER"),
        "output": Option(("-o", "--output"), metavar="DIR"),
        "job": Option(metavar="JOB.toml"),
        "only": Option(metavar="LIST", normal=kinds_of),
    },
    runs=_batch,
)


# ``autobalance jobs``: the archive of a shop.


JOBS = Verb(
    "studies.jobs:jobs",
    examples=("autobalance jobs results", "autobalance jobs results --find CRF250R -o archive"),
    options={"folder": Option(positional=True, metavar="FOLDER"), "find": Option(metavar="TEXT")},
    writes=(add_output("the report and jobs.csv"), add_json, add_units),
)
