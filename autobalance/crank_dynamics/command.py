"""Command lines of the verbs of a crank that bends, turns and twists."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots
from autobalance.command.verb import Option, Verb
from autobalance.engines.command import speeds_of_sweep
from autobalance.solid.formats.table import endings

# ``autobalance rotor ROTOR.toml|CRANK``: a shaft on bearings, its critical speeds, modes and response.


ROTOR = Verb(
    "crank_dynamics.rotor.verb:rotor",
    examples=(
        "autobalance rotor rotor.toml --plots plots",
        "autobalance rotor crank.stl --unit mm --speed-rpm 12000 --bearing 1e8",
    ),
    options={
        "source": Option(metavar="ROTOR.toml|CRANK", endings=endings),
        "unit": Option(metavar="UNIT"),
        "bearing_n_m": Option(("--bearing",), metavar="N/M"),
    },
    writes=(add_json, add_plots),
)


# ``autobalance torsion FILE.toml``: torsional vibration of a job's crank, or of a separate chain.


TORSION = Verb(
    "crank_dynamics.torsion.verb:torsion",
    examples=("autobalance torsion job.toml --set torsion.flywheel_kg_mm2=900 --plots plots",),
    options={"source": Option(metavar="FILE.toml")},
    writes=(add_json, add_plots),
)


# ``autobalance strength JOB.toml|REPORT.json``: stress and safety of fillets over the cycle.


STRENGTH = Verb(
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
