"""``autobalance recut REPORT.json READING.toml``: further cuts, from what a balancing machine read."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.console import add_progress, mode_of
from autobalance.command.options import (
    add_json,
    add_open,
    add_pages,
    add_shop_units,
    add_strict,
    chosen_pages,
)
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "verbs.recut:recut",
    examples=("autobalance recut job-balanced/report.json reading.toml",),
    options={
        "report": Option(metavar="REPORT.json"),
        "reading": Option(metavar="READING.toml"),
        "folder": Option(("-o", "--output"), metavar="DIR"),
    },
    writes=(add_json, add_shop_units, add_pages, add_strict, add_open, add_progress),
)


def run(arguments: argparse.Namespace) -> int:
    """Cut further; 0 within tolerance, 4 above it or where the machine cannot show it."""
    from autobalance.command.balance import page_of
    from autobalance.command.console import say_as_it_is, shown, warn
    from autobalance.command.finish import judged, say_result
    from autobalance.errors import UsageError
    from autobalance.report.balance.recut_text import recut_text
    from autobalance.report.balance.values import dumps
    from autobalance.report.display_units import ON_SCREEN
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
        text = recut_text(values, units, folder, arguments.verbose, arguments.zero)
        page = page_of(folder, values) or folder / values["outputs"]["history"]["file"]
        say_result(text, files, warnings, page, arguments.open)
    return judged(result, arguments)
