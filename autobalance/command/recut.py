"""``autobalance recut REPORT.json READING.toml``: further cuts, from what a balancing machine read."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import (
    add_json,
    add_pages,
    add_shop_units,
    add_strict,
    chosen_pages,
    units_of,
)
from autobalance.command.progress import add_progress, mode_of
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "verbs.recut:recut",
    examples=("autobalance recut job-balanced/report.json reading.toml",),
    options={
        "report": Option(metavar="REPORT.json"),
        "reading": Option(metavar="READING.toml"),
        "folder": Option(("-o", "--output"), metavar="DIR"),
    },
    writes=(add_json, add_shop_units, add_pages, add_strict, add_progress),
)


def run(arguments: argparse.Namespace) -> int:
    """Cut further; 0 within tolerance, 4 above it or where the machine cannot show it."""
    from autobalance.command.console import say, warn
    from autobalance.command.finish import judged
    from autobalance.command.progress import shown
    from autobalance.errors import UsageError
    from autobalance.report.balance.values import dumps
    from autobalance.verbs.progress import telling
    from autobalance.verbs.recut import recut
    from autobalance.verbs.result_files import committed, staging_for

    copy = None if arguments.json in (None, "-") else Path(arguments.json)
    for source in (arguments.report, arguments.reading):
        if copy is not None and copy.resolve() == Path(source).resolve():
            raise UsageError(f"--json {copy} would overwrite a file that is read; choose another place")
    with shown(mode_of(arguments)) as progress:
        result = recut(**VERB.keywords(arguments), progress=progress)
        folder = result.folder
        arguments.units = units_of(arguments, result.report["job"].get("shop"))
        if (folder / "report.json").resolve() == Path(arguments.report).resolve():
            raise UsageError(f"{folder} holds the report that is read; choose another folder with -o")
        with staging_for(folder, copy) as staging:
            choice, notify = chosen_pages(arguments), telling(progress)
            values, files, notes = committed(result, folder, choice, notify, staging, copy)
    for text in (*result.warnings, *notes):
        warn(text)
    if arguments.json == "-":
        say(dumps(values).removesuffix("\n"))
    else:
        say(result.text(arguments.units))
        say("\nWritten: " + ", ".join(str(path) for path in files))
    return judged(result, arguments)
