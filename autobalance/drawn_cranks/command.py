"""``autobalance generate PRESET|FILE.toml``: build a crankshaft from dimensions, and say what it weighs."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_units, dimensions
from autobalance.command.verb import SUGGEST_OPTION, Option, Verb
from autobalance.errors import UsageError
from autobalance.solid.formats.table import written_endings

# Names of the bundled designs, for the help of the command: it loads no design.


PRESET_NAMES = (
    "single",
    "pressed-up-single",
    "pressed-up-single-no-pin",
    "v-twin-45",
    "parallel-twin-360",
    "inline-3",
    "inline-4",
    "inline-6",
    "v6-60",
    "v8-crossplane",
    "v8-flatplane",
    "v12-60",
)


def _presets() -> tuple[str, ...]:
    return PRESET_NAMES


VERB = Verb(
    "drawn_cranks.verb:generate",
    examples=(
        "autobalance generate single -o crank.stl",
        "autobalance generate inline-4 --set counterweight.radius_mm=60 --suggest balance_factor=0.5",
    ),
    notes=lambda: f"presets: {', '.join(_presets())}",
    options={
        "design": Option(metavar="PRESET|FILE.toml"),
        "file": Option(("-o", "--output"), metavar="FILE", endings=written_endings),
        "segments": Option(metavar="N"),
        "settings": Option(("--set",), metavar="KEY=VALUE", read=dimensions, repeated=True),
        "suggest": SUGGEST_OPTION,
    },
    writes=(add_json, add_units),
)


def run(arguments: argparse.Namespace) -> int:
    """Build a crank and write it; 0 unless the description is bad."""
    from autobalance.command.console import say, say_as_it_is, shown
    from autobalance.drawn_cranks.verb import generate
    from autobalance.report.files import Staging

    report_file = None if arguments.json in (None, "-") else Path(arguments.json)
    folders = [] if arguments.file is None else [Path(arguments.file).parent]
    folders += [] if report_file is None else [report_file.parent]
    with Staging(folders) as staging, shown() as progress:
        result = generate(**VERB.keywords(arguments), progress=progress)
        targets = [result.file] if report_file is None else [result.file, report_file]
        _refuse_overwriting(targets, Path(arguments.design))
        staging.add(result.file, result.data)
        if report_file is not None:
            staging.add(report_file, result.json().encode())
        staging.commit()
    if arguments.json == "-":
        say_as_it_is(result.json().removesuffix("\n"))
    else:
        say(result.text(arguments.units))
    return 0


def _refuse_overwriting(targets: list[Path], source: Path) -> None:
    places = [path.resolve() for path in (*targets, source)]
    if len(set(places)) < len(places):
        raise UsageError("the description, the crank and the report must be files of different names")
