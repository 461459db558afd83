"""``autobalance grade``: what a balance quality grade permits, what a residual achieves, and the list."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots, add_units
from autobalance.command.readers import mass_unit, unbalance_unit
from autobalance.command.verb import Option, Verb
from autobalance.units import G_MM_PER, G_PER

VERB = Verb(
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
