"""Command lines of the verbs that plan, make and check cuts."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.command.console import add_objects, add_progress, mode_of
from autobalance.command.options import (
    add_json,
    add_open,
    add_output,
    add_pages,
    add_shop_units,
    add_strict,
    add_units,
    add_verbose,
    chosen_pages,
)
from autobalance.command.verb import NOT_TYPED, Option, Verb
from autobalance.solid.formats.table import endings

if TYPE_CHECKING:
    from autobalance.job import Job


# ``autobalance balance JOB.toml|CRANK``: plan, cut, measure again; write solid and report.


def _balance(arguments: argparse.Namespace) -> int:
    """Balance a crank; 0 within tolerance, 4 above it."""
    from dataclasses import replace  # which loads inspect: a fifth of what --help takes

    from autobalance.command.console import say_as_it_is, warn
    from autobalance.command.finish import balanced, judged, say_result

    this_job = BALANCE.keywords(arguments)["job"]
    if arguments.keep is not None:
        this_job = replace(this_job, keep=Path(arguments.keep))
    folder = Path(arguments.output) if arguments.output else default_folder(this_job)
    done = balanced(
        this_job, folder, arguments.json, chosen_pages(arguments), mode_of(arguments), arguments.fem
    )
    from autobalance.report.balance.text import balance_text
    from autobalance.report.balance.values import dumps
    from autobalance.report.display_units import ON_SCREEN
    from autobalance.report.records.balanced import BalancedReport

    if arguments.json == "-":
        for text in done.warnings:
            warn(text)
        say_as_it_is(dumps(done.report).removesuffix("\n"))
    else:
        units = ON_SCREEN[arguments.units]
        text = balance_text(
            BalancedReport.read(done.report), units, folder, arguments.verbose, arguments.zero
        )
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


BALANCE = Verb(
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
    runs=_balance,
)


# ``autobalance compare JOB.toml|CRANK``: every kind of correction and the useful mixes on one crank.


def _compare(arguments: argparse.Namespace) -> int:
    """Compare; 0 if some kind comes within tolerance (or no cut is needed), 4 if none does."""
    from autobalance.command.console import shown
    from autobalance.command.finish import finish
    from autobalance.report.files import Staging
    from autobalance.verbs.compare import compare

    copy = None if arguments.json in (None, "-") else Path(arguments.json)
    that_can_be_written = Staging([] if copy is None else [copy.parent])
    with that_can_be_written, shown(mode_of(arguments)) as progress:
        keywords = COMPARE.keywords(arguments)
        result = compare(**keywords, progress=progress)
    return finish(arguments, result, sources=(arguments.job,), files=COMPARE.job_file(keywords))


COMPARE = Verb(
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
    runs=_compare,
)


# ``autobalance recut REPORT.json READING.toml``: further cuts, from what a balancing machine read.


def _recut(arguments: argparse.Namespace) -> int:
    """Cut further; 0 within tolerance, 4 above it or where the machine cannot show it."""
    from autobalance.command.console import say_as_it_is, shown, warn
    from autobalance.command.finish import judged, say_result
    from autobalance.errors import UsageError
    from autobalance.report.balance.text import recut_text
    from autobalance.report.balance.values import dumps
    from autobalance.report.display_units import ON_SCREEN
    from autobalance.report.records.balanced import BalancedReport
    from autobalance.verbs.progress import telling
    from autobalance.verbs.recut import recut
    from autobalance.verbs.result_files import committed, staging_for

    copy = None if arguments.json in (None, "-") else Path(arguments.json)
    for source in (arguments.report, arguments.reading):
        if copy is not None and copy.resolve() == Path(source).resolve():
            raise UsageError(f"--json {copy} would overwrite a file that is read; choose another place")
    with shown(mode_of(arguments)) as progress:
        result = recut(**RECUT.keywords(arguments), progress=progress)
        folder = result.folder
        if (folder / "report.json").resolve() == Path(arguments.report).resolve():
            raise UsageError(f"{folder} holds the report that is read; choose another folder with -o")
        with staging_for(folder, copy) as staging:
            choice, notify = chosen_pages(arguments), telling(progress)
            values, files, notes = committed(result, folder, choice, notify, staging, copy)
    warnings = (*result.warnings, *notes)
    if arguments.json == "-":
        for text in warnings:
            warn(text)
        say_as_it_is(dumps(values).removesuffix("\n"))
    else:
        units = ON_SCREEN[arguments.units]
        text = recut_text(BalancedReport.read(values), units, folder, arguments.verbose, arguments.zero)
        page = page_of(folder, values) or folder / values["outputs"]["history"]["file"]
        say_result(text, files, warnings, page, arguments.open)
    return judged(result, arguments)


RECUT = Verb(
    "verbs.recut:recut",
    examples=("autobalance recut job-balanced/report.json reading.toml",),
    options={
        "report": Option(metavar="REPORT.json"),
        "reading": Option(metavar="READING.toml"),
        "folder": Option(("-o", "--output"), metavar="DIR"),
    },
    writes=(add_json, add_shop_units, add_pages, add_strict, add_open, add_progress),
    runs=_recut,
)


# ``autobalance verify REPORT.json``: read the corrected solid again and check every number claimed of it.


VERIFY = Verb(
    "verbs.verify:verify",
    examples=("autobalance verify job-balanced/report.json --independent",),
    options={"report": Option(metavar="REPORT.json")},
    writes=(add_json, add_units, add_verbose, add_objects),
)
