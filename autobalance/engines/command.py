"""Command lines of the verbs of an engine."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from autobalance.command.options import add_json, add_plots, add_series, add_units, body_of, numbers
from autobalance.command.verb import NOT_TYPED, Keywords, Option, Verb
from autobalance.errors import UsageError
from autobalance.solid.formats.table import endings

if TYPE_CHECKING:
    from autobalance.engines.bearings.verb import BearingResult


# ``autobalance forces JOB.toml|CRANK``: orders, bearing loads and balance factors of the job's engine.


FORCES = Verb(
    "engines.forces.verb:forces",
    examples=(
        "autobalance forces job.toml",
        "autobalance forces job.toml --speed-rpm 9000 --factors 0,0.5,1 --plots plots",
    ),
    options={
        "job": Option(metavar="JOB.toml|CRANK", endings=endings),
        "factors": Option(metavar="F,F,...", read=numbers),
        "transverse_weight": Option(metavar="W"),
    },
    writes=(add_json, add_plots),
    of_crank=True,
)


# ``autobalance factor JOB.toml|CRANK``: the balance factor of a crank, and others to choose from.


FACTOR = Verb(
    "engines.factor:factor",
    examples=(
        "autobalance factor job.toml",
        "autobalance factor crank.stl --unit mm --material steel --rotating-g 134.04 --reciprocating-g 261.5",
        "autobalance factor job.toml --factors 0.28,0.6",
    ),
    options={
        "job": Option(metavar="JOB.toml|CRANK", endings=endings),
        "factors": Option(metavar="F,F,...", read=numbers, usual="none"),
    },
    writes=(add_json, add_units),
    of_crank=True,
)


# ``autobalance cycle JOB.toml``: gas pressure, loads, torque and speed over the working cycle.


MOST_SPEEDS = 1000


def speeds_of_sweep(option: str, text: str) -> list[float]:
    """Return the speeds of ``LOW,HIGH,N``."""
    low_high_count = numbers(option, text)
    if (
        len(low_high_count) != 3
        or not 0.0 < low_high_count[0] < low_high_count[1]
        or low_high_count[2] not in range(2, MOST_SPEEDS + 1)
    ):
        raise UsageError(
            f"{option} is {text!r}; must be a low speed, a higher one and how many (2 to {MOST_SPEEDS})"
        )
    low, high, count = low_high_count[0], low_high_count[1], int(low_high_count[2])
    return [low + (high - low) * place / (count - 1) for place in range(count)]


CYCLE = Verb(
    "engines.cycle.verb:cycle",
    examples=(
        "autobalance cycle job.toml --series cycle.csv",
        "autobalance cycle job.toml --sweep 2000,12000,11 --plots plots",
    ),
    options={
        "job": Option(metavar="JOB.toml"),
        "factors": Option(metavar="F,F,..."),
        "sweep_rpm": Option(("--sweep",), metavar="LOW,HIGH,N", read=speeds_of_sweep),
    },
    writes=(add_series("everything by angle, every half degree"), add_json, add_plots),
    series=lambda result: result.series_csv(),
)


# ``autobalance shafts JOB.toml``: shafts that would cancel orders 1 and 2, and what the job's own leave.


SHAFTS = Verb(
    "engines.shafts.verb:shafts",
    examples=("autobalance shafts job.toml --speed-rpm 9000",),
    options={"job": Option(metavar="JOB.toml")},
    writes=(add_json, add_units, add_plots),
)


# ``autobalance parts JOB.toml``: the weights of a job rolled up, and its bob-weights.


PARTS = Verb(
    "engines.parts:parts",
    examples=("autobalance parts job.toml --set balance.factor=0.5",),
    options={"job": Option(metavar="JOB.toml")},
    writes=(add_json, add_units, add_plots),
)


# ``autobalance rod FILE``: a connecting rod's solid, measured.


def _adjust(keywords: Keywords, _: argparse.Namespace) -> None:
    """Refuse half a question; take millimetres where neither file nor option has a unit."""
    from autobalance.command.options import unit_or_mm
    from autobalance.solid.formats.registry import names_bodies

    path = Path(keywords["file"])
    if (keywords["stroke_mm"] is None) != (keywords["speed_rpm"] is None):
        raise UsageError("--stroke-mm and --speed-rpm go together")
    keywords["unit"] = unit_or_mm(keywords["unit"], path)
    keywords["body"] = body_of(keywords["body"], names_bodies(path))


ROD = Verb(
    "engines.rod:rod",
    examples=(
        "autobalance rod rod.stl --unit mm --density-kg-m3 7850",
        "autobalance rod engine.step --body rod --stroke-mm 53.8 --speed-rpm 12000",
        'In a job, [engine.rod] file = "rod.stl" puts the same rod in.',
    ),
    options={
        "file": Option(metavar="FILE", endings=endings),
        "body": Option(metavar="N", usual="the only one"),
    },
    writes=(add_json, add_units),
    adjust=_adjust,
)


# ``autobalance bearing BEARING.toml``: friction, film, stiffness and damping; the film through a cycle.


def _orbit(result: BearingResult) -> bytes:
    series = result.series()
    if series is None:
        raise UsageError("--series needs a [history] of loads: without one there is no orbit")
    return series


BEARING = Verb(
    "engines.bearings.verb:bearing",
    examples=("autobalance bearing bearing.toml --series orbit.csv",),
    options={"bearing": Option(metavar="BEARING.toml"), "history": NOT_TYPED},
    writes=(add_series("the journal's orbit by angle, with [history]"), add_json, add_plots),
    series=_orbit,
)
