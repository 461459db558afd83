"""Solids with true surfaces in fewer triangles, for tests that do not look at the triangles."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from autobalance.solid.cad import tessellation

COARSE = {"SAG_SHARE": 2e-4, "TURN_RAD": 0.2}
"""A tenth of the triangles, with some 50 sides a circle."""


@contextmanager
def coarse_facets() -> Iterator[None]:
    """Read STEP files in fewer triangles."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in COARSE.items():
            patch.setattr(tessellation, name, value)
        yield
