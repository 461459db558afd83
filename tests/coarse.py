"""Solids in fewer triangles, for tests that do not look at the triangles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from autobalance.report import plots
from autobalance.solid.cad import tessellation
from tests.sweeps import SWEPT

COARSE = {"SAG_SHARE": 2e-4, "TURN_RAD": 0.2}
"""A sixth of the triangles, with some 50 sides a circle."""
ROUGH = {"SAG_SHARE": 1e-3, "TURN_RAD": 0.5}
"""Some 15 sides a circle: enough where only true surfaces are measured."""
FINE = {"SAG_SHARE": 6e-5, "TURN_RAD": 0.12}
"""A third of the triangles: enough for what is measured on them to hold against the true surfaces."""
HALF_FINE = {"SAG_SHARE": 1.2e-4, "TURN_RAD": 0.16}
"""Between ``FINE`` and ``COARSE``, of which verify finds the load on a slug 0.2 % off."""


@contextmanager
def coarse_facets(fineness: Mapping[str, float] = COARSE) -> Iterator[None]:
    """Read STEP files in fewer triangles."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in fineness.items():
            patch.setattr(tessellation, name, value)
        yield


def roughen(patch: pytest.MonkeyPatch) -> None:
    """Draw plots in fewer pixels and without seeking room for labels; a sweep draws them as they are."""
    if not SWEPT:
        patch.setattr(plots, "LAYOUT", None)
        patch.setattr(plots, "PIXELS_PER_INCH", 12)


@cache
def bundled_corners(variant: str = "drafted", segments: int = 128, pin: bool = False) -> NDArray[np.float32]:
    """Return the corners (m, 3, 3) of a bundled crank, in fewer than its 512 segments."""
    from fixtures import make  # it solves for the dimensions: scipy takes its time to load

    size = replace(make.VARIANTS[variant][0](), segments=segments)
    return make.as_written(make.crank(size, pin=pin))[0]
