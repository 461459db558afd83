"""Processes that end with the tests that began them, also where those are killed and tidy nothing up."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Iterator, Sequence
from typing import Any

WATCH = 'read -r _; kill -TERM -"$1" 2>/dev/null && sleep 3; kill -KILL -"$1" 2>/dev/null'
"""Waits for the end of its standard input, which comes with the end of whoever holds the other side."""
PATIENCE_S = 30.0


@contextlib.contextmanager
def kept(command: Sequence[str], **how: Any) -> Iterator[subprocess.Popen[Any]]:
    """Run a process in a group of its own; end it and all that it began, at the latest with this process."""
    process: subprocess.Popen[Any] = subprocess.Popen(command, start_new_session=True, **how)
    watcher = subprocess.Popen(
        ["sh", "-c", WATCH, "sh", str(process.pid)], stdin=subprocess.PIPE, start_new_session=True
    )
    try:
        yield process
    finally:
        watcher.kill()
        watcher.communicate()
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(timeout=PATIENCE_S)
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        for stream in (process.stdout, process.stderr):
            if stream is not None:
                stream.close()
