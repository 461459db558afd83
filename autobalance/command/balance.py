"""``autobalance balance JOB.toml``: measure, plan, cut, measure again; write the solid and the report."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import (
    add_json,
    add_output,
    add_pages,
    add_shop_units,
    add_strict,
    chosen_pages,
    units_of,
)
from autobalance.command.progress import add_progress, mode_of
from autobalance.command.verb import NOT_TYPED, Option, Verb

VERB = Verb(
    "verbs.balance:balance",
    examples=(
        "autobalance balance job.toml",
        "autobalance balance job.toml --set balance.factor=0.5 -o half --only html,pdf",
    ),
    options={
        "job": Option(metavar="JOB.toml"),
        "cuts": NOT_TYPED,
        "keep": Option(metavar="REPORT.json", usual="the job's correction.keep"),
    },
    writes=(
        add_output("the results", "NAME-balanced beside the job"),
        add_json,
        add_shop_units,
        add_pages,
        add_strict,
        add_progress,
    ),
)


def run(arguments: argparse.Namespace) -> int:
    """Balance a crank; 0 within tolerance, 4 above it."""
    from dataclasses import replace  # which loads inspect: a fifth of what --help takes

    from autobalance.command.console import say
    from autobalance.command.finish import balanced, judged

    this_job = VERB.keywords(arguments)["job"]
    arguments.units = units_of(arguments, this_job.filled.get("shop"))
    if arguments.keep is not None:
        this_job = replace(this_job, keep=Path(arguments.keep))
    folder = Path(arguments.output) if arguments.output else default_folder(this_job.path)
    done = balanced(
        this_job, folder, arguments.json, chosen_pages(arguments), mode_of(arguments), arguments.fem
    )
    from autobalance.report.balance.text import balance_text
    from autobalance.report.balance.values import dumps
    from autobalance.report.display_units import ON_SCREEN

    if arguments.json == "-":
        say(dumps(done.report).removesuffix("\n"))
    else:
        say(balance_text(done.report, ON_SCREEN[arguments.units], folder))
        say("\nWritten: " + ", ".join(str(path) for path in done.files))
    return judged(done.result, arguments)


def default_folder(job_path: Path) -> Path:
    """Return the folder of a job's results where none is requested."""
    return job_path.with_name(f"{job_path.stem}-balanced")
