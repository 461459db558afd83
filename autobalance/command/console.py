"""What goes to the terminal: results to standard output, progress and warnings to standard error."""

from __future__ import annotations

import os
import sys

from autobalance.errors import one_line


def say(text: str) -> None:
    """Print a result; a reader that has gone away (``| head``) is no error."""
    try:
        print(text, flush=True)  # noqa: T201
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115


def warn(text: str) -> None:
    """Print a warning."""
    print(f"autobalance: warning: {one_line(text)}", file=sys.stderr)  # noqa: T201


def progress(text: str) -> None:
    """Say what runs, on a terminal only, each line over the one before."""
    if sys.stderr.isatty():
        print(f"\r\x1b[K{text} ...", end="", file=sys.stderr, flush=True)  # noqa: T201


def progress_done() -> None:
    """Take the line of ``progress`` away."""
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)  # noqa: T201
