"""``autobalance rotor ROTOR.toml|CRANK``: a shaft on bearings, its critical speeds, modes and response."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "rotor", metavar="ROTOR.toml|CRANK", help="shaft, discs, bearings, unbalances; or a crank's solid"
    )
    parser.add_argument("--unit", help="of a crank's file: mm, cm, m or inch, where its format carries none")
    parser.add_argument("--density-kg-m3", type=float, metavar="D", help="density of a crank (7850)")
    parser.add_argument("--speed-rpm", type=float, metavar="N", help="speed of a crank (3000)")
    parser.add_argument(
        "--bearing", type=float, metavar="K", help="stiffness of a crank's mains [N/m]; 0: none (pinned)"
    )
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compute; 0 unless the file is bad."""
    from autobalance.api.rotor import rotor
    from autobalance.command.finish import finish

    result = rotor(
        arguments.rotor,
        unit=arguments.unit,
        density_kg_m3=arguments.density_kg_m3,
        speed_rpm=arguments.speed_rpm,
        bearing_n_m=arguments.bearing,
    )
    return finish(arguments, result, sources=(arguments.rotor,))
