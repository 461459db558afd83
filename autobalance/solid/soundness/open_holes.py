"""Permission to close holes of an open mesh."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class OpenHoles:
    """Treatment of a mesh's holes: close those up to ``fill_mm`` wide; ``keep_open`` are bores' places.

    ``keep_open`` None: it is unknown which rims are bores; empty: none is.
    """

    fill_mm: float = 0.0
    keep_open: tuple[tuple[float, float, float], ...] | None = None
