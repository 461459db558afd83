"""What holds for all tests: which are slow is measured, by ``make times``; Ctrl-C counts."""

from __future__ import annotations

import gc
import os
import signal
import tempfile
import threading
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from _pytest.doctest import DoctestModule

from tests.coarse import roughen
from tests.read_once import FOLDER_VARIABLE, read_once
from tests.shaken import shaken

collect_ignore = ["freecad"]
"""Run by FreeCAD: make freecad."""
LISTED = Path(__file__).with_name("slow.txt")
"""Functions of which a test took a quarter of a second of processor time or more."""
os.environ["AUTOBALANCE_CACHE_MB"] = "0"
"""Tests read everything anew, in children too, and leave the user's cache alone, but for `read_once`."""
TIMES = os.environ.get("AUTOBALANCE_TIMES")
"""File that the seconds of each test are added to, where it is given."""
LONGEST_S = 900
"""Seconds that a test may take; the longest takes 40 on a quiet machine."""
SHAKEN = os.environ.get("AUTOBALANCE_SHAKEN")
"""Seed of the last digits of every plan, where it is given (see tests/shaken.py)."""


class Examples:
    """Seeks examples where the package has some: to load and look through all modules takes long.

    A plugin: the hooks of this file hold for the tests' folder alone.
    """

    @pytest.hookimpl(wrapper=True)
    def pytest_collect_file(
        self, file_path: Path
    ) -> Generator[None, list[pytest.Collector], list[pytest.Collector]]:
        collectors = yield
        if "tests" not in file_path.parts and b">>> " in file_path.read_bytes():
            return collectors
        return [each for each in collectors if not isinstance(each, DoctestModule)]


def pytest_configure(config: pytest.Config) -> None:
    """Let Ctrl-C count, here and in children, also where a shell began the tests in the background."""
    config.pluginmanager.register(Examples())
    if "PYTEST_XDIST_WORKER" not in os.environ:  # workers have it from the process that begins them
        folder = tempfile.TemporaryDirectory(prefix="autobalance-tests-")
        os.environ[FOLDER_VARIABLE] = folder.name
        config.add_cleanup(folder.cleanup)
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    if ignored and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what is listed, beside what is marked in its own file."""
    listed = frozenset(LISTED.read_text(encoding="utf-8").split())
    for item in items:
        if item.nodeid.partition("[")[0] in listed:
            item.add_marker(pytest.mark.slow)


def pytest_collection_finish() -> None:
    """Let the collector of garbage pass over what was loaded: a look at all tests takes it half a second."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def rough_plots(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw in a third of the time, where no test looks at places and pixels."""
    roughen(monkeypatch)


@pytest.fixture(scope="module")
def cranks_read_once() -> Iterator[None]:
    """Read and recognise each crank once, for modules that are about what follows and patch none of that."""
    with read_once():
        yield


@pytest.fixture(scope="session", autouse=SHAKEN is not None)
def all_shaken() -> Iterator[None]:
    """Make every plan with other last digits."""
    with shaken(int(SHAKEN or 0)):
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    """Fail a test that does not end: a pipe waited for once cost a whole run, and nothing named it."""
    if not hasattr(signal, "SIGALRM") or threading.current_thread() is not threading.main_thread():
        return (yield)

    def too_long(number: int, frame: object) -> None:
        pytest.fail(f"{item.nodeid} did not end within {LONGEST_S} s")

    before = signal.signal(signal.SIGALRM, too_long)
    signal.alarm(LONGEST_S)
    try:
        return (yield)
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Write down what a test takes of the processor, its children's included."""
    before = sum(os.times()[:4])
    result = yield
    if TIMES is not None:
        with Path(TIMES).open("a", encoding="utf-8") as file:
            file.write(f"{sum(os.times()[:4]) - before:.2f} {item.nodeid}\n")
    return result
