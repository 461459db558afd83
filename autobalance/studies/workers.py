"""One way to run many tasks: in this process, in processes of this machine, or on a Dask cluster.

Results do not depend on which, nor on the number of workers, nor on workers that die: a task is a function of
its arguments alone, and its result comes with its number.
"""

from __future__ import annotations

import os
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait as wait_for_end
from typing import Any, Protocol

from autobalance.errors import FileError, UsageError
from autobalance.runtime import (
    hear_signals,
    one_thread_of_linear_algebra,
    own_standard_output,
    starting_process,
)
from autobalance.solid.csg.solid import booleans_in_one_thread
from autobalance.value_classes import dataclass
from autobalance.version import __version__

TRIES = 3
"""Workers that a task may lose before it is given up."""
CLUSTER_TIMEOUT_S = 10.0
WORKER_RESTART_TIMEOUT_S = 120.0
"""Time given to a cluster without workers to start some again."""
LOOK_AGAIN_S = 0.25
"""Interval between questions to a cluster about its workers."""


@dataclass(frozen=True)
class Done:
    """The end of a task: its number, its value, and by which worker at which try.

    ``lost`` marks a task whose worker died at each try; it has no value.
    """

    number: int
    value: Any
    worker: str
    attempt: int
    lost: bool = False


Work = Callable[[Any], Any]


class Workers(Protocol):
    """Pool or cluster that runs tasks."""

    def run(self, work: Work, tasks: Sequence[Any]) -> Iterator[Done]:
        """Yield the end of each task, in the order in which they end.

        What a task itself raises is raised here.
        """
        ...


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    with suppress(AttributeError):  # not on every system
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def workers_of(
    count: int | None, cluster: str | None = None, timeout_s: float = CLUSTER_TIMEOUT_S, *, alone: bool = True
) -> Iterator[Workers]:
    """Provide workers; none of them outlives the block.

    Parameters
    ----------
    count : int or None
        Processes here; None: as many as this process has cores.
    cluster : str or None
        Address of a Dask scheduler (``tcp://host:port``), whose workers are taken instead.
    timeout_s : float
        How long the cluster may take to answer [s].
    alone : bool
        Whether one worker may be this process itself; else a task that kills its process kills only that.

    Raises
    ------
    UsageError
        If the count is not positive.
    FileError
        If the cluster does not answer, has no workers, or has another version of this package.
    """
    if cluster is not None:
        with _cluster(cluster, timeout_s) as workers:
            yield workers
        return
    count_wanted = available_cores() if count is None else count
    if count_wanted < 1:
        raise UsageError(f"workers is {count_wanted}; must be ≥ 1")
    if count_wanted == 1 and alone:
        yield InThisProcess()
        return
    processes = Processes(count_wanted)
    try:
        yield processes
    finally:
        processes.end()


class InThisProcess:
    """Runs tasks one after the other, here."""

    def run(self, work: Work, tasks: Sequence[Any]) -> Iterator[Done]:
        """Yield the end of each task, in order."""
        for number, task in enumerate(tasks):
            yield Done(number, work(task), f"{os.getpid()}", 1)


# --- processes of this machine ------------------------------------------------------------------------------


def _begin_worker() -> None:
    """Leave Ctrl-C to the parent, keep to one core, and end when the parent is gone, however it went."""
    own_standard_output()
    one_thread_of_linear_algebra()
    booleans_in_one_thread()
    hear_signals()
    parent = parent_process()
    if parent is not None:
        sentinel = parent.sentinel
        threading.Thread(target=_end_with_parent, args=(sentinel,), daemon=True).start()


def _end_with_parent(sentinel: Any) -> None:
    wait_for_end([sentinel])
    os._exit(1)


@dataclass(eq=False)
class _Slot:
    """One process at a time, so that the task of a process that dies is known."""

    executor: ProcessPoolExecutor | None = None
    pid: int | None = None

    def submit(self, work: Work, task: Any) -> Future[tuple[int, Any]]:
        if self.executor is None:
            with starting_process():  # the process starts with its first task
                self.executor = ProcessPoolExecutor(1, get_context("spawn"), initializer=_begin_worker)
                return self.executor.submit(_with_pid, work, task)
        return self.executor.submit(_with_pid, work, task)

    def end(self) -> None:
        """End the process at any point of its work."""
        if self.executor is None:
            return
        processes = list((self.executor._processes or {}).values())
        self.executor.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.kill()
        for process in processes:
            process.join()
        self.executor = None


def _with_pid(work: Work, task: Any) -> tuple[int, Any]:
    return os.getpid(), work(task)


class Processes:
    """Runs tasks in processes of this machine, each process one task at a time."""

    def __init__(self, count: int) -> None:
        self._slots = [_Slot() for _ in range(count)]

    def run(self, work: Work, tasks: Sequence[Any]) -> Iterator[Done]:
        """Yield the end of each task; the tasks of a process that dies go to others.

        A process has its next task before the end of its last one is reported, so it does not wait.
        """
        waiting = [(number, 1) for number in range(len(tasks))][::-1]
        idle = self._slots[::-1]
        running: dict[Future[tuple[int, Any]], tuple[int, int, _Slot]] = {}
        ended: list[Done] = []
        while waiting or running:
            while waiting and idle:
                number, attempt = waiting.pop()
                slot = idle.pop()
                running[slot.submit(work, tasks[number])] = number, attempt, slot
            yield from ended
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            ended = []
            for future in done:
                number, attempt, slot = running.pop(future)
                idle.append(slot)
                try:
                    pid, value = future.result()
                except BrokenProcessPool:
                    slot.end()
                    if attempt < TRIES:
                        waiting.append((number, attempt + 1))
                    else:
                        ended.append(Done(number, None, "", attempt, lost=True))
                    continue
                ended.append(Done(number, value, f"{pid}", attempt))
        yield from ended

    def end(self) -> None:
        """End every process."""
        for slot in self._slots:
            slot.end()


# --- a cluster ----------------------------------------------------------------------------------------------


@contextmanager
def _cluster(address: str, timeout_s: float) -> Iterator[Workers]:
    """Connect to a Dask scheduler whose workers have this version."""
    try:
        import distributed
    except ImportError:
        raise FileError(
            "a cluster needs dask.distributed, which is not installed: pip install 'autobalance[cluster]'"
        ) from None
    kind: Any = distributed.Client
    client = kind.__new__(kind)
    try:
        client.__init__(address, timeout=timeout_s, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        client.status = "closed"  # else it would still talk to the scheduler at its end, and complain
        reason = " ".join(str(error).split()) or "no answer"
        raise FileError(f"the cluster {address} did not answer within {timeout_s:g} s: {reason}") from None
    try:
        _check_versions(client, address)
        yield Cluster(client, timeout_s)
    finally:
        client.close(timeout=timeout_s)


def _check_versions(client: Any, address: str) -> None:
    """Refuse a cluster without workers, or with another version of this package."""
    versions = client.run(version_asker())
    if not versions:
        raise FileError(f"the cluster {address} has no workers; expected at least one")
    for worker, version in sorted(versions.items()):
        if version != __version__:
            has = "no autobalance" if version is None else f"autobalance {version}"
            raise FileError(f"worker {worker} of the cluster {address} has {has}; expected {__version__}")


def version_asker() -> Callable[[], str | None]:
    """Return a function that asks a worker for its version of this package (None: not installed).

    A function within a function is sent by value, so that a worker without this package can run it.
    """

    def version() -> str | None:
        try:
            from autobalance.version import __version__ as found
        except ImportError:
            return None
        return found

    return version


@dataclass(eq=False)
class Cluster:
    """Runs tasks on the workers of a Dask cluster, by its executor.

    Each task goes to one worker that has a free thread. Were the scheduler left to choose, it would hand the
    tasks of a dead worker on by itself, and count tries of tasks that were only in its queue.
    """

    client: Any
    timeout_s: float = CLUSTER_TIMEOUT_S

    def run(self, work: Work, tasks: Sequence[Any]) -> Iterator[Done]:
        """Yield the end of each task; the tasks of a worker that dies go to others."""
        waiting = [(number, 1) for number in range(len(tasks))][::-1]
        running: dict[Future[Any], _OnWorker] = {}
        try:
            while waiting or running:
                threads = self._threads(running)
                for address in _free(threads, running):
                    if waiting:
                        number, attempt = waiting.pop()
                        future = self._submit(address, work, tasks[number])
                        running[future] = _OnWorker(number, attempt, address)
                done, _ = wait(running, LOOK_AGAIN_S, FIRST_COMPLETED)
                lost = {future for future, at in running.items() if at.address not in threads}
                for future in done | lost:
                    at = running.pop(future)
                    died, value = _outcome(future, self.client)
                    if not died:
                        yield Done(at.number, value, at.address, at.attempt)
                    elif at.attempt < TRIES:
                        waiting.append((at.number, at.attempt + 1))
                    else:
                        yield Done(at.number, None, "", at.attempt, lost=True)
        finally:
            for future in running:
                future.cancel()

    def _submit(self, address: str, work: Work, task: Any) -> Future[Any]:
        executor = self.client.get_executor(
            pure=False, retries=0, workers=[address], allow_other_workers=False
        )
        future: Future[Any] = executor.submit(work, task)
        return future

    def _threads(self, running: Mapping[Future[Any], _OnWorker]) -> dict[str, int]:
        """Return the workers with their threads; waits a while where the last has just gone."""
        since = time.monotonic()
        while True:
            patience_s = max(self.timeout_s, WORKER_RESTART_TIMEOUT_S)
            try:
                threads: dict[str, int] = self.client.nthreads()
            except OSError:  # the scheduler itself does not answer
                threads, patience_s = {}, self.timeout_s
            if threads or any(future.done() for future in running):
                return threads
            if time.monotonic() - since > patience_s:
                raise FileError("the cluster went away; finished work is kept")
            time.sleep(LOOK_AGAIN_S)


@dataclass(frozen=True)
class _OnWorker:
    """A task on its way: its number, which try it is, and the worker that has it."""

    number: int
    attempt: int
    address: str


def _free(threads: Mapping[str, int], running: Mapping[Future[Any], _OnWorker]) -> list[str]:
    """Return workers once for each thread that has nothing to do."""
    busy = Counter(at.address for at in running.values())
    return [address for address, count in threads.items() for _ in range(count - busy[address])]


def _outcome(future: Future[Any], client: Any) -> tuple[bool, Any]:
    """Return whether a task's worker died before its end, and the task's value."""
    from distributed import KilledWorker

    if not future.done():
        future.cancel()
        return True, None
    try:
        return False, future.result()
    except KilledWorker:
        return True, None
    except CancelledError:
        if client.status != "running":
            raise FileError("the cluster went away; finished work is kept") from None
        return True, None
