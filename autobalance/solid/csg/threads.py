"""Number of threads that booleans use."""

from __future__ import annotations

import os
from contextlib import suppress

SEGMENTS = 128
"""A sphere of so many segments is large enough for the kernel to ask how many threads it may have."""


def booleans_in_one_thread() -> None:
    """Limit booleans to this thread, in a process that is one of many; call before the first of them.

    The kernel has no setting for it: it asks the system once, at its first large solid, how many cores the
    process may use. So it asks while this process may use one. Where a process cannot be kept to a core
    (outside Linux) nothing changes.
    """
    import manifold3d as m3

    with suppress(AttributeError, OSError):
        cores = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {min(cores)})
        try:
            m3.Manifold.sphere(1.0, SEGMENTS).volume()
        finally:
            os.sched_setaffinity(0, cores)
