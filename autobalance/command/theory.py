"""What ``forces``, ``shafts`` and ``parts`` share: reading, the options, the files that they write."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from autobalance import __version__
from autobalance import job as jobs
from autobalance.balancing import measured_crank, rotor_from_job
from autobalance.balancing.measured_crank import Crank
from autobalance.command.console import progress, progress_done, say
from autobalance.errors import UsageError
from autobalance.job import Job
from autobalance.report.files import Staging
from autobalance.report.json import SCHEMA_VERSION, dumps
from autobalance.runtime import Stopwatch
from autobalance.units import RAD_S_PER_RPM

Values = dict[str, Any]
Plots = Mapping[str, Mapping[str, bytes]]


@dataclass(frozen=True, eq=False)
class Request:
    """A job with its crank, the target factor and the speed."""

    job: Job
    crank: Crank
    factor: float
    speed_rad_s: float
    speed_rpm: float


def read_request(arguments: argparse.Namespace) -> Request:
    """Read the job and measure its crank."""
    job = jobs.load(arguments.job)
    speed = job.balance.service_speed_rad_s
    rpm = jobs.describe(job)["balance"]["speed_rpm"]
    if arguments.speed_rpm is not None:
        if not 0.0 < arguments.speed_rpm < float("inf"):
            raise UsageError(f"--speed-rpm is {arguments.speed_rpm:g}; must be > 0")
        rpm, speed = arguments.speed_rpm, arguments.speed_rpm * RAD_S_PER_RPM
    progress("reading the crank")
    try:
        crank = measured_crank.measure_crank(job.crankshaft, Stopwatch())
    finally:
        progress_done()
    rotor_from_job.check_engine(job, crank.anatomy)
    factor = rotor_from_job.target_factor(job, crank.anatomy, crank.moments)
    return Request(job, crank, factor, speed, float(rpm))


def report_head(command: str, job: Job | None = None) -> Values:
    """Return the first keys of a command's JSON."""
    return {
        "schema_version": SCHEMA_VERSION,
        "autobalance": {"version": __version__},
        "command": command,
        "job": None if job is None else jobs.describe(job),
    }


def write_and_print(
    arguments: argparse.Namespace, values: Values, text: Callable[[], str], plots: Plots | None = None
) -> int:
    """Write the JSON and the plots that were asked for, all or none, and print the rest."""
    target = None if arguments.json in (None, "-") else Path(arguments.json)
    job = getattr(arguments, "job", None)
    if target is not None and job is not None and target.resolve() == Path(job).resolve():
        raise UsageError(f"--json {target} would overwrite the job")
    folder = Path(arguments.plots) if plots else None
    folders = ([] if target is None else [target.parent]) + ([] if folder is None else [folder])
    files: dict[Path, bytes] = {}
    if folder is not None and plots is not None:
        files = {folder / f"{name}.{end}": data for name, by in plots.items() for end, data in by.items()}
    if target is not None:
        files[target] = dumps(values).encode()
    with Staging(folders) as staging:
        for path, data in files.items():
            staging.add(path, data)
        staging.commit()
    if arguments.json == "-":
        say(dumps(values).removesuffix("\n"))
    else:
        say(text() + ("\n\nWritten: " + ", ".join(str(path) for path in files) if files else ""))
    return 0
