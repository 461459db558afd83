"""``autobalance fem SOLID|FEM.toml``: free modes and static stress by quadratic tetrahedra."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots
from autobalance.command.verb import NOT_TYPED, Option, Verb
from autobalance.solid.formats.table import endings

VERB = Verb(
    "finite_elements.verb:fem",
    examples=(
        "autobalance fem crank.stl --unit mm --modes 4",
        "autobalance fem fem.toml --plots plots",
    ),
    options={
        "solid": Option(metavar="SOLID|FEM.toml", endings=endings),
        "unit": Option(metavar="UNIT"),
        "body": NOT_TYPED,
        "nu": Option(metavar="NU"),
        "crankpin_in_file": Option(("--no-crankpin",), value=False),
    },
    writes=(add_json, add_plots),
)
