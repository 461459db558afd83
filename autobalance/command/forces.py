"""``autobalance forces JOB.toml``: orders, bearing loads and balance factors of the job's engine."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from autobalance.command.options import add_json, add_plots, add_reference, add_set, add_speed
from autobalance.errors import UsageError

if TYPE_CHECKING:
    pass

DEFAULT_FACTORS = (0.0, 0.25, 0.5, 0.75, 1.0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("job", metavar="JOB.toml", help="the job; engine.rod_length_mm is needed here")
    add_speed(parser)
    parser.add_argument(
        "--factors", metavar="F,F,...", help="balance factors to compare (default: 0, 0.25, 0.5, 0.75, 1)"
    )
    parser.add_argument(
        "--transverse-weight",
        type=float,
        default=1.0,
        metavar="W",
        help="how badly the mount takes force across cylinder 1, over force along it (1)",
    )
    add_reference(parser)
    add_set(parser)
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compute the forces; 0 unless the job or the crank is bad."""
    from autobalance.api.forces import DEFAULT_FACTORS, forces
    from autobalance.api.job import read_job
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown

    given = _factors(arguments.factors)
    with shown() as progress:
        result = forces(
            read_job(arguments.job, arguments.settings),
            speed_rpm=arguments.speed_rpm,
            factors=DEFAULT_FACTORS if given is None else given,
            transverse_weight=arguments.transverse_weight,
            reference_z_mm=arguments.reference_z,
            progress=progress,
        )
    return finish(arguments, result, sources=(arguments.job,))


def _factors(text: str | None) -> tuple[float, ...] | None:
    if text is None:
        return None
    try:
        factors = tuple(float(word) for word in text.split(","))
    except ValueError:
        raise UsageError(f"--factors is {text!r}; must be numbers with commas between, 0,0.5,1 say") from None
    if not all(0.0 <= factor <= 1.0 for factor in factors):
        raise UsageError(f"--factors is {text!r}; each must be 0 to 1")
    return factors
