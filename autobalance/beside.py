"""Work that goes on beside other work.

numpy and hashlib let go of the interpreter while they go through large arrays, so that two threads of such
work take little longer than the longer one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from concurrent.futures import Future

T = TypeVar("T")


def beside(work: Callable[[], T]) -> Future[T]:
    """Start ``work`` in a thread of its own; its result, or what it raised, is the future's."""
    from concurrent.futures import ThreadPoolExecutor

    threads = ThreadPoolExecutor(max_workers=1)
    future = threads.submit(work)
    threads.shutdown(wait=False)  # the thread ends with its work
    return future
