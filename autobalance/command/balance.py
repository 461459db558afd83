"""``autobalance balance JOB.toml``: measure, plan, cut, measure again; write the solid and the report."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from autobalance.command.options import add_json, add_pages, add_set, add_units, choice_of
from autobalance.command.progress import Mode, add_progress, mode_of

if TYPE_CHECKING:
    from autobalance.api.balance import BalancedFiles
    from autobalance.job import Job
    from autobalance.report.bundle import Choice


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("job", metavar="JOB.toml", help="the job: crank file, weights, tolerance, correction")
    parser.add_argument(
        "-o", "--output", metavar="DIR", help="folder of the results (default: NAME-balanced beside the job)"
    )
    add_set(parser)
    add_json(parser)
    add_units(parser)
    add_pages(parser)
    add_progress(parser)


def run(arguments: argparse.Namespace) -> int:
    """Balance a crank; 0 within tolerance, 4 above it."""
    from autobalance import job
    from autobalance.command.console import say

    asked = job.load(arguments.job, arguments.settings)
    folder = Path(arguments.output) if arguments.output else default_folder(asked.path)
    done = balanced(asked, folder, arguments.json, choice_of(arguments), mode_of(arguments))
    from autobalance.report.json import dumps
    from autobalance.report.text import UNITS, balance_text

    if arguments.json == "-":
        say(dumps(done.report).removesuffix("\n"))
    else:
        say(balance_text(done.report, UNITS[arguments.units]))
        say("\nWritten: " + ", ".join(str(path) for path in done.files))
    return done.result.exit_code


def default_folder(job_path: Path) -> Path:
    """Return the folder of a job's results where none is asked for."""
    return job_path.with_name(f"{job_path.stem}-balanced")


def balanced(
    asked: Job, folder: Path, json_file: str | None = None, choice: Choice | None = None, mode: Mode = "usual"
) -> BalancedFiles:
    """Run a job and put its files in place."""
    from autobalance.api.balance import balance_to_files
    from autobalance.api.progress import telling
    from autobalance.command.console import warn
    from autobalance.command.progress import shown

    with shown(mode) as progress:
        done = balance_to_files(asked, folder, json_file, telling(progress), choice)
    for text in done.warnings:
        warn(text)
    return done
