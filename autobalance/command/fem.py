"""``autobalance fem SOLID|FEM.toml``: free modes and static stress by quadratic tetrahedra."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_plots


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("solid", metavar="SOLID|FEM.toml", help="a solid, free in space; or an analysis")
    parser.add_argument("--unit", help="mm, cm, m or inch; needed where the format carries none")
    parser.add_argument("--density-kg-m3", type=float, metavar="D", help="density (7850)")
    parser.add_argument("--e-gpa", type=float, metavar="E", help="modulus of elasticity (210)")
    parser.add_argument("--nu", type=float, metavar="NU", help="Poisson's ratio (0.3)")
    parser.add_argument("--modes", type=int, metavar="N", help="how many modes (6)")
    parser.add_argument("--size-mm", type=float, metavar="S", help="greatest edge of the last mesh")
    parser.add_argument(
        "--no-crankpin", action="store_true", help="a pressed-up crank without its crankpins: they are put in"
    )
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Analyse; 0 unless something is wrong with the solid or the analysis."""
    from autobalance.api.fem import fem
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown

    with shown() as progress:
        result = fem(
            arguments.solid,
            unit=arguments.unit,
            density_kg_m3=arguments.density_kg_m3,
            e_gpa=arguments.e_gpa,
            nu=arguments.nu,
            modes=arguments.modes,
            size_mm=arguments.size_mm,
            crankpin_in_file=False if arguments.no_crankpin else None,
            progress=progress,
        )
    return finish(arguments, result, sources=(arguments.solid,))
