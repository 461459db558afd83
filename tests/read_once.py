"""Cranks of equal files are read, recognised and looked at once, where tests are about what follows.

Two bundled cranks stand in hundreds of tests. What reading, recognition and the look at facets return is
frozen and follows from the bytes of the file and the keys of the job: tests can share it, in any order.
Their own tests, and sweeps, do all of it anew.
"""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext

from autobalance.known import Known, using
from autobalance.solid.cad import tessellation
from autobalance.solid.chordal_error import of_mesh
from tests.sweeps import SWEPT

KNOWN = Known()


def read_once() -> AbstractContextManager[None]:
    """Share what was read, as long as facets are as fine and as many of them are looked at."""
    settings = tessellation.SAG_SHARE, tessellation.TURN_RAD, of_mesh.FACETS_MOST
    return nullcontext() if SWEPT else using(KNOWN, settings)
