"""``autobalance nc REPORT.json MACHINE.toml -o DIR``: NC programs of a report's cuts, simulated."""

from __future__ import annotations

import argparse

from autobalance.command.console import add_progress, mode_of
from autobalance.command.options import add_json, add_units
from autobalance.command.verb import Option, Verb


def add_folder(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        required=True,
        help="folder of the programs, nc.json and setup.pdf (required)",
    )


VERB = Verb(
    "machining.verb:nc",
    examples=("autobalance nc job-balanced/report.json machine.toml -o programs",),
    options={
        "report": Option(metavar="REPORT.json"),
        "machine": Option(metavar="MACHINE.toml"),
        "finish_mm": Option(metavar="MM", usual="the machine file's"),
    },
    writes=(add_folder, add_json, add_units, add_progress),
)


def run(arguments: argparse.Namespace) -> int:
    """Write the programs; 0, or 4 where cuts are left out or the simulated residual is above tolerance."""
    from autobalance.command.console import shown
    from autobalance.command.finish import finish, refuse_in_results
    from autobalance.machining.verb import nc

    with shown(mode_of(arguments)) as progress:
        result = nc(**VERB.keywords(arguments), progress=progress)
        refuse_in_results(arguments, ["nc.json", *result.files()])
    return finish(arguments, result, sources=(arguments.report, arguments.machine))
