"""``--progress json``: all of standard error is JSON, one object a line; ending a command takes no 2 s."""

from __future__ import annotations

import argparse
import io
import json
import os
import signal
import subprocess
import sys
import threading
import time
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Any

import pytest

from autobalance.command.main import full_parser
from autobalance.command.objects import Objects
from autobalance.registry import functions
from tests import jobs
from tests.test_cli_warnings import shift_one_half

JSON = ("--progress", "json")


def objects(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


def test_progress_is_objects_whose_share_ends_at_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = jobs.bundled_job(tmp_path)
    assert jobs.run("balance", job, "-o", tmp_path / "out", "--only", "json", *JSON) == 0
    found = objects(capsys.readouterr().err)
    stages = [each for each in found if "stage" in each]
    shares = [each["share"] for each in stages]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert all(set(each) == {"stage", "share", "elapsed_s"} for each in stages)
    times = [each["elapsed_s"] for each in stages]
    assert times == sorted(times)
    assert any(each["stage"].startswith("cutting") for each in stages)


def test_a_warning_is_an_object(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    jobs.bundled_job(tmp_path, "straight")
    shift_one_half(tmp_path / "crank.stl", 0.02)
    assert jobs.run("inspect", tmp_path / "crank.stl", "--no-crankpin", "--unit", "mm", *JSON) == 0
    warnings = [each["warning"] for each in objects(capsys.readouterr().err) if "warning" in each]
    assert any("not coaxial" in each for each in warnings)
    assert not any(each.startswith("autobalance") for each in warnings)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("balance", "gone.toml"), 3),
        (("balance", "gone.toml", "--nonsense"), 2),
        (("inspect",), 2),
        (("verify", "gone.json"), 3),
    ],
)
def test_a_failure_is_an_object_with_its_exit_code(
    words: tuple[str, ...], code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    assert jobs.run(*words, "--progress=json") == code
    found = objects(capsys.readouterr().err)
    assert found[-1]["exit"] == code
    assert found[-1]["error"]
    assert not any(each.get("share") == 1.0 for each in found)


def test_two_threads_never_let_the_share_fall() -> None:
    """One that was slow to look at the clock must not report after one that is farther."""
    stream, late = io.StringIO(), threading.Event()

    def clock() -> float:
        if threading.current_thread() is not threading.main_thread():
            late.set()
            time.sleep(0.05)
        return time.monotonic()

    out = Objects(stream, clock)
    slow = threading.Thread(target=out, args=("planning", 0.2))
    slow.start()
    assert late.wait(5.0)
    out("cutting", 0.6)
    slow.join()
    found = objects(stream.getvalue())
    assert [each["share"] for each in found] == [0.2, 0.6]
    assert found[0]["elapsed_s"] <= found[1]["elapsed_s"]


def test_every_verb_with_progress_takes_it() -> None:
    (commands,) = (each for each in full_parser()._actions if isinstance(each, argparse._SubParsersAction))
    shown = {verb for verb, parser in commands.choices.items() if "--progress {" in parser.format_help()}
    modules = {verb: import_module(f"autobalance.{module}") for verb, module in functions().items()}
    long = {verb for verb, each in modules.items() if "progress" in signature(getattr(each, verb)).parameters}
    assert {"demo", *long} <= shown


HELD = """
import ctypes, sys
from autobalance.balancing import loop
from autobalance.command import main

library, lock = ctypes.CDLL(None), ctypes.create_string_buffer(256)
library.pthread_mutex_init(lock, None)

def held(*arguments):
    print("held", flush=True, file=sys.__stdout__)
    for _ in range(2):  # the second for ever: no signal is heard
        library.pthread_mutex_lock(lock)

loop.cut_and_measure = held
sys.exit(main())
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals to one process need POSIX")
def test_a_command_that_a_library_holds_speaks_on_and_ends_in_time(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path)
    with subprocess.Popen(
        [sys.executable, "-c", HELD, "balance", str(job), "-o", str(tmp_path / "out"), *JSON],
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])},
    ) as process:
        assert process.stderr is not None
        lines: list[tuple[float, str]] = []
        for line in process.stderr:
            lines.append((time.monotonic(), line))
            if "cutting" in line and sum("cutting" in each for _, each in lines) == 4:
                break
        process.send_signal(signal.SIGTERM)
        sent = time.monotonic()
        rest = process.stderr.read()
        assert process.wait(timeout=30) == 130
        assert time.monotonic() - sent < 2.0
    assert max(b - a for (a, _), (b, _) in zip(lines[-4:], lines[-3:], strict=False)) < 1.5
    assert objects(rest)[-1] == {"error": "interrupted; nothing half-written was left", "exit": 130}
    assert not (tmp_path / "out").exists()
