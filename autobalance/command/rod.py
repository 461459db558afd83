"""``autobalance rod FILE``: a connecting rod's solid, measured."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_units, body_of, length_unit
from autobalance.errors import UsageError

STEEL_KG_M3 = 7850.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = (
        "examples:\n"
        "  autobalance rod rod.stl --unit mm --density-kg-m3 7850\n"
        "  autobalance rod engine.step --body rod --stroke-mm 53.8 --speed-rpm 12000\n"
        'In a job, [engine.rod] file = "rod.stl" puts the same rod in.'
    )
    parser.add_argument(
        "file", metavar="FILE", help="the rod: .stl .obj .ply .off .3mf .glb .step .iges .brep"
    )
    parser.add_argument(
        "--unit",
        type=length_unit,
        choices=("mm", "cm", "m", "inch"),
        help="the file's unit, where its format carries none (mm)",
    )
    parser.add_argument(
        "--density-kg-m3", type=float, default=STEEL_KG_M3, metavar="RHO", help="(7850, steel)"
    )
    parser.add_argument(
        "--density-pm-kg-m3", type=float, default=0.0, metavar="RHO", help="by how much that may be off (0)"
    )
    parser.add_argument("--body", metavar="N", help="which body of several, or its name; or all")
    parser.add_argument("--stroke-mm", type=float, metavar="S", help="stroke, and with it")
    parser.add_argument("--speed-rpm", type=float, metavar="N", help="the speed: the greatest couple missed")
    add_json(parser)
    add_units(parser)


def run(arguments: argparse.Namespace) -> int:
    """Measure a rod; 0 unless the file is bad."""
    from autobalance.api.rod import rod
    from autobalance.command.console import warn
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown
    from autobalance.solid.formats.registry import names_bodies, needs_unit

    path, unit = Path(arguments.file), arguments.unit
    if (arguments.stroke_mm is None) != (arguments.speed_rpm is None):
        raise UsageError("--stroke-mm and --speed-rpm go together")
    if unit is None and needs_unit(path) and path.is_file():
        warn(f"{path.suffix.upper()[1:]} carries no unit: taken as mm; --unit says otherwise")
        unit = "mm"
    with shown() as progress:
        result = rod(
            path,
            unit,
            arguments.density_kg_m3,
            density_pm_kg_m3=arguments.density_pm_kg_m3,
            body=body_of(arguments.body, names_bodies(path)),
            stroke_mm=arguments.stroke_mm,
            speed_rpm=arguments.speed_rpm,
            progress=progress,
        )
    return finish(arguments, result, sources=(path,))
