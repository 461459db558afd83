"""Temporary files of killed runs: cleared by the next into the same folder, unless their run still lives."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from autobalance.report.files import Staging, _began_s, _machine

pytestmark = pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="Linux tells when processes began"
)


def left_by(process: int, folder: Path, age_s: float = 0.0) -> Path:
    path = folder / f".balanced.stl.{_machine()}-{process}-0123abcd.part"
    path.write_bytes(b"half")
    os.utime(path, (time.time() - age_s,) * 2)
    return path


def test_a_process_began_when_it_was_started() -> None:
    before = time.time()
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as process:
        began = _began_s(process.pid)
        process.kill()
    assert began is not None
    assert before - 0.1 < began < time.time() + 0.1
    assert _began_s(2**22 + 1) is None


def test_only_files_of_living_runs_stay(tmp_path: Path) -> None:
    """A number that a new process was given, our own too, is no sign of life for a file from before it."""
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as living:
        of_living = left_by(living.pid, tmp_path)
        of_ours = left_by(os.getpid(), tmp_path, age_s=90_000.0)
        of_reused = left_by(os.getppid(), tmp_path, age_s=900_000_000.0)
        other = tmp_path / ".notes.part"
        other.write_bytes(b"not ours")
        with Staging([tmp_path]) as staging:
            staging.add(tmp_path / "report.json", b"{}")
            staging.commit()
        living.kill()
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        [of_living.name, other.name, "report.json"]
    )
    assert not of_ours.exists()
    assert not of_reused.exists()
