"""``autobalance app``: the whole program in a browser on this machine."""

from __future__ import annotations

import argparse

from autobalance.command.verb import NOT_TYPED, Option, Verb

VERB = Verb(
    "web_app.serving:app",
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
    from autobalance.command.console import say
    from autobalance.web_app.serving import app

    app(**VERB.keywords(arguments), told=lambda address: say(f"autobalance app: {address}"))
    return 0
