"""The terminal: results to standard output; stage, progress and warnings to standard error."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Literal, TextIO

from autobalance.command import objects
from autobalance.errors import FileError, one_line, system_reason
from autobalance.runtime import LIMITS_SOUGHT, Progress
from autobalance.verbs.progress import BALANCED_BEFORE, share_before

if TYPE_CHECKING:
    from pathlib import Path


# The terminal: results to standard output, progress and warnings to standard error.


WARNING = "autobalance: warning: "


def open_closed_streams() -> None:
    """Give standard output and error a place where they were closed before the program began: nowhere.

    Otherwise the next file that is opened takes their number, and the output of any library ends up in it.
    """
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            _to_nowhere(name)


def _to_nowhere(name: str) -> None:
    setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115


def say(text: str) -> None:
    """Print a result for people, its lines broken between words, on a terminal in colour.

    A reader that has gone away (``| head``) is not an error.

    Raises
    ------
    FileError
        If it cannot be written.
    """
    from autobalance.command import terminal

    _print(terminal.fit(text))


def say_as_it_is(text: str) -> None:
    """Print what programs read, such as JSON, as ``say`` prints but line by line as it is."""
    _print(text)


def _print(text: str) -> None:
    from autobalance.command import terminal

    with written():
        if terminal.is_terminal() and not text.startswith("{"):
            terminal.show(text)
        else:
            print(text, flush=True)  # noqa: T201


@contextmanager
def written() -> Iterator[None]:
    """Write to standard output inside the block; that it takes nothing more is an error of one line.

    Raises
    ------
    FileError
        If the disk behind it is full, for example.
    """
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        _to_nowhere("stdout")  # which is flushed once more at the very end
    except OSError as error:
        _to_nowhere("stdout")
        why = system_reason(error)
        raise FileError(f"cannot write to standard output: {why}") from None


def complain(text: str) -> None:
    """Print a line on standard error, or nowhere if that takes nothing."""
    as_objects = objects.current()
    if as_objects is not None:
        as_objects.write({"warning": text.removeprefix(WARNING)})
        return
    try:
        print(text, file=sys.stderr, flush=True)  # noqa: T201
    except OSError:
        _to_nowhere("stderr")


def warn(text: str) -> None:
    complain(f"{WARNING}{one_line(text)}")


def fail(lines: Sequence[str], exit_code: int) -> int:
    """Print errors, each on one line; return the exit code."""
    as_objects = objects.current()
    if as_objects is not None:
        as_objects.fail(lines, exit_code)
        return exit_code
    for line in lines:
        complain(f"autobalance: error: {line}")
    return exit_code


def called_as() -> str:
    """Return the command that calls this program again from the folder that it was called from.

    The bare name works where the environment is activated; ``make demo`` runs it by its path.
    """
    import shlex
    import shutil
    from pathlib import Path

    program = Path(sys.argv[0])
    if program.name == "__main__.py":
        return f"{_short(Path(sys.executable))} -m autobalance"
    if program.suffix == ".py":
        return f"{_short(Path(sys.executable))} {shlex.quote(sys.argv[0])}"
    installed = shutil.which("autobalance")
    if not program.is_file() or (installed is not None and Path(installed).samefile(program)):
        return "autobalance"
    return _short(program)


def _short(program: Path) -> str:
    import shlex
    import shutil
    from pathlib import Path

    installed = shutil.which(program.name)
    if installed is not None and Path(installed) == program:
        return program.name
    here = Path.cwd()
    path = program.relative_to(here) if program.is_relative_to(here) else program
    return shlex.quote(str(path))


# Stage, progress and remaining time of a command: on a terminal's standard error, in one line.


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
