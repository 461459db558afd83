"""Cranks of equal files are read, recognised and looked at once, where tests are about what follows.

A few cranks stand in hundreds of tests. What reading, recognition and the look at facets return follows from
the bytes of the file and the keys of the job: the tests share the program's own cache, in a folder of the run
for each fineness of facets, also with the processes that they start. Their own tests, and sweeps, do it anew.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from autobalance.disk_cache import LIMIT_VARIABLE
from autobalance.solid.cad import tessellation
from autobalance.solid.chordal_error import of_mesh
from autobalance.user_folders import CACHE_VARIABLE
from tests.sweeps import SWEPT

LIMIT_MB = 2000
FOLDER_VARIABLE = "AUTOBALANCE_TESTS_CACHE"
"""Folder of the caches of a run of tests, which its workers share."""


@contextmanager
def read_once() -> Iterator[None]:
    """Share what was read, as long as facets are as fine and as many of them are looked at."""
    settings = tessellation.SAG_SHARE, tessellation.TURN_RAD, of_mesh.FACETS_MOST
    folder = Path(os.environ[FOLDER_VARIABLE]) / "-".join(map(str, settings))
    with pytest.MonkeyPatch.context() as patch:
        if not SWEPT:
            patch.setenv(LIMIT_VARIABLE, str(LIMIT_MB))
            patch.setenv(CACHE_VARIABLE, str(folder))
        yield
