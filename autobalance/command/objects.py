"""``--progress json``: standard error as one JSON object a line, for programs that run this one."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import pairwise
from typing import Any, TextIO

EVERY_S = 0.9
"""A program that hears nothing for a second may think that nobody works any more."""


class Objects:
    """Progress as JSON objects, repeated about once a second; the share never falls."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream, self._clock = stream, clock
        self._start = clock()
        self._stage, self._share = "starting", 0.0
        self._lock, self._ended = threading.Lock(), threading.Event()

    def __call__(self, text: str, share: float | None = None) -> None:
        """Report the stage that runs now; the share done is looked up where none is passed."""
        from autobalance.verbs.progress import BALANCED_BEFORE, share_before

        done = share_before(text, BALANCED_BEFORE) if share is None else share
        with self._lock:
            self._stage, self._share = text, min(1.0, max(self._share, done))
            self._print_stage()

    def write(self, values: dict[str, Any]) -> None:
        with self._lock:
            self._print(values)

    def fail(self, lines: Sequence[str], exit_code: int) -> None:
        self._ended.set()
        self.write({"error": "\n".join(lines), "exit": exit_code})

    def repeat(self) -> None:
        """Print the same stage again until the end; runs in a separate thread."""
        while not self._ended.wait(EVERY_S):
            with self._lock:
                if not self._ended.is_set():  # the last line is the end, not what was before it
                    self._print_stage()

    def end(self, is_done: bool) -> None:
        """Stop; what was done is reported as such."""
        self._ended.set()
        if is_done:
            self("done", 1.0)

    def _print_stage(self) -> None:
        """Print the stage, its share and the elapsed time; the caller holds the lock."""
        elapsed = round(self._clock() - self._start, 3)
        self._print({"stage": self._stage, "share": self._share, "elapsed_s": elapsed})

    def _print(self, values: dict[str, Any]) -> None:
        import json

        with suppress(OSError, ValueError):  # a reader that has gone away stops no run
            self._stream.write(json.dumps(values, ensure_ascii=False, allow_nan=False) + "\n")
            self._stream.flush()


_current: Objects | None = None


def current() -> Objects | None:
    """Return the writer of objects while a command writes them; None where people read."""
    return _current


@contextmanager
def written_as_objects() -> Iterator[Objects]:
    """Write all of standard error as objects inside the block."""
    global _current  # noqa: PLW0603
    before, _current = _current, Objects(sys.stderr)
    thread = threading.Thread(target=_current.repeat, daemon=True)
    thread.start()
    try:
        yield _current
    finally:
        _current.end(is_done=False)
        thread.join()
        _current = before


def are_asked_for(arguments: Sequence[str]) -> bool:
    """Return whether ``--progress json`` is among what was typed."""
    return "--progress=json" in arguments or ("--progress", "json") in pairwise(arguments)
