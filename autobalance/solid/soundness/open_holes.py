"""Which holes of an open mesh are to be closed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class OpenHoles:
    """What to do with holes of a mesh: close those up to ``fill_mm`` wide; ``keep_open`` are bores' places.

    ``keep_open`` None: nobody said which rims are bores; empty: none is.
    """

    fill_mm: float = 0.0
    keep_open: tuple[tuple[float, float, float], ...] | None = None
