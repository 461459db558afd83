"""``autobalance recut REPORT.json READING.toml``: further cuts, from what a balancing machine read."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_pages, add_units, chosen_pages
from autobalance.command.progress import add_progress, mode_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("report", metavar="REPORT.json", help="of `balance` or `recut`, its solid beside it")
    parser.add_argument("reading", metavar="READING.toml", help="what the balancing machine read")
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        help="folder of the results (default: stage-N beside stage 1's report)",
    )
    parser.add_argument(
        "--trust-reading", action="store_true", help="go on though a usual mistake would explain the reading"
    )
    add_json(parser)
    add_units(parser)
    add_pages(parser)
    add_progress(parser)


def run(arguments: argparse.Namespace) -> int:
    """Cut further; 0 within tolerance, 4 above it or where the machine cannot show it."""
    from autobalance.api.progress import telling
    from autobalance.api.recut import recut
    from autobalance.api.result_files import committed, staging_for
    from autobalance.command.console import say, warn
    from autobalance.command.progress import shown
    from autobalance.errors import UsageError
    from autobalance.report.balance.values import dumps

    copy = None if arguments.json in (None, "-") else Path(arguments.json)
    for source in (arguments.report, arguments.reading):
        if copy is not None and copy.resolve() == Path(source).resolve():
            raise UsageError(f"--json {copy} would overwrite a file that is read; choose another place")
    with shown(mode_of(arguments)) as progress:
        result = recut(
            arguments.report,
            arguments.reading,
            folder=arguments.output,
            trust_reading=arguments.trust_reading,
            progress=progress,
        )
        folder = result.folder
        if (folder / "report.json").resolve() == Path(arguments.report).resolve():
            raise UsageError(f"{folder} holds the report that is read; choose another folder with -o")
        with staging_for(folder, copy) as staging:
            choice, tell = chosen_pages(arguments), telling(progress)
            values, files = committed(result, folder, choice, tell, staging, copy)
    for text in result.warnings:
        warn(text)
    if arguments.json == "-":
        say(dumps(values).removesuffix("\n"))
    else:
        say(result.text(arguments.units))
        say("\nWritten: " + ", ".join(str(path) for path in files))
    return result.exit_code
