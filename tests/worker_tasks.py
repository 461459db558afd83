"""Tasks for tests of workers; a module of its own, since each worker imports it."""

from __future__ import annotations

import os
import signal
from pathlib import Path


def square_unless_killed(task: tuple[int, str]) -> int:
    """Square a number; the worker of number 2 kills itself until enough marks of that lie in a folder."""
    number, folder = task
    if number == 2:
        marks = list(Path(folder).iterdir())
        if len(marks) < int((Path(folder).parent / "deaths").read_text()):
            (Path(folder) / f"mark{len(marks)}").touch()
            os.kill(os.getpid(), signal.SIGKILL)
    return number * number
