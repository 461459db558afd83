"""Stage, progress and remaining time of a command: on a terminal's standard error, in one line."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Literal, TextIO

from autobalance.command import objects
from autobalance.runtime import LIMITS_SOUGHT, Progress
from autobalance.verbs.progress import BALANCED_BEFORE, share_before

Mode = Literal["quiet", "usual", "verbose"]

BAR = 12
FINDINGS = ("the counterweights are too light",)
"""Beginnings of steps that say something of the crank: such a line stays on the terminal, once."""


def add_progress(parser: argparse.ArgumentParser) -> None:
    much = parser.add_mutually_exclusive_group()
    much.add_argument("-q", "--quiet", action="store_true", help="show no progress")
    much.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        help="print each step on a separate line, with the time since the start, and all of the summary",
    )


def add_objects(parser: argparse.ArgumentParser) -> None:
    """Add ``--progress json``; ``main`` looks for it before all else is read."""
    parser.add_argument(
        "--progress",
        choices=("text", "json"),
        default="text",
        help="json: on standard error one JSON object a line, for programs (default: text)",
    )


def mode_of(arguments: argparse.Namespace) -> Mode:
    """Return the detail of progress that the arguments ask for."""
    return "quiet" if arguments.quiet else "verbose" if arguments.verbose else "usual"


class ProgressLine:
    """A progress line on standard error; ``done`` takes it away.

    Usual: one line on a terminal, and findings anywhere. Verbose: a kept line for each step, anywhere.
    """

    def __init__(
        self,
        mode: Mode = "usual",
        stream: TextIO | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._mode, self._clock = mode, clock
        self._live = mode == "usual" and self._stream.isatty()
        self._start = clock()
        self._share = 0.0
        self._said: set[str] = set()

    def __call__(self, text: str, share: float | None = None) -> None:
        """Show the stage that runs now; the share done is looked up where it is not passed."""
        spent = self._clock() - self._start
        self._share = max(self._share, share_before(text, BALANCED_BEFORE) if share is None else share)
        if self._mode == "verbose":
            self._print(f"{spent:7.2f} s  {text}\n")
        elif self._mode == "usual" and text.startswith(FINDINGS):
            if text not in self._said:
                self._said.add(text)
                clear = "\r\x1b[K" if self._live else ""
                self._print(f"{clear}{text}; looking for what would help\n")
        elif self._live:
            full = round(BAR * self._share)
            bar = "#" * full + "-" * (BAR - full)
            hint = "; Ctrl-C skips this" if text == LIMITS_SOUGHT else ""
            line = f"[{bar}] {100 * self._share:3.0f} %  {text}{hint}{_left(spent, self._share)}"
            self._print(f"\r\x1b[K{line}")

    def done(self) -> None:
        """Take the line away; when verbose, say how long it took."""
        if self._live:
            self._print("\r\x1b[K")
        elif self._mode == "verbose":
            self._print(f"{self._clock() - self._start:7.2f} s  done\n")

    def _print(self, text: str) -> None:
        with suppress(OSError):  # a full disk behind standard error stops no run
            print(text, end="", file=self._stream, flush=True)


@contextmanager
def shown(mode: Mode = "usual") -> Iterator[Progress]:
    """Show progress while the block runs; yields what a public function takes as ``progress``."""
    as_objects = objects.current()
    if as_objects is not None:
        yield as_objects
        return
    line = ProgressLine(mode)
    try:
        yield line
    finally:
        line.done()


def _left(spent_s: float, share: float) -> str:
    """Return about how long it still takes, once that can be estimated."""
    if share < 0.2 or spent_s < 1.0:
        return ""
    left = spent_s * (1.0 - share) / share
    return f", about {left:.0f} s left" if left < 90.0 else f", about {left / 60.0:.0f} min left"
