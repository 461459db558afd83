"""``autobalance study JOB.toml|REPORT.json|CRANK``: Monte Carlo tolerance study, and its yield."""

from __future__ import annotations

from autobalance.command.options import add_json, add_open, add_output, add_plots, add_series, add_units
from autobalance.command.verb import Option, Verb
from autobalance.solid.formats.table import endings

VERB = Verb(
    "studies.study.verb:study",
    examples=(
        "autobalance study job.toml --target 0.95",
        "autobalance study job-balanced/report.json --samples 100000 --workers 4",
    ),
    options={
        "job": Option(metavar="JOB.toml|REPORT.json|CRANK", endings=endings),
        "seed": Option(metavar="S"),
        "target": Option(metavar="P"),
    },
    writes=(
        add_output("page, report and cranks", "the page in NAME-study beside the job"),
        add_series("the cranks, one row each"),
        add_json,
        add_plots,
        add_units,
        add_open,
    ),
    series=lambda result: result.series,
    of_crank=True,
)
