"""The terminal: results to standard output, progress and warnings to standard error."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from autobalance.command import objects
from autobalance.errors import FileError, one_line, system_reason

if TYPE_CHECKING:  # paths load a tenth of what `--help` takes
    from pathlib import Path

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
