"""Solids with true surfaces in fewer triangles, for tests that do not look at the triangles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import pytest

from autobalance.solid.cad import tessellation

COARSE = {"SAG_SHARE": 2e-4, "TURN_RAD": 0.2}
"""A sixth of the triangles, with some 50 sides a circle."""
FINE = {"SAG_SHARE": 6e-5, "TURN_RAD": 0.12}
"""A third of the triangles: enough for what is told from them to hold against the true surfaces."""


@contextmanager
def coarse_facets(fineness: Mapping[str, float] = COARSE) -> Iterator[None]:
    """Read STEP files in fewer triangles."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in fineness.items():
            patch.setattr(tessellation, name, value)
        yield
