"""``autobalance cycle JOB.toml``: gas pressure, loads, torque and speed over the working cycle."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_plots, add_set, add_speed
from autobalance.errors import UsageError

MOST_SPEEDS = 1000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument(
        "job", metavar="JOB.toml", help="the job; [cycle] and engine.rod_length_mm are needed"
    )
    add_speed(parser)
    parser.add_argument(
        "--factors", metavar="F,F,...", help="balance factors to compare (default: 0, 0.28, 0.5, 0.64, 1)"
    )
    parser.add_argument(
        "--sweep", metavar="LOW,HIGH,N", help="tell every factor at N speeds from LOW to HIGH rpm too"
    )
    parser.add_argument("--series", metavar="FILE.csv", help="write everything by angle, every half degree")
    add_set(parser)
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compute the cycle; 0 unless the job, its trace or the crank is bad."""
    from autobalance.api.cycle import cycle
    from autobalance.api.job import read_job
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown

    factors = None if arguments.factors is None else _numbers("--factors", arguments.factors)
    sweep = None if arguments.sweep is None else _speeds(arguments.sweep)
    with shown() as progress:
        result = cycle(
            read_job(arguments.job, arguments.settings),
            speed_rpm=arguments.speed_rpm,
            factors=factors,
            sweep_rpm=sweep,
            progress=progress,
        )
    files = {} if arguments.series is None else {Path(arguments.series): result.series_csv()}
    return finish(arguments, result, sources=(arguments.job,), files=files)


def _speeds(text: str) -> list[float]:
    """Return the speeds of ``--sweep``."""
    numbers = _numbers("--sweep", text)
    if len(numbers) != 3 or not 0.0 < numbers[0] < numbers[1] or numbers[2] not in range(2, MOST_SPEEDS + 1):
        raise UsageError(
            f"--sweep is {text!r}; must be a low speed, a higher one and how many (2 to {MOST_SPEEDS})"
        )
    low, high, count = numbers[0], numbers[1], int(numbers[2])
    return [low + (high - low) * place / (count - 1) for place in range(count)]


def _numbers(option: str, text: str) -> tuple[float, ...]:
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise UsageError(f"{option} is {text!r}; must be numbers with commas between, 0,0.5,1 say") from None
