"""Child processes for libraries that may crash the process they run in, print from it, or never return.

A process is started with the first request, keeps its loaded libraries for the next and ends with its parent.
"""

from __future__ import annotations

import atexit
import os
import pickle
import signal
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any, BinaryIO, Final

from autobalance.errors import AutobalanceError
from autobalance.runtime import one_thread_of_linear_algebra, to_clean


class Child:
    """A process that answers one request after the other by the ``answer`` of a module."""

    def __init__(self, module: str) -> None:
        serving = f"from autobalance.child_process import serve; serve({module!r})"
        self.process = subprocess.Popen(
            [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!r}; {serving}"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        to_clean.add(self.process.kill)

    def send(self, *request: Any) -> None:
        """Send a request, the arguments of ``answer``."""
        assert self.process.stdin
        with suppress(BrokenPipeError):  # it has ended: ``receive`` finds that out
            _write(self.process.stdin, request)

    def receive(self) -> Any:
        """Return the answer; None if the process ended instead.

        Raises
        ------
        AutobalanceError
            What ``answer`` raised.
        """
        assert self.process.stdout
        answer = _read(self.process.stdout)
        if isinstance(answer, AutobalanceError):
            raise answer
        return answer

    def end(self) -> int:
        """End the process, and return its exit code: -11 where a segmentation fault ended it."""
        assert self.process.stdin
        assert self.process.stdout
        to_clean.discard(self.process.kill)
        self.process.stdout.close()
        with suppress(BrokenPipeError):
            self.process.stdin.close()
        try:
            return self.process.wait(timeout=0.5)  # one that crashed has its code in a moment
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


class Children:
    """Pool of processes that answer by one module: as many as ever answered at one time.

    Parameters
    ----------
    module : str
        The module whose ``answer(*request)`` is called there; an ``AutobalanceError`` that it raises is
        raised here.
    """

    def __init__(self, module: str) -> None:
        self._module = module
        self._idle: list[Child] = []
        self._lock = threading.Lock()
        atexit.register(self.end)
        if hasattr(os, "register_at_fork"):  # a copy of this process would talk over the same pipes
            os.register_at_fork(after_in_child=self._forget)

    @contextmanager
    def one(self) -> Iterator[Child]:
        """Provide a process for exclusive use; it ends if the block fails by any but an AutobalanceError."""
        with self._lock:
            child = self._idle.pop() if self._idle else None
        if child is not None and child.process.poll() is not None:
            child.end()
            child = None
        child = child or Child(self._module)
        try:
            yield child
        except BaseException as error:
            if not isinstance(error, AutobalanceError) or child.process.poll() is not None:
                child.end()
                raise
            self._keep(child)
            raise
        self._keep(child)

    def _keep(self, child: Child) -> None:
        with self._lock:
            self._idle.append(child)

    def end(self) -> None:
        """End the idle processes."""
        with self._lock:
            children, self._idle = self._idle, []
        for child in children:
            child.process.kill()
            child.end()

    def _forget(self) -> None:
        self._idle, self._lock = [], threading.Lock()


def serve(module: str) -> None:
    """Answer for the process that started this one, until it closes the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent's to deal with, who then closes the pipe
    one_thread_of_linear_algebra()
    requests, answers = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)  # for what libraries print
    os.close(nowhere)
    answer = import_module(module).answer
    while (request := _read(requests)) is not None:
        try:
            result = answer(*request)
        except AutobalanceError as error:
            result = error
        _write(answers, result)


@contextmanager
def ended_after(processor_s: float) -> Iterator[None]:
    """Let the system end this process by SIGPROF after so much of its processor time; not on Windows."""
    timed = hasattr(signal, "setitimer")
    if timed:
        signal.setitimer(signal.ITIMER_PROF, processor_s)
    try:
        yield
    finally:
        if timed:
            signal.setitimer(signal.ITIMER_PROF, 0.0)


LENGTH: Final = struct.Struct("<Q")


def _write(pipe: BinaryIO | Any, message: Any) -> None:
    data = pickle.dumps(message)
    pipe.write(LENGTH.pack(len(data)))
    pipe.write(data)
    pipe.flush()


def _read(pipe: BinaryIO | Any) -> Any:
    """Return the next message, or None where the other side has ended."""
    head = pipe.read(LENGTH.size)
    if len(head) < LENGTH.size:
        return None
    data = pipe.read(LENGTH.unpack(head)[0])
    return pickle.loads(data)
