"""``autobalance torsion FILE.toml``: torsional vibration of a job's crank, or of a separate chain."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots
from autobalance.command.verb import Option, Verb

VERB = Verb(
    "crank_dynamics.torsion.verb:torsion",
    examples=("autobalance torsion job.toml --set torsion.flywheel_kg_mm2=900 --plots plots",),
    options={"source": Option(metavar="FILE.toml")},
    writes=(add_json, add_plots),
)
