"""``autobalance verify REPORT.json``: read the corrected solid again and check every number claimed of it."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_units


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("report", metavar="REPORT.json", help="what `balance` wrote, beside its solid")
    parser.add_argument(
        "--independent", action="store_true", help="measure the solid a second way too, from its slices"
    )
    add_json(parser)
    add_units(parser)


def run(arguments: argparse.Namespace) -> int:
    """Check a report; 0 within tolerance, 4 above it; a claim that fails is an error (3)."""
    from autobalance.api.verify import verify
    from autobalance.command.finish import finish

    result = verify(arguments.report, independent=arguments.independent)
    return finish(arguments, result, sources=(arguments.report,))
