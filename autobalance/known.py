"""Results used again: while a `Known` is in use, equal questions of a process are answered once.

Nothing is kept unless a caller asks for it, as the tests do; what is kept is frozen.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeVar

KEPT_OF_A_KIND = 24
"""Results kept of each kind: solids of some megabytes."""
T = TypeVar("T")


class Known:
    """The latest results of each kind, with what their keys stand for: no identity is used twice."""

    def __init__(self) -> None:
        self._by_kind: dict[str, OrderedDict[Hashable, tuple[object, Any]]] = {}

    def once(self, kind: str, key: Hashable, of: object, work: Callable[[], T]) -> T:
        """Return what ``work`` returns, or returned for the same kind and key before."""
        kept = self._by_kind.setdefault(kind, OrderedDict())
        if key not in kept:
            kept[key] = of, work()
        kept.move_to_end(key)
        result: T = kept[key][1]
        while len(kept) > KEPT_OF_A_KIND:
            kept.popitem(last=False)
        return result


_IN_USE: ContextVar[tuple[Known, Hashable] | None] = ContextVar("known", default=None)


@contextmanager
def using(known: Known, settings: Hashable = None) -> Iterator[None]:
    """Use results again within a block; ``settings`` is what they depend on beside their keys."""
    token = _IN_USE.set((known, settings))
    try:
        yield
    finally:
        _IN_USE.reset(token)


def once(kind: str, key: Callable[[], Hashable], of: object, work: Callable[[], T]) -> T:
    """Return what ``work`` returns, or what is known; ``of`` is kept alive where the key has its identity."""
    if (in_use := _IN_USE.get()) is None:
        return work()
    known, settings = in_use
    return known.once(kind, (key(), settings), of, work)
