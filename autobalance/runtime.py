"""Settings of the process: memory of large arrays, clocks, standard output, signals.

Nothing of the process is changed on import; ``keep_freed_memory``, ``collect_rarely``, ``interruptible`` and
``one_thread_of_linear_algebra`` are for the command line, whose process is its own.
"""

from __future__ import annotations

import gc
import mmap
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from pathlib import Path
    from types import FrameType

T = TypeVar("T")

Progress = Callable[[str, float], object]
"""Called with the running step and the finished share of the whole, 0 to 1; raise from it to cancel."""
Notify = Callable[[str], object]
"""Called with the running step; raise from it to cancel."""


def no_progress(_text: str, _share: float) -> None:
    """Ignore progress, if nothing shows it."""


class Stopwatch:
    """Seconds spent in each stage of a run."""

    def __init__(self) -> None:
        self._start = time.perf_counter()
        self._spent: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time of the block for a stage."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.add(name, time.perf_counter() - start)

    def add(self, name: str, seconds: float) -> None:
        """Count more seconds for a stage."""
        self._spent[name] = self._spent.get(name, 0.0) + seconds

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds of each stage, and ``total``, those since the start."""
        return {**self._spent, "total": time.perf_counter() - self._start}


ONE_THREAD = "OPENBLAS_NUM_THREADS"
"""The matrices here are small: threads of the linear algebra only take the processor from other work."""


def one_thread_of_linear_algebra() -> None:
    """Limit linear algebra to one thread, unless the environment sets another; call before numpy loads."""
    os.environ.setdefault(ONE_THREAD, "1")


TRIM_THRESHOLD, MMAP_THRESHOLD, ARENA_MAX = -1, -3, -8
"""Parameters of glibc's ``mallopt`` (malloc.h)."""
KEPT_BYTES = 1 << 30
"""Freed memory, and arrays, up to this size stay with the process."""


def keep_freed_memory() -> bool:
    """Reuse the memory of a freed array for the next one; return whether that can be set here.

    By default glibc gives every array of some megabytes back to the system at once and asks for the next one
    again. Its pages then cost more to provide than the arithmetic on them. It also gives every thread
    separate memory. The peak stays nearly the same.
    """
    if sys.platform != "linux":
        return False
    import ctypes

    try:
        set_option = ctypes.CDLL(None).mallopt
    except AttributeError:  # another C library
        return False
    options = {MMAP_THRESHOLD: KEPT_BYTES, TRIM_THRESHOLD: KEPT_BYTES, ARENA_MAX: 1}
    return all(set_option(option, value) == 1 for option, value in options.items())


OBJECTS_BETWEEN_COLLECTIONS = 20_000
"""Objects made before those that refer to each other in a ring are looked for; Python's own limit is 700."""


def collect_rarely() -> None:
    """Look for rings of objects rarely, for good: for commands, whose process ends soon.

    What a command loads stays to its end, and each look goes through all of it: 0.1 s of the main job.
    """
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS)


def own_standard_output() -> None:
    """Give results a separate descriptor, and discard all other output on descriptor 1, for good.

    For commands, once, before there are threads: a library leaves descriptors alone. HiGHS prints a line past
    every option ("HighsMipSolverData::transformNewIntegerFeasibleSolution", scipy 1.17), which would be
    in the midst of a report on standard output.
    """
    global _owns_standard_output  # noqa: PLW0603
    stream = sys.stdout
    if sys.platform == "win32" or not isinstance(stream, TextIOWrapper):
        return
    try:
        if stream.fileno() != 1:
            return
        stream.flush()
        own = os.dup(1)
    except OSError:  # no standard output at all
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    sys.stdout = open(  # noqa: SIM115
        own,
        "w",
        encoding=stream.encoding,
        errors=stream.errors,
        buffering=1 if stream.line_buffering else -1,
        closefd=False,  # as Python's own streams: open to the end of the process
    )
    _owns_standard_output = True


_owns_standard_output = False


def silence_loggers() -> None:
    """Discard what libraries log, for good: standard error holds the command's own lines.

    For commands, as ``own_standard_output`` is. npTDMS logs a cut-off file with a separate handler,
    matplotlib a home folder that cannot be written.
    """
    import logging

    logging.disable(logging.CRITICAL)


def owns_standard_output() -> bool:
    """Return whether output of libraries on descriptor 1 is discarded, in a process that is our own."""
    return _owns_standard_output


# --- the files of a command ---------------------------------------------------------------------------------

_read: set[str] | None = None


@contextmanager
def reading_noted() -> Iterator[None]:
    """Record the files that are read, so that a command writes over none of them."""
    global _read  # noqa: PLW0603
    before, _read = _read, set()
    try:
        yield
    finally:
        _read = before


def note_read(path: Path) -> None:
    """Record a file as read by a command; do nothing outside of commands."""
    if _read is not None:
        _read.add(os.path.realpath(path))


def was_read(path: Path) -> bool:
    return _read is not None and os.path.realpath(path) in _read


# --- signals ------------------------------------------------------------------------------------------------


class Skipped(KeyboardInterrupt):
    """The first Ctrl-C within a `skippable` block."""


class _Interruptions:
    """State of interruptions: count of the blocks that hold them back, and what came meanwhile."""

    waits = 0
    came: type[KeyboardInterrupt] | None = None
    may_skip = False


SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
"""Ctrl-C, termination, and hang-up of the terminal: all of them stop a command the same way."""


@contextmanager
def interruptible() -> Iterator[None]:
    """Let the signals that stop a command raise KeyboardInterrupt, at a moment when nothing is half done.

    For commands: a library leaves signal handlers alone. What the process ignores stays ignored.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    process = os.getpid()

    def stop(number: int, _: FrameType | None) -> None:
        if os.getpid() != process:  # a child that was forked ends as any process does
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
        else:
            _interrupt(number == signal.SIGINT)

    numbers = _numbers()
    before = {number: signal.getsignal(number) for number in numbers}
    caught = [number for number in numbers if before[number] not in (signal.SIG_IGN, None)]
    try:
        for number in caught:
            signal.signal(number, stop)
        yield
    finally:
        for number in caught:
            signal.signal(number, before[number])


def _interrupt(by_ctrl_c: bool) -> None:
    """Raise what an interruption is here, or keep it until what holds it back is done."""
    kind = Skipped if by_ctrl_c and _Interruptions.may_skip else KeyboardInterrupt
    _Interruptions.may_skip = False  # a second one ends the command
    if not _Interruptions.waits:
        raise kind
    if _Interruptions.came is not KeyboardInterrupt:
        _Interruptions.came = kind


LIMITS_SOUGHT = "looking for limits that would suffice"
"""Step of a command that is `skippable`."""
SKIP = getattr(signal, "SIGUSR1", None)
"""Signal by which the supervisor of a command passes on a Ctrl-C that ends a `skippable` block alone."""
_skips: mmap.mmap | None = None


def share_skips() -> mmap.mmap:
    """Return two bytes shared with a child about to be forked.

    The first is 1 while the child is in a `skippable` block, the second once one of both took the last word.
    """
    global _skips  # noqa: PLW0603
    _skips = mmap.mmap(-1, 2)
    return _skips


def share_no_skips() -> None:
    """Forget the bytes once the child has ended."""
    global _skips  # noqa: PLW0603
    _skips = None


def takes_last_word() -> bool:
    """Return whether nobody has reported yet that the command was stopped; from now on somebody has.

    A child that was slow to end after it had spoken is killed, and its parent must not repeat it.
    """
    if _skips is None:
        return True
    is_first = _skips[1] == 0
    _skips[1] = 1
    return is_first


@contextmanager
def skippable() -> Iterator[None]:
    """Let the first Ctrl-C of a command raise `Skipped` within a block: work that the rest does not need."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    if _skips is not None and SKIP is not None:
        signal.signal(SKIP, lambda *_: _interrupt(True) if _Interruptions.may_skip else None)
        _skips[0] = 1
    _Interruptions.may_skip = True
    try:
        yield
    finally:
        _Interruptions.may_skip = False
        if _skips is not None:
            _skips[0] = 0


LATEST_S = 1.2
"""Time that work in a library, which no signal stops, may continue after a command was ended."""
to_clean: set[Callable[[], None]] = set()
"""Clean-up of begun files and child processes, for a command that ends in the midst of a library's work."""


_notes: int | None = None


def start_record_of_begun() -> int:
    """Start a record of begun files and folders, for whoever ends this process; return its descriptor."""
    global _notes  # noqa: PLW0603
    if hasattr(os, "memfd_create"):
        _notes = os.memfd_create("begun")
    else:
        import tempfile

        with tempfile.TemporaryFile() as file:
            _notes = os.dup(file.fileno())
    return _notes


def note_begun(path: Path) -> None:
    """Record a temporary file or a folder about to be created; do nothing outside of commands."""
    if _notes is not None:
        os.write(_notes, os.fsencode(os.path.abspath(path)) + b"\0")


def begun_paths(notes: int) -> list[bytes]:
    """Return the recorded paths, in order."""
    return os.pread(notes, os.fstat(notes).st_size, 0).split(b"\0")[:-1]


@contextmanager
def ended_in_time(last_words: Callable[[], int]) -> Iterator[None]:
    """End the process soon after a signal to stop, though a library holds on to the main thread.

    Python handles a signal when a call into a library returns; a solver's search takes minutes. A separate
    thread handles it at once. ``last_words`` reports that the command was stopped and returns its exit code.
    """
    if sys.platform == "win32" or threading.current_thread() is not threading.main_thread():
        yield
        return
    ears, mouth = os.pipe()
    os.set_blocking(mouth, False)
    over, process = threading.Event(), os.getpid()

    def listen() -> None:
        while heard := os.read(ears, 1):
            if heard[0] in _numbers() and not over.wait(LATEST_S):
                while _Interruptions.waits and not over.wait(0.05):
                    pass
                if not over.is_set() and os.getpid() == process:
                    for clean in list(to_clean):
                        clean()
                    os._exit(last_words())

    before = signal.set_wakeup_fd(mouth, warn_on_full_buffer=False)
    thread = threading.Thread(target=listen, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        signal.set_wakeup_fd(before)
        os.close(mouth)
        thread.join()
        os.close(ears)


@contextmanager
def starting_process() -> Iterator[None]:
    """Hold back the signals that stop a command while a process is started, here and in the process.

    A terminal sends Ctrl-C to the new process too, which, half started, could only print a complaint. It
    receives signals again after `hear_signals`.
    """
    with uninterrupted():
        before = held_signals(_numbers())
        try:
            yield
        finally:
            if sys.platform != "win32":
                signal.pthread_sigmask(signal.SIG_SETMASK, before)


def held_signals(numbers: Iterable[int]) -> set[int]:
    """Block signals in this thread and in processes that it starts; return those blocked before."""
    if sys.platform == "win32":
        return set()
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # it would undo the block when it is started for the first process
    return {int(number) for number in signal.pthread_sigmask(signal.SIG_BLOCK, numbers)}


def hear_signals() -> None:
    """Unblock the signals held back while this process was started; Ctrl-C is ignored, left to its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _numbers())


def _numbers() -> list[int]:
    return [int(getattr(signal, name)) for name in SIGNALS if hasattr(signal, name)]


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Hold an interruption of a command back until the block is done; it then takes effect."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _Interruptions.waits += 1
    try:
        yield
    finally:
        _Interruptions.waits -= 1
    if _Interruptions.came and not _Interruptions.waits:
        kind, _Interruptions.came = _Interruptions.came, None
        raise kind
