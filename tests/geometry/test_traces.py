"""What is read off the metal of a cut: flaps, thinner than rounding but wide, do not hide its planes."""

from typing import Any, cast

import numpy as np
import pytest

from autobalance.correction.trace import Metal
from autobalance.solid.csg.solid import Region, Solid, union

NEAR_MM = 6e-5


def block(width_mm: float, low_mm: float, high_mm: float) -> Solid:
    half = 0.5 * width_mm
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    return Solid.prism(Region.of([square]), low_mm, high_mm)


@pytest.mark.parametrize("up", [1.0, -1.0])
@pytest.mark.parametrize("flap_mm", [0.0, 1e-5, 5e-5])
def test_a_wide_flap_hides_neither_floor_nor_cheek(up: float, flap_mm: float) -> None:
    cut = block(10.0, 0.0, 4.0)
    if flap_mm:
        cut = union([cut, block(60.0, 0.0, flap_mm)])
    metal = Metal((cut,), 7.85e-3, cast(Any, None), None, 0.0, NEAR_MM)
    height, moments = metal.facing(np.array([0.0, 0.0, up]))
    assert height == pytest.approx(4.0 if up > 0.0 else 0.0, abs=1e-9)
    if up > 0.0:
        assert moments.mass_g == pytest.approx(100.0, rel=1e-9)
