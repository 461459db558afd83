"""A command works in a child, so that being ended reaches it in time though a library holds the interpreter.

Python handles a signal between its own steps. While a library computes with the interpreter held (a boolean
of the CAD kernel, for example), no other thread runs. The process that the user started only waits. It passes
on a signal that ends a command, ends the child if it does not end by itself, removes the unfinished files and
reports it.
"""

from __future__ import annotations

import mmap
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from types import FrameType
from typing import Any

from autobalance.runtime import SIGNALS, SKIP, begun_paths, share_no_skips, share_skips, start_record_of_begun

PATIENCE_S = 1.4
"""Time for the child to end by itself [s]; from `runtime.LATEST_S` on a separate thread tries to."""
DIES_WITH_PARENT = 1
"""``PR_SET_PDEATHSIG`` of Linux' ``prctl``."""


def supervised(work: Callable[[], int], last_words: Callable[[], int]) -> int:
    """Run work in a child and return its exit code; a signal that ended the child ends this process, too.

    Parameters
    ----------
    work : callable
        Returns the exit code.
    last_words : callable
        Says that the command was stopped, where the child could not, and returns the exit code.
    """
    if not hasattr(os, "fork"):
        return work()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()  # else both processes would write what waits
    named = [getattr(signal, name) for name in SIGNALS]
    stopping = [number for number in named if signal.getsignal(number) is not signal.SIG_IGN]
    notes, skips, parent = start_record_of_begun(), share_skips(), os.getpid()
    ears, mouth = os.pipe()
    os.set_blocking(mouth, False)
    handled = {number: signal.signal(number, _heard) for number in (*stopping, signal.SIGCHLD)}
    signal.set_wakeup_fd(mouth, warn_on_full_buffer=False)
    child = os.fork()
    if child:
        try:
            return _end_of(child, ears, set(stopping), handled, skips, lambda: _stopped(notes, last_words))
        finally:
            share_no_skips()
    signal.set_wakeup_fd(-1)
    os.close(ears)
    os.close(mouth)
    for number in handled:
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal's Ctrl-C is passed on, so that it comes once
    _end_with(parent)
    return work()


def _end_of(
    child: int,
    ears: int,
    stopping: set[int],
    handled: dict[int, Any],
    skips: mmap.mmap,
    stopped: Callable[[], int],
) -> int:
    """Wait for the child, pass on what ends it, and return the exit code."""
    latest: float | None = None
    while True:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            break
        if latest is not None and time.monotonic() > latest:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return stopped()
        wait_s = None if latest is None else max(latest - time.monotonic(), 0.0) + 0.01
        heard = stopping & set(os.read(ears, 512)) if select.select([ears], [], [], wait_s)[0] else set()
        if heard == {signal.SIGINT} and SKIP is not None and skips[0] == 1:
            skips[0] = 2  # a second Ctrl-C ends the command
            os.kill(child, SKIP)
        elif heard and latest is None:
            latest = time.monotonic() + PATIENCE_S
            os.kill(child, signal.SIGTERM)
    signal.set_wakeup_fd(-1)
    for number, before in handled.items():
        signal.signal(number, before)
    code = os.waitstatus_to_exitcode(status)
    if code < 0:  # as it would have ended this process
        with suppress(OSError, ValueError):
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    return code


def _heard(_number: int, _frame: FrameType | None) -> None:
    """Let a signal be heard by the pipe alone."""


def _stopped(notes: int, last_words: Callable[[], int]) -> int:
    _remove(begun_paths(notes))
    return last_words()


def _remove(paths: Iterable[bytes]) -> None:
    """Take away the files and the empty folders that a child has begun, the last first."""
    for path in reversed(list(paths)):
        with suppress(OSError):
            if os.path.isdir(path) and not os.path.islink(path):
                os.rmdir(path)
            else:
                os.unlink(path)


def _end_with(parent: int) -> None:
    """Let the system end this process with its parent, however that goes; where it can."""
    if sys.platform != "linux":
        return
    import ctypes

    with suppress(AttributeError):  # another C library
        ctypes.CDLL(None).prctl(DIES_WITH_PARENT, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)
