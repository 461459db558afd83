"""``autobalance verify REPORT.json``: read the corrected solid again and check every number claimed of it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from autobalance.command.options import add_units

if TYPE_CHECKING:
    from autobalance.report.text import Units
    from autobalance.verification.claims import Checked

ABOVE_TOLERANCE = 4


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("report", metavar="REPORT.json", help="what `balance` wrote, beside its solid")
    parser.add_argument(
        "--independent", action="store_true", help="measure the solid a second way too, from its slices"
    )
    add_units(parser)


def run(arguments: argparse.Namespace) -> int:
    """Check a report; 0 within tolerance, 4 above it; a claim that fails is an error (3)."""
    from pathlib import Path

    from autobalance.command.console import say, warn
    from autobalance.report.text import UNITS
    from autobalance.verification.claims import check_report

    found = check_report(Path(arguments.report), arguments.independent)
    for text in found.warnings:
        warn(text)
    units = UNITS[arguments.units]
    verdict = "within" if found.within else "ABOVE"
    say(
        f"{arguments.report}: all {found.checked} claims hold; residual "
        f"{units.of_unbalance(found.residual.magnitude_g_mm)} of permitted "
        f"{units.of_unbalance(found.tolerance.permissible_g_mm)}{_doubt(found, units)}: {verdict} tolerance"
    )
    if found.agreement is not None:
        agree = f"volume, first and second moments agree to {found.agreement:.1e}"
        say(f"Measured a second way, from slices: {agree}")
    return 0 if found.within else ABOVE_TOLERANCE


def _doubt(found: Checked, units: Units) -> str:
    """Return how far the residual may be off, where that counts in the verdict."""
    if found.tolerance.margin == "none" or found.budget is None:
        return ""
    return f", and its uncertainty of {units.of_unbalance(found.budget.total_g_mm)} counts"
