"""List of a file's bodies in one line."""

from __future__ import annotations

from collections.abc import Sequence

LISTED_BODIES = 12
"""Most bodies that are listed, the largest."""


def few(entries: Sequence[str]) -> str:
    """Return entries in one line, the first ``LISTED_BODIES`` and a count of the others."""
    more = len(entries) - LISTED_BODIES
    return "; ".join(entries[:LISTED_BODIES]) + (f"; and {more} smaller ones" if more > 0 else "")


def listed(entries: Sequence[str]) -> str:
    """Return a sentence on the number of a file's bodies, with their entries."""
    count = "1 body" if len(entries) == 1 else f"{len(entries)} bodies"
    return f"the file holds {count} ({few(entries)})"
