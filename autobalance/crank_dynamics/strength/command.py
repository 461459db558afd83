"""``autobalance strength JOB.toml|REPORT.json``: stress and safety of fillets over the cycle."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots
from autobalance.command.verb import Option, Verb
from autobalance.engines.cycle.command import speeds_of_sweep

VERB = Verb(
    "crank_dynamics.strength.verb:strength",
    examples=(
        "autobalance strength job.toml --plots plots",
        "autobalance strength balanced/report.json",
    ),
    options={
        "source": Option(metavar="JOB.toml|REPORT.json"),
        "sweep_rpm": Option(("--sweep",), metavar="LOW,HIGH,N", read=speeds_of_sweep),
    },
    writes=(add_json, add_plots),
)
