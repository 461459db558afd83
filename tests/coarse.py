"""Solids with true surfaces in fewer triangles, for tests that do not look at the triangles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import pytest

from autobalance.solid.cad import tessellation

COARSE = {"SAG_SHARE": 2e-4, "TURN_RAD": 0.2}
"""A sixth of the triangles, with some 50 sides a circle."""
FINE = {name: getattr(tessellation, name) for name in COARSE}


@contextmanager
def coarse_facets(fineness: Mapping[str, float] = COARSE) -> Iterator[None]:
    """Read STEP files in fewer triangles, or within this with ``FINE`` as ever."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in fineness.items():
            patch.setattr(tessellation, name, value)
        yield
