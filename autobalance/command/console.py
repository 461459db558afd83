"""What goes to the terminal: results to standard output, progress and warnings to standard error."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from pathlib import Path

from autobalance.errors import one_line


def say(text: str) -> None:
    """Print a result, on a terminal in colour; a reader that has gone away (``| head``) is no error."""
    from autobalance.command import terminal

    try:
        if terminal.is_terminal() and not text.startswith("{"):
            terminal.show(text)
        else:
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


def called_as() -> str:
    """Return what to type to call this program again from the folder that it was called from.

    The bare name works where the environment is activated; ``make demo`` runs it by its path.
    """
    program = Path(sys.argv[0])
    if program.name == "__main__.py":
        return f"{_short(Path(sys.executable))} -m autobalance"
    if program.suffix == ".py":
        return f"{_short(Path(sys.executable))} {shlex.quote(sys.argv[0])}"
    found = shutil.which("autobalance")
    if not program.is_file() or (found is not None and Path(found).samefile(program)):
        return "autobalance"
    return _short(program)


def _short(program: Path) -> str:
    found = shutil.which(program.name)
    if found is not None and Path(found) == program:
        return program.name
    here = Path.cwd()
    path = program.relative_to(here) if program.is_relative_to(here) else program
    return shlex.quote(str(path))
