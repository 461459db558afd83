"""``autobalance generate PRESET|FILE.toml``: build a crankshaft from dimensions, and say what it weighs."""

from __future__ import annotations

import argparse
import tomllib
from pathlib import Path
from typing import Any

from autobalance.command.options import add_json, add_suggest, add_units, length_unit, suggest_of
from autobalance.errors import UsageError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    from autobalance.crank.parametric.design import PRESETS

    parser.epilog = f"presets: {', '.join(PRESETS)}"
    parser.add_argument("crank", metavar="PRESET|FILE.toml", help="a preset, or a description of the crank")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="the crank: .stl .obj .ply .off .3mf .glb, or .step with the extra (NAME.stl)",
    )
    parser.add_argument("--segments", type=int, metavar="N", help="corners of a full circle (128)")
    parser.add_argument(
        "--unit",
        type=length_unit,
        choices=("mm", "cm", "m", "inch"),
        default="mm",
        help="unit of a mesh file (mm)",
    )
    parser.add_argument(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a dimension, counterweight.radius_mm=60 say; may be given several times",
    )
    add_suggest(parser, "say what would give balance_factor=0.5 or inertia_kg_mm2=2900; may be repeated")
    add_json(parser)
    add_units(parser)


def run(arguments: argparse.Namespace) -> int:
    """Build a crank and write it; 0 unless the description is bad."""
    from autobalance.api.generate import generate
    from autobalance.command.console import say
    from autobalance.command.progress import shown
    from autobalance.report.files import Staging

    report_file = None if arguments.json in (None, "-") else Path(arguments.json)
    folders = [] if arguments.output is None else [Path(arguments.output).parent]
    folders += [] if report_file is None else [report_file.parent]
    with Staging(folders) as staging, shown() as progress:
        result = generate(
            arguments.crank,
            file=arguments.output,
            unit=arguments.unit,
            segments=arguments.segments,
            settings=dict(_setting(text) for text in arguments.settings),
            suggest=suggest_of(arguments.suggest),
            progress=progress,
        )
        targets = [result.file] if report_file is None else [result.file, report_file]
        _refuse_overwriting(targets, Path(arguments.crank))
        staging.add(result.file, result.data)
        if report_file is not None:
            staging.add(report_file, result.json().encode())
        staging.commit()
    say(result.json().removesuffix("\n") if arguments.json == "-" else result.text(arguments.units))
    return 0


def _refuse_overwriting(targets: list[Path], source: Path) -> None:
    places = [path.resolve() for path in (*targets, source)]
    if len(set(places)) < len(places):
        raise UsageError("the description, the crank and the report must be files of different names")


def _setting(text: str) -> tuple[str, Any]:
    """Read ``key=value``, the value as TOML or, where it is none, as text."""
    key, equals, value = text.partition("=")
    if not (key.strip() and equals):
        raise UsageError(f"--set {text!r} is no KEY=VALUE")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):  # TOMLDecodeError is a ValueError
        return key.strip(), value.strip()
