"""``autobalance grade``: what a balance quality grade permits, what a residual achieves, and the list."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots, add_units, mass_unit, unbalance_unit
from autobalance.units import G_MM_PER, G_PER


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "--grade", type=float, metavar="G", help="balance quality grade, 6.3 for G 6.3 [mm/s]"
    )
    parser.add_argument("--speed-rpm", type=float, metavar="N", help="highest service speed")
    parser.add_argument("--mass", type=float, metavar="M", help="rotor mass")
    parser.add_argument(
        "--mass-unit", type=mass_unit, choices=tuple(G_PER), default="g", help="unit of --mass (g)"
    )
    parser.add_argument(
        "--residual", type=float, metavar="U", help="residual unbalance, for the grade it achieves"
    )
    parser.add_argument(
        "--residual-unit",
        type=unbalance_unit,
        choices=tuple(G_MM_PER),
        default="g·mm",
        help="unit of --residual, also typed as oz-in, gmm, kg.mm (g·mm)",
    )
    parser.add_argument(
        "--planes",
        type=float,
        nargs=2,
        metavar=("ZA", "ZB"),
        help="tolerance planes to share it between [mm]",
    )
    parser.add_argument("--centre", type=float, metavar="Z", help="place of the centre of mass (midway) [mm]")
    add_json(parser)
    add_units(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print grades; 0 unless an option is wrong."""
    from autobalance.api.grade import grade
    from autobalance.command.finish import finish

    result = grade(
        arguments.grade,
        speed_rpm=arguments.speed_rpm,
        mass=arguments.mass,
        mass_unit=arguments.mass_unit,
        residual=arguments.residual,
        residual_unit=arguments.residual_unit,
        planes=arguments.planes,
        centre=arguments.centre,
    )
    return finish(arguments, result)
