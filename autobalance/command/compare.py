"""``autobalance compare JOB.toml``: every kind of correction and the useful mixes on one crank."""

from __future__ import annotations

import argparse
from typing import Any

from autobalance.command.options import add_units


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "job",
        metavar="JOB.toml",
        help="the job; each kind takes its limits from its own table there, else their defaults",
    )
    parser.add_argument(
        "--json", metavar="FILE", help="write the comparison to FILE too; - prints it, and nothing else"
    )
    add_units(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compare; 0 if some kind comes within tolerance (or nothing is to be cut), 4 if none does."""
    from pathlib import Path

    from autobalance import job
    from autobalance.balancing.run import compare_job
    from autobalance.command.console import progress, progress_done, say
    from autobalance.report.comparison import comparison, comparison_text
    from autobalance.report.files import Staging
    from autobalance.report.json import dumps
    from autobalance.report.text import UNITS

    asked = job.load(arguments.job)

    def compared() -> dict[str, Any]:
        done = compare_job(asked, progress)
        return comparison(str(asked.path), done.tolerance, done.initial_g_mm, done.rows)

    try:
        if arguments.json in (None, "-"):
            values = compared()
        else:
            target = Path(arguments.json)
            with Staging([target.parent]) as staging:
                values = compared()
                staging.add(target, dumps(values).encode())
                staging.commit()
    finally:
        progress_done()
    if arguments.json == "-":
        say(dumps(values).removesuffix("\n"))
    else:
        say(comparison_text(values, UNITS[arguments.units]))
    good = ("within_tolerance", "already_within_tolerance")
    return 0 if any(row["outcome"] in good for row in values["rows"]) else 4
