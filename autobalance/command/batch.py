"""``autobalance batch LIST|FOLDER -o DIR``: many jobs, resumable, one table."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_set, add_workers, kinds_of, workers_given


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("source", metavar="LIST|FOLDER", help="a list (CSV, workbook) or a folder of jobs")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="folder of the results")
    parser.add_argument(
        "--job", metavar="JOB.toml", help="the job of rows that name none; a folder holds cranks then"
    )
    parser.add_argument(
        "--only",
        metavar="LIST",
        type=kinds_of,
        default=("json",),
        help="files beside each solid: json, html, pdf, xlsx, png (default: json)",
    )
    parser.add_argument("--fresh", action="store_true", help="forget what DIR holds of an earlier batch")
    add_set(parser)
    add_workers(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Run the batch; 0 where every row is within tolerance, else 4."""
    from autobalance.api.batch import batch
    from autobalance.command.finish import finish_in_place
    from autobalance.command.progress import shown

    with shown() as progress:
        result = batch(
            arguments.source,
            arguments.output,
            job=arguments.job,
            settings=arguments.settings,
            only=arguments.only,
            fresh=arguments.fresh,
            progress=progress,
            **workers_given(arguments),
        )
    folder = Path(arguments.output)
    written = ", ".join(str(folder / name) for name in ("results.csv", "results.xlsx", "summary.html"))
    return finish_in_place(arguments, result, (arguments.source,), written)
