"""Calls of the program's own functions, seen or interrupted where they happen; nothing is replaced."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import CodeType, FrameType
from typing import Any


@contextmanager
def watched(*functions: Callable[..., Any], tell: Callable[[str, dict[str, Any]], None]) -> Iterator[None]:
    """Tell of each call of some functions in this thread: its name, and its arguments by theirs."""
    codes: dict[CodeType, str] = {each.__code__: each.__name__ for each in functions}

    def look(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and frame.f_code in codes:
            tell(codes[frame.f_code], dict(frame.f_locals))

    before = sys.getprofile()
    sys.setprofile(look)
    try:
        yield
    finally:
        sys.setprofile(before)


@contextmanager
def calls_of(function: Callable[..., Any]) -> Iterator[list[dict[str, Any]]]:
    """List the arguments of each call of a function in this thread."""
    listed: list[dict[str, Any]] = []
    with watched(function, tell=lambda _, arguments: listed.append(arguments)):
        yield listed


@contextmanager
def interrupted_in(function: Callable[..., Any]) -> Iterator[None]:
    """Let Ctrl-C be pressed when a function has just been called."""

    def press(*_: object) -> None:
        raise KeyboardInterrupt

    with watched(function, tell=press):
        yield
