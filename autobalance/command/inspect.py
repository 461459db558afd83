"""``autobalance inspect CRANK``: measure a crank file and say what was recognised in it."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from autobalance.command.options import (
    add_json,
    add_set,
    add_suggest,
    add_units,
    body_of,
    length_unit,
    suggest_of,
)
from autobalance.command.progress import add_progress, mode_of, shown
from autobalance.errors import JobError, UsageError

if TYPE_CHECKING:
    from autobalance.api.inspect import InspectResult
    from autobalance.api.inspect_sections import TableOptions
    from autobalance.runtime import Progress

STEEL_KG_M3 = 7850.0
CRANKPIN_IN_FILE = {"yes": True, "no": False, None: None}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "crank",
        metavar="CRANK|JOB",
        help="a crank file: .stl .obj .ply .off .3mf .glb .step .iges .brep; or a job",
    )
    parser.add_argument(
        "--unit",
        type=length_unit,
        choices=("mm", "cm", "m", "inch"),
        help="the file's unit, where its format carries none (mm)",
    )
    parser.add_argument(
        "--density-kg-m3", type=float, metavar="RHO", help="default: 7850, steel; a job says its own"
    )
    parser.add_argument("--body", metavar="N", help="which body of several, or its name; or all")
    parser.add_argument(
        "--no-crankpin",
        dest="crankpin_in_file",
        action="store_const",
        const="no",
        help="a pressed-up crank modelled without its crankpins; as --crankpin-in-file no",
    )
    parser.add_argument(
        "--crankpin-in-file",
        dest="crankpin_in_file",
        choices=("yes", "no"),
        help="whether the file holds the crankpins; default: both are tried",
    )
    # argparse takes -3e-7 for an option otherwise, before Python 3.14
    parser._negative_number_matcher = re.compile(r"^-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")
    for option, what in (
        ("--axis-point", "a point of the crank axis"),
        ("--axis-direction", "its direction"),
    ):
        parser.add_argument(
            option,
            nargs=3,
            type=float,
            metavar=("X", "Y", "Z"),
            help=f"{what}, in the file's coordinates in mm, where it is not found or found wrong",
        )
    parser.add_argument(
        "--sections",
        action="store_true",
        help="also print mass, centre and moments of each part; of a job with all that hangs on the crank",
    )
    parser.add_argument(
        "--datum",
        metavar="Z",
        help="with --sections: couples about this z [mm], or A, B, front, rear, centre (0: crankpin 1)",
    )
    parser.add_argument(
        "--oil-density-kg-m3", type=float, metavar="RHO", help="with --sections: oil in the crankpins' bores"
    )
    parser.add_argument(
        "--picture", metavar="FILE.png", help="draw the crank with its axis, pins, and faces by their ids"
    )
    add_suggest(
        parser,
        "say what would give inertia_kg_mm2=2900, or a job's balance_factor=0.5; alone: the job's factor",
    )
    add_set(parser)
    add_json(parser)
    add_units(parser)
    add_progress(parser)


def run(arguments: argparse.Namespace) -> int:
    """Measure a crank; 0 unless the file is bad."""
    from autobalance.command.console import say, warn
    from autobalance.report.files import Staging

    target = _target(arguments, "--json", arguments.json)
    drawing = _target(arguments, "--picture", arguments.picture)
    with Staging([path.parent for path in (target, drawing) if path is not None]) as staging:
        with shown(mode_of(arguments)) as progress:
            result = _inspected(arguments, progress)
            if drawing is not None:
                progress("drawing the crank", 0.85)
                staging.add(drawing, result.picture())
        for text in result.warnings:
            warn(text)
        if target is not None:
            staging.add(target, result.json().encode())
        staging.commit()
    if arguments.json == "-":
        say(result.json().removesuffix("\n"))
        return 0
    say(result.text(arguments.units))
    if arguments.sections:
        say("\n" + result.sections_text())
    return 0


def _target(arguments: argparse.Namespace, option: str, text: str | None) -> Path | None:
    """Return where an option's file goes, which must not be the crank's own."""
    if text is None or text == "-":
        return None
    target = Path(text)
    if target.resolve() == Path(arguments.crank).resolve():
        raise UsageError(f"{option} {target} would overwrite the crank file")
    return target


def _inspected(arguments: argparse.Namespace, progress: Progress) -> InspectResult:
    from autobalance.api.inspect import inspect
    from autobalance.job.read import WORKBOOKS

    path, suggest = Path(arguments.crank), suggest_of(arguments.suggest)
    table = _table(arguments)
    if path.suffix.lower() not in (".toml", *WORKBOOKS):
        if arguments.settings:
            raise UsageError("--set goes with a job; a crank file has no keys")
        if arguments.datum is None and arguments.oil_density_kg_m3 is None:
            table = None  # the crank's own sections are enough
        return inspect(path, progress=progress, suggest=suggest, table=table, **_keywords(arguments))
    given = {
        "--unit": arguments.unit,
        "--density-kg-m3": arguments.density_kg_m3,
        "--body": arguments.body,
        "--axis-point": arguments.axis_point,
        "--axis-direction": arguments.axis_direction,
    }
    for option, value in given.items():
        if value is not None:
            raise UsageError(f"{option} beside a job: it says its own; --set crankshaft.... changes it")
    return inspect(path, progress=progress, settings=arguments.settings, suggest=suggest, table=table)


def _table(arguments: argparse.Namespace) -> TableOptions | None:
    """Return how the section table is to be; None where none is asked for."""
    from autobalance.api.inspect_sections import DATUMS, TableOptions
    from autobalance.job.toml.typed_units import length_mm

    datum, oil = arguments.datum, arguments.oil_density_kg_m3
    if not arguments.sections:
        if datum is not None or oil is not None:
            raise UsageError("--datum and --oil-density-kg-m3 go with --sections")
        return None
    if datum is None or datum in DATUMS:
        return TableOptions(0.0 if datum is None else datum, oil)
    try:
        return TableOptions(float(datum), oil)
    except ValueError:
        pass
    try:
        return TableOptions(length_mm(datum, "--datum"), oil)
    except JobError as error:
        raise UsageError(f"{error}; or one of {', '.join(DATUMS)}") from None


def _keywords(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the options as ``read_crank`` takes them."""
    from autobalance.command.console import warn
    from autobalance.solid.formats.registry import names_bodies, needs_unit

    path, unit = Path(arguments.crank), arguments.unit
    density = STEEL_KG_M3 if arguments.density_kg_m3 is None else arguments.density_kg_m3
    if not 0.0 < density < float("inf"):
        raise UsageError(f"--density-kg-m3 is {density:g}; must be > 0")
    if unit is None and needs_unit(path) and path.is_file():
        warn(f"{path.suffix.upper()[1:]} carries no unit: taken as mm; --unit says otherwise")
        unit = "mm"
    return {
        "unit": unit,
        "density_kg_m3": density,
        "crankpin_in_file": CRANKPIN_IN_FILE[arguments.crankpin_in_file],
        "body": body_of(arguments.body, names_bodies(path)),
        "axis_point_mm": arguments.axis_point,
        "axis_direction": arguments.axis_direction,
    }
