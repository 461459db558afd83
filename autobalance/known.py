"""Cache of results: while a `Known` is in use, equal requests of a process are computed once.

Nothing is kept unless a caller asks for it, as the tests do; kept results are frozen.
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
    """Cache of the latest results of each kind, with the objects behind their keys: no identity recurs."""

    def __init__(self) -> None:
        self._by_kind: dict[str, OrderedDict[Hashable, tuple[object, Any]]] = {}

    def once(self, kind: str, key: Hashable, of: object, work: Callable[[], T]) -> T:
        """Return the result of ``work``, or the kept one of the same kind and key."""
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
    """Reuse results within a block; ``settings`` are their dependencies beside their keys."""
    token = _IN_USE.set((known, settings))
    try:
        yield
    finally:
        _IN_USE.reset(token)


def once(kind: str, key: Callable[[], Hashable], of: object, work: Callable[[], T]) -> T:
    """Return the result of ``work``, or a kept one; ``of`` is kept alive where the key has its identity."""
    if (in_use := _IN_USE.get()) is None:
        return work()
    known, settings = in_use
    return known.once(kind, (key(), settings), of, work)
