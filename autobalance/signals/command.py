"""``autobalance orders RECORD [RECORD_B]``: spectrum, orders and sources of a recorded signal."""

from __future__ import annotations

import argparse

from autobalance.command.options import add_json, add_output, add_plots, factors_by_name
from autobalance.command.verb import Keywords, Option, Verb
from autobalance.errors import UsageError


def _check(keywords: Keywords, _: argparse.Namespace) -> None:
    """Refuse options that do not go together."""
    if keywords["speed_rpm"] is not None and keywords["tacho"] is not None:
        raise UsageError("--speed-rpm and --tacho are both given; expected one of them")
    if keywords["settings"] and keywords["job"] is None:
        raise UsageError("--set goes with --job; a record has no keys")
    if keywords["excitation"] is not None and not keywords["natural"]:
        raise UsageError("--excitation is given without --natural")
    if keywords["threshold"] is not None and keywords["tacho"] is None:
        raise UsageError("--threshold is given without --tacho")
    if keywords["pulses_per_rev"] != 1 and keywords["tacho"] is None:
        raise UsageError("--pulses-per-rev is given without --tacho")


VERB = Verb(
    "signals.verb:orders",
    examples=(
        "autobalance orders run.csv --tacho tacho --channel accel",
        "autobalance orders before.csv after.csv --speed-rpm 3000",
        "autobalance orders run-up.wav --sample-rate 8000 --natural --plots plots",
    ),
    options={
        "other": Option(metavar="RECORD_B", positional=True),
        "sample_rate": Option(metavar="HZ"),
        "calibration": Option(metavar="NAME=FACTOR", read=factors_by_name, repeated=True),
        "threshold": Option(metavar="LEVEL"),
        "frequencies": Option(metavar="HZ,HZ,..."),
        "bearing": Option(metavar="KEY=NUMBER,..."),
        "band": Option(metavar="LOW,HIGH"),
        "axes": Option(metavar="X,Y"),
        "job": Option(metavar="JOB.toml"),
        "drive": Option(metavar="DRIVE.toml"),
        "campbell": Option(metavar="REPORT.json"),
    },
    writes=(add_output("the report and a page to zoom into"), add_json, add_plots),
    adjust=_check,
)
