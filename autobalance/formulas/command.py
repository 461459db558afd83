"""Command lines of the formulas: ``calc`` and ``grade``."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots, add_units, mass_unit, unbalance_unit
from autobalance.command.verb import Option, Verb
from autobalance.errors import UsageError
from autobalance.units import G_MM_PER, G_PER

# ``autobalance calc NAME key=value ...``: the documented formulas, one by one.


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "examples:\n"
        "  autobalance calc --list\n"
        "  autobalance calc substitute_rotor --help\n"
        "  autobalance calc crankpin_overlap_mm main_journal_mm=28 crankpin_mm=28 stroke_mm=53.8"
    )
    parser.add_argument(
        "name", nargs="?", metavar="NAME", help="name of the formula; --list lists all (default: none)"
    )
    parser.add_argument(
        "values", nargs="*", metavar="key=value", help="values of the formula, the unit is in the key"
    )
    parser.add_argument("--list", action="store_true", help="list every formula")
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Calculate; 0 unless a value is wrong."""
    from autobalance.command.console import say
    from autobalance.command.finish import finish
    from autobalance.formulas.calc import calc, names, summary_of

    if arguments.list:
        width = max(len(name) for name in names())
        say("\n".join(f"{name:<{width}}  {summary_of(name)}" for name in names()))
        return 0
    if arguments.name is None:
        raise UsageError("calc needs the name of a formula; --list lists all")
    values = {}
    for text in arguments.values:
        key, equals, value = text.partition("=")
        if not equals:
            raise UsageError(f"{text!r} is not key=value")
        values[key.strip()] = value.strip()
    return finish(arguments, calc(arguments.name, values))


def help_for(words: list[str]) -> str | None:
    """Return the help of one formula where the command line asks for that: ``calc NAME --help``."""
    asks = any(word in ("-h", "--help") for word in words)
    name = next((word for word in words[1:] if not word.startswith("-") and "=" not in word), None)
    if not asks or name is None:
        return None
    from autobalance.formulas.calc import usage_of

    return usage_of(name)


# ``autobalance grade``: what a balance quality grade permits, what a residual achieves, and the list.


GRADE = Verb(
    "formulas.grade:grade",
    examples=(
        "autobalance grade",
        "autobalance grade --grade 6.3 --speed-rpm 15200 --mass 2.7 --mass-unit kg",
        "autobalance grade --residual 0.2 --residual-unit oz-in --mass 2700 --speed-rpm 15200",
    ),
    options={
        "grade": Option(metavar="G"),
        "mass": Option(metavar="M"),
        "mass_unit": Option(normal=mass_unit, choices=tuple(G_PER)),
        "residual": Option(metavar="U"),
        "residual_unit": Option(normal=unbalance_unit, choices=tuple(G_MM_PER)),
        "planes": Option(nargs=2, metavar=("ZA", "ZB")),
        "centre": Option(metavar="Z"),
    },
    writes=(add_json, add_units, add_plots),
)
