"""Options for files and units of results, which public functions do not have."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from autobalance.report.output_kinds import KINDS, choices

if TYPE_CHECKING:
    from autobalance.report.material import Choice

Adder = Callable[[argparse.ArgumentParser], None]


def add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--json",
        metavar="FILE",
        help="file for the report as JSON; - prints it and nothing else (default: not written)",
    )


def add_units(parser: argparse.ArgumentParser) -> None:
    """Offer ``--units``; ``main`` fills in those of the shop by default."""
    parser.add_argument(
        "--units",
        choices=("metric", "inch"),
        help="units of the printed summary; inch is in, oz and oz·in; files stay metric "
        "(default: units of the shop, else metric)",
    )


def add_shop_units(parser: argparse.ArgumentParser) -> None:
    """Offer ``--units`` where a shop may say in which it works."""
    parser.add_argument(
        "--units",
        choices=("metric", "inch"),
        help="units of summary, page, sheet and pictures; inch is in, oz and oz·in; "
        "report.json and solids stay metric (default: units of the shop, else metric)",
    )


def add_verbose(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-v", "--verbose", action="store_true", help="print all lines of the result")


def add_open(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--open", action="store_true", help="open the page in the browser (default: print its path)"
    )


def add_strict(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--strict",
        action="store_true",
        help="exit code 4 also if the verdict is not proven: residual and uncertainty together exceed the "
        "permissible unbalance, or other cylinders may be the main journals "
        "(default: only the residual decides)",
    )


def add_output(what: str, usual: str = "not written") -> Adder:
    """Return an adder of ``-o DIR``; ``what`` names the files that are written there."""

    def add(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("-o", "--output", metavar="DIR", help=f"folder for {what} (default: {usual})")

    return add


def add_series(what: str) -> Adder:
    """Return an adder of ``--series FILE.csv``; ``what`` names its rows."""

    def add(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("--series", metavar="FILE.csv", help=f"file for {what} (default: not written)")

    return add


def add_plots(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--plots", metavar="DIR", help="folder for plots, each as SVG and PNG (default: not written)"
    )


def add_pages(parser: argparse.ArgumentParser) -> None:
    """Offer ``--only``, ``--no-report`` and ``--paper``, which choose the files for people."""
    left_out = [name for name, kind in KINDS.items() if not kind.is_usual]
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        "--only",
        metavar="LIST",
        type=kinds_of,
        help=f"kinds of file to write in addition to the solid and report.json, with commas: "
        f"{', '.join(choices())} (default: all except {', '.join(left_out)})",
    )
    which.add_argument(
        "--no-report",
        action="store_true",
        help="write the solid and report.json only: no page, sheet or picture",
    )
    parser.add_argument(
        "--paper", choices=("A4", "Letter"), default="A4", help="paper of sheet.pdf (default: A4)"
    )
    add_zero(parser)


def add_zero(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--zero",
        choices=("keyway", "crankpin"),
        default="keyway",
        help="zero of the angles on the sheet (default: the keyway, or crankpin 1 without a keyway)",
    )


def kinds_of(text: str) -> tuple[str, ...]:
    """Return the kinds of output that a list with commas names."""
    kinds = tuple(word.strip() for word in text.split(",") if word.strip())
    for kind in kinds:
        if kind not in choices():
            raise argparse.ArgumentTypeError(f"{kind!r} is not one of {', '.join(choices())}")
    if not kinds:
        raise argparse.ArgumentTypeError(f"name at least one of {', '.join(choices())}")
    return kinds


def chosen_pages(arguments: argparse.Namespace) -> Choice:
    """Return the kinds of files that the arguments ask for."""
    from autobalance.report.bundle import choice_of

    only = () if arguments.no_report else arguments.only
    return choice_of(only, arguments.paper, arguments.units, zero=arguments.zero)
