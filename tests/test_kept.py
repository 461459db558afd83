"""Nothing is left of a run of the tests that is killed: no app, no browser, no worker."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.jobs import ROOT
from tests.report.browser import missing

pytestmark = pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="needs /proc")

WAITS = """
import sys, time
from pathlib import Path
from tests.kept import kept
script = "import subprocess, sys; subprocess.run(['sleep', sys.argv[1]])"
with kept([sys.executable, "-c", script, sys.argv[1]]):
    print("ready", flush=True)
    time.sleep(60)
"""
SHOWS = """
import sys, time
from pathlib import Path
from tests.report.browser import browser
from tests.web_app.serving import served
folder = Path(sys.argv[1])
with served(folder / "project") as app, browser(folder / "profile") as window:
    window.call("POST", "/url", {"url": app.address})
    print("ready", flush=True)
    time.sleep(60)
"""


def running(word: str) -> list[int]:
    """Return the processes that were called with a word, this one left out."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal() and int(entry.name) != os.getpid():
            with contextlib.suppress(OSError):
                if word.encode() in (entry / "cmdline").read_bytes():
                    found.append(int(entry.name))
    return found


def until(holds: Callable[[], bool], most_s: float = 30.0) -> bool:
    end = time.monotonic() + most_s
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    return holds()


def killed(script: str, word: str, least: int) -> list[int]:
    """Run a script that says when it is ready, kill it, and return what is left of what it began."""
    command = [sys.executable, "-c", script, word]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        assert until(lambda: len(running(word)) >= least)
        process.send_signal(signal.SIGKILL)
    until(lambda: not running(word))
    return running(word)


def test_what_a_killed_run_began_ends_with_it() -> None:
    assert killed(WAITS, f"61.{os.getpid()}", 3) == []


@pytest.mark.skipif(bool(missing()), reason=f"needs {missing()}")
def test_no_app_and_no_browser_is_left_of_a_killed_run(tmp_path: Path) -> None:
    assert killed(SHOWS, str(tmp_path), 4) == []
