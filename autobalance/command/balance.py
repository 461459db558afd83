"""``autobalance balance JOB.toml|CRANK``: plan, cut, measure again; write solid and report."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.command.console import add_progress, mode_of
from autobalance.command.options import (
    add_json,
    add_open,
    add_output,
    add_pages,
    add_shop_units,
    add_strict,
    chosen_pages,
)
from autobalance.command.verb import NOT_TYPED, Option, Verb
from autobalance.solid.formats.table import endings

if TYPE_CHECKING:
    from autobalance.job import Job

VERB = Verb(
    "verbs.balance:balance",
    examples=(
        "autobalance balance job.toml",
        "autobalance balance crank.stl --unit mm --material steel --rotating-g 134.04 --reciprocating-g 261.5"
        " --factor 0.28 --grade G6.3 --speed-rpm 15200",
        "autobalance balance job.toml --set balance.factor=0.5 -o half --only html,pdf",
    ),
    options={
        "job": Option(metavar="JOB.toml|CRANK", endings=endings),
        "cuts": NOT_TYPED,
        "keep": Option(metavar="REPORT.json", usual="the job's correction.keep"),
    },
    writes=(
        add_output("the results", "NAME-balanced, next to the job, or in the working folder for a crank"),
        add_json,
        add_shop_units,
        add_pages,
        add_strict,
        add_open,
        add_progress,
    ),
    of_crank=True,
    most_used=("help", "output", "settings", "keep", "only", "strict", "open"),
)


def run(arguments: argparse.Namespace) -> int:
    """Balance a crank; 0 within tolerance, 4 above it."""
    from dataclasses import replace  # which loads inspect: a fifth of what --help takes

    from autobalance.command.console import say_as_it_is, warn
    from autobalance.command.finish import balanced, judged, say_result

    this_job = VERB.keywords(arguments)["job"]
    if arguments.keep is not None:
        this_job = replace(this_job, keep=Path(arguments.keep))
    folder = Path(arguments.output) if arguments.output else default_folder(this_job)
    done = balanced(
        this_job, folder, arguments.json, chosen_pages(arguments), mode_of(arguments), arguments.fem
    )
    from autobalance.report.balance.text import balance_text
    from autobalance.report.balance.values import dumps
    from autobalance.report.display_units import ON_SCREEN

    if arguments.json == "-":
        for text in done.warnings:
            warn(text)
        say_as_it_is(dumps(done.report).removesuffix("\n"))
    else:
        units = ON_SCREEN[arguments.units]
        text = balance_text(done.report, units, folder, arguments.verbose, arguments.zero)
        page = page_of(folder, done.report)
        say_result(text, done.files, done.warnings, page, arguments.open)
    return judged(done.result, arguments)


def page_of(folder: Path, report: Mapping[str, Any]) -> Path | None:
    """Return the page of a report in a folder; None where none was written."""
    written = report["outputs"].get("html")
    return None if written is None else folder / written["file"]


def default_folder(job: Job) -> Path:
    """Return the folder of a job's results if none is set."""
    return job.path.with_name(f"{job.name}-balanced") if job.unwritten is None else job.path.parent
