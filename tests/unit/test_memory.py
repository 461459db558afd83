"""Freed memory serves the next array: its pages are not asked of the system again."""

import subprocess
import sys

import pytest

AGAIN = """
import resource
from threading import Thread
import numpy as np
from autobalance.runtime import keep_freed_memory

KEEP = {keep}
assert not KEEP or keep_freed_memory()
np.ones(1 << 23)  # 64 MB, once
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(5):
    np.ones(1 << 23)
    thread = Thread(target=np.ones, args=(1 << 22,))
    thread.start()
    thread.join()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="glibc's allocator")
def test_pages_are_kept_and_serve_every_thread() -> None:
    faults = {
        keep: int(
            subprocess.run(
                [sys.executable, "-c", AGAIN.format(keep=keep)], capture_output=True, check=True
            ).stdout
        )
        for keep in (False, True)
    }
    assert faults[True] < 100
    assert faults[True] < faults[False]


def test_elsewhere_nothing_is_set(monkeypatch: pytest.MonkeyPatch) -> None:
    from autobalance.runtime import keep_freed_memory

    monkeypatch.setattr(sys, "platform", "win32")
    assert not keep_freed_memory()
