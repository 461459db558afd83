"""``autobalance init CRANK``: a commented job for a crank, or a job in its other form."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_set, length_unit
from autobalance.errors import FileError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = (
        "examples:\n"
        "  autobalance init crank.stl --unit mm                 a job beside you, crank.toml\n"
        "  autobalance init crank.stl --unit mm -o crank.xlsx   the same as a workbook\n"
        "  autobalance init crank.toml -o crank.xlsx            a job in the other form, and back\n"
        "  autobalance init halves.stl --unit mm --set crankshaft.crankpin_in_file=false"
    )
    parser.add_argument("crank", metavar="CRANK|JOB", help="a crank file, or a job (.toml, .xlsx) to convert")
    parser.add_argument("-o", "--output", metavar="FILE", help="the job: .toml or .xlsx (NAME.toml here)")
    parser.add_argument(
        "--unit",
        type=length_unit,
        choices=("mm", "cm", "m", "inch"),
        help="the file's unit, where its format carries none",
    )
    parser.add_argument("--density-kg-m3", type=float, metavar="N", help="its density (left to fill in)")
    parser.add_argument("--method", default="drill", metavar="M", help="kind of correction (drill)")
    parser.add_argument("--force", action="store_true", help="write over an existing file")
    add_set(parser)


def run(arguments: argparse.Namespace) -> int:
    """Write a job; 0 unless the crank is bad."""
    from autobalance.api.init import init
    from autobalance.command.console import say
    from autobalance.command.progress import shown
    from autobalance.report.files import Staging

    with shown() as progress:
        result = init(
            arguments.crank,
            file=arguments.output,
            unit=arguments.unit,
            density_kg_m3=arguments.density_kg_m3,
            method=arguments.method,
            settings=arguments.settings,
            progress=progress,
        )
    if result.file.exists() and not arguments.force:
        raise FileError(f"{result.file} exists; --force writes over it, -o FILE another")
    with Staging([result.file.parent]) as staging:
        staging.add(result.file, result.data)
        staging.commit()
    say(result.text())
    return 0
