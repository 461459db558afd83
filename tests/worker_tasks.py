"""Tasks for tests of workers; a module of its own, since each worker imports it."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import numpy as np

from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.studies.batch.run import RowOutcome, RowTask, balance_row

DEADLY = 0.61
"""Balance factor of the row whose worker dies each time."""


def square_unless_killed(task: tuple[int, str]) -> int:
    """Square a number; the worker of number 2 kills itself until enough marks of that lie in a folder."""
    number, folder = task
    if number == 2:
        marks = list(Path(folder).iterdir())
        if len(marks) < int((Path(folder).parent / "deaths").read_text()):
            (Path(folder) / f"mark{len(marks)}").touch()
            os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def threads_after(segments: int) -> int:
    """Return how many threads this process has after a boolean and some linear algebra (Linux)."""
    ball = Solid.prism(Region.circle(1.0, segments), 0.0, 1.0)
    assert not (ball & ball.moved(np.diag([1.0, 1.0, 0.5, 1.0]))).is_empty
    assert np.isfinite(np.linalg.eigvalsh(np.eye(300))).all()
    return len(list(Path("/proc/self/task").iterdir()))


def balance_unless_deadly(task: RowTask) -> RowOutcome:
    """Balance a row; the worker of one kills itself."""
    if task.job.balance.factor == DEADLY:
        os.kill(os.getpid(), signal.SIGKILL)
    return balance_row(task)
