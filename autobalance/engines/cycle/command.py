"""``autobalance cycle JOB.toml``: gas pressure, loads, torque and speed over the working cycle."""

from __future__ import annotations

from autobalance.command.options import add_json, add_plots, add_series
from autobalance.command.readers import numbers
from autobalance.command.verb import Option, Verb
from autobalance.errors import UsageError

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


VERB = Verb(
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
