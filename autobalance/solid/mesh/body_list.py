"""How bodies of a file are listed in one line."""

from __future__ import annotations

from collections.abc import Sequence

LISTED_BODIES = 12
"""Bodies that are listed, the largest."""


def few(entries: Sequence[str]) -> str:
    """Return entries in one line, the first of them where they are many."""
    more = len(entries) - LISTED_BODIES
    return "; ".join(entries[:LISTED_BODIES]) + (f"; and {more} smaller ones" if more > 0 else "")


def listed(entries: Sequence[str]) -> str:
    """Say how many bodies a file holds, and which."""
    count = "1 body" if len(entries) == 1 else f"{len(entries)} bodies"
    return f"the file holds {count} ({few(entries)})"
