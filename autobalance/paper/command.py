"""``autobalance sheet REPORT.json``: the shop sheet again, on other paper or in other units, and for CAD."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_output
from autobalance.command.verb import NOT_TYPED, Option, Verb

KINDS = ("pdf", "dxf")


def _kinds_of(text: str) -> tuple[str, ...]:
    kinds = tuple(word.strip() for word in text.split(",") if word.strip())
    if not kinds or not set(kinds) <= set(KINDS):
        raise argparse.ArgumentTypeError(f"{text!r}: name {' or '.join(KINDS)} or both")
    return kinds


VERB = Verb(
    "paper.verb:sheet",
    examples=("autobalance sheet job-balanced/report.json --paper Letter --units inch -o letter",),
    options={
        "report": Option(metavar="REPORT.json"),
        "only": Option(
            metavar="LIST", normal=_kinds_of, unset=True, usual="pdf, and dxf where its extra is installed"
        ),
        "date": NOT_TYPED,
    },
    writes=(add_output("the files", "the report's folder"),),
)


def run(arguments: argparse.Namespace) -> int:
    """Draw the cuts of a report; nothing is measured."""
    from importlib.util import find_spec

    from autobalance.command.console import say
    from autobalance.paper.verb import sheet

    keywords = VERB.keywords(arguments)
    keywords["only"] = keywords["only"] or (KINDS if find_spec("ezdxf") is not None else ("pdf",))
    result = sheet(**keywords)
    folder = Path(arguments.output) if arguments.output else Path(arguments.report).parent
    written = result.write(folder)
    say(f"{result.text()}\n\nWritten: {', '.join(map(str, written))}")
    return result.exit_code
