"""``autobalance sheet REPORT.json``: the shop sheet again, on other paper or in other units, and for CAD."""

from __future__ import annotations

import argparse
from pathlib import Path

KINDS = ("pdf", "dxf")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("report", metavar="REPORT.json", help="of `balance` or `recut`, its solid beside it")
    parser.add_argument(
        "-o", "--output", metavar="DIR", help="folder of the files (default: the report's folder)"
    )
    parser.add_argument(
        "--only",
        metavar="LIST",
        type=_kinds_of,
        help="pdf, dxf (default: pdf, and dxf where the extra of its name is installed)",
    )
    parser.add_argument("--paper", choices=("A4", "Letter"), default="A4", help="paper of sheet.pdf (A4)")
    parser.add_argument(
        "--units", choices=("metric", "inch"), default="metric", help="units of sheet.pdf (the DXF is in mm)"
    )


def _kinds_of(text: str) -> tuple[str, ...]:
    kinds = tuple(word.strip() for word in text.split(",") if word.strip())
    if not kinds or not set(kinds) <= set(KINDS):
        raise argparse.ArgumentTypeError(f"{text!r}: name {' or '.join(KINDS)} or both")
    return kinds


def run(arguments: argparse.Namespace) -> int:
    """Draw what a report lists; nothing is measured."""
    from importlib.util import find_spec

    from autobalance.api.sheet import sheet
    from autobalance.command.console import say

    usual = KINDS if find_spec("ezdxf") is not None else ("pdf",)
    result = sheet(
        arguments.report, only=arguments.only or usual, paper=arguments.paper, units=arguments.units
    )
    folder = Path(arguments.output) if arguments.output else Path(arguments.report).parent
    written = result.write(folder)
    say(f"{result.text()}\n\nWritten: {', '.join(map(str, written))}")
    return result.exit_code
