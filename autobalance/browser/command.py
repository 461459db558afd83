"""``autobalance app``: the whole program in a browser on this machine."""

from __future__ import annotations

import argparse

from autobalance.command.verb import NOT_TYPED, Option, Verb

VERB = Verb(
    "browser.serving:app",
    examples=(
        "autobalance app                      an empty project in ./autobalance-project",
        "autobalance app crank.stl            the same with a crank copied in",
        "autobalance app job.toml --no-browser --port 8123",
    ),
    options={
        "source": Option(metavar="CRANK|JOB|REPORT|FOLDER", positional=True),
        "project": Option(metavar="DIR"),
        "told": NOT_TYPED,
    },
    writes=(),
)


def run(arguments: argparse.Namespace) -> int:
    """Serve until interrupted; 0."""
    from autobalance.browser.serving import app
    from autobalance.command.console import say

    app(**VERB.keywords(arguments), told=lambda address: say(f"autobalance app: {address}"))
    return 0
