"""What two solids have more than each other, also where the kernel drops metal."""

import numpy as np
import pytest

from autobalance.solid.csg import difference
from autobalance.solid.csg.difference import common, differences
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.types import Array

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


class Dropping(Solid):
    """A solid whose first booleans lose half of what they find, as the kernel may, wherever it is put."""

    calls: list[int]
    honest_after: int

    @classmethod
    def of(cls, solid: Solid, honest_after: int, calls: list[int] | None = None) -> "Dropping":
        made = cls(solid._body)
        made.calls, made.honest_after = [] if calls is None else calls, honest_after
        return made

    def moved(self, placement: Array) -> "Dropping":
        return Dropping.of(super().moved(placement), self.honest_after, self.calls)

    def __sub__(self, other: Solid) -> Solid:
        return self._halved(super().__sub__(other))

    def split(self, other: Solid) -> tuple[Solid, Solid]:
        inside, outside = super().split(other)
        return self._halved(inside), outside

    def built_anew(self) -> Solid:
        return self

    def _halved(self, found: Solid) -> Solid:
        self.calls.append(1)
        if len(self.calls) > self.honest_after or found.volume_mm3 < 1e-6:
            return found
        return found.above(float(found.moments(1.0).centre_mm[2]))


@pytest.mark.parametrize("turns", [1, 2, 4])
def test_metal_that_is_dropped_is_looked_for_in_another_position(turns: int) -> None:
    block = Dropping.of(BLOCK, 2 * turns)
    went, came = differences(block, Dropping.of(NOTCHED, 2 * turns, block.calls))
    assert len(block.calls) == min(2 * turns + 2, 2 + 2 * len(difference.TURNS))
    if turns <= len(difference.TURNS):
        assert went.volume_mm3 == pytest.approx(1.0, rel=1e-9)
        assert went.moments(1.0).centre_mm == pytest.approx(np.array([3.5, 0.5, 4.5]), abs=1e-12)
        assert came.volume_mm3 < 1e-12


@pytest.mark.parametrize("tries", [0, 1, 3])
def test_what_is_dropped_of_a_common_part_is_looked_for_anew(tries: int) -> None:
    block = Dropping.of(BLOCK, tries)
    shared = common(block, Solid.prism(Region.rectangle([3.0, -1.0], [9.0, 1.0]), 4.0, 9.0))
    assert len(block.calls) == tries + 1
    assert shared.volume_mm3 == pytest.approx(1.0, rel=1e-9)
    assert shared.moments(1.0).centre_mm == pytest.approx(np.array([3.5, 0.5, 4.5]), abs=1e-12)


def test_solids_apart_have_nothing_in_common() -> None:
    assert common(BLOCK, Solid.prism(Region.rectangle([9.0, 0.0], [10.0, 1.0]), 0.0, 1.0)).is_empty
