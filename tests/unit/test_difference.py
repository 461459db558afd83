"""What two solids have more than each other, also where the kernel drops metal."""

import numpy as np
import pytest

from autobalance.solid.csg import difference
from autobalance.solid.csg.difference import differences
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid

BLOCK = Solid.prism(Region.rectangle([0.0, 0.0], [4.0, 3.0]), 0.0, 5.0)
NOTCHED = BLOCK - Solid.prism(Region.rectangle([3.0, -1.0], [9.0, 1.0]), 4.0, 9.0)
BOSS = NOTCHED + Solid.prism(Region.rectangle([1.0, 1.0], [2.0, 2.0]), 4.5, 6.0)


def test_both_differences_are_boxes() -> None:
    went, came = differences(BLOCK, BOSS)
    assert went.volume_mm3 == pytest.approx(1.0, rel=1e-12)
    assert went.bounds == pytest.approx(np.array([[3.0, 0.0, 4.0], [4.0, 1.0, 5.0]]), abs=1e-12)
    assert came.volume_mm3 == pytest.approx(1.0, rel=1e-12)
    assert came.bounds == pytest.approx(np.array([[1.0, 1.0, 5.0], [2.0, 2.0, 6.0]]), abs=1e-12)
    assert differences(BLOCK, BLOCK)[0].is_empty


@pytest.mark.parametrize("turns", [1, 2, 4])
def test_metal_that_is_dropped_is_looked_for_in_another_position(
    turns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    honest, calls = Solid.__sub__, [0]

    def drops(one: Solid, other: Solid) -> Solid:
        calls[0] += 1
        left = honest(one, other)
        if calls[0] > 2 * turns or left.volume_mm3 < 1e-6:
            return left
        return left.above(float(left.moments(1.0).centre_mm[2]))

    monkeypatch.setattr(Solid, "__sub__", drops)
    went, came = differences(BLOCK, NOTCHED)
    assert calls[0] == min(2 * turns + 2, 2 + 2 * len(difference.TURNS))
    if turns <= len(difference.TURNS):
        assert went.volume_mm3 == pytest.approx(1.0, rel=1e-9)
        assert went.moments(1.0).centre_mm == pytest.approx(np.array([3.5, 0.5, 4.5]), abs=1e-12)
        assert came.volume_mm3 < 1e-12
