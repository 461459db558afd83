"""``autobalance study JOB.toml|REPORT.json``: many cranks to one plan, and how many are within."""

from __future__ import annotations

import argparse
from pathlib import Path

from autobalance.command.options import add_json, add_plots, add_set, add_workers, workers_given


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.add_argument("job", metavar="JOB.toml|REPORT.json", help="a job, or the report of a balanced one")
    parser.add_argument("--samples", type=int, default=10_000, metavar="N", help="cranks (10000)")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="which cranks (1)")
    parser.add_argument("--target", type=float, metavar="P", help="share to be within, else exit code 4")
    parser.add_argument("--exact", type=int, default=10, metavar="K", help="cranks cut and measured too (10)")
    parser.add_argument("--series", metavar="FILE.csv", help="write the cranks, one row each")
    add_set(parser)
    add_workers(parser)
    add_json(parser)
    add_plots(parser)


def run(arguments: argparse.Namespace) -> int:
    """Study; 4 where the target is not reached or the plan is above tolerance."""
    from autobalance.api.study import study
    from autobalance.command.finish import finish
    from autobalance.command.progress import shown

    with shown() as progress:
        result = study(
            arguments.job,
            settings=arguments.settings,
            samples=arguments.samples,
            seed=arguments.seed,
            target=arguments.target,
            exact=arguments.exact,
            progress=progress,
            **workers_given(arguments),
        )
    files = {Path(arguments.series): result.series} if arguments.series else {}
    return finish(arguments, result, sources=(arguments.job,), files=files)
