"""How the C library deals with the memory of large arrays."""

from __future__ import annotations

import sys

TRIM_THRESHOLD, MMAP_THRESHOLD, ARENA_MAX = -1, -3, -8
"""Parameters of glibc's ``mallopt`` (malloc.h)."""
KEPT_BYTES = 1 << 30
"""Freed memory, and arrays, up to this size stay with the process."""


def keep_freed_memory() -> bool:
    """Let the memory of an array that is gone serve the next one; return whether that can be set here.

    By default glibc gives every array of some megabytes back to the system at once and asks for the next one
    anew, whose pages then cost more to provide than the arithmetic on them; and it gives every thread memory
    of its own. The peak stays nearly the same.
    """
    if sys.platform != "linux":
        return False
    import ctypes

    try:
        set_option = ctypes.CDLL(None).mallopt
    except AttributeError:  # another C library
        return False
    options = {MMAP_THRESHOLD: KEPT_BYTES, TRIM_THRESHOLD: KEPT_BYTES, ARENA_MAX: 1}
    return all(set_option(option, value) == 1 for option, value in options.items())
