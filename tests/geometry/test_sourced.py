"""What a solid shares with several small ones: the share of each, and whose surface is where on it."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.solid.csg.shape import shared_with
from autobalance.solid.csg.solid import Solid


def box(low: list[float], high: list[float]) -> Solid:
    return Solid.box(np.array(low), np.array(high))


TWO_HORNS = box([0, 0, 0], [10, 10, 10]) - box([4, -1, 5], [6, 11, 11])
ACROSS = box([-1, 0, 9], [11, 10, 12])
"""Takes the tips of both."""
CORNER = box([0, 0, 0], [2, 2, 2])
BESIDE = box([1, 1, 1], [3, 3, 3])
"""Overlaps the one at the corner."""


@pytest.mark.parametrize("tools", [[ACROSS], [ACROSS, CORNER], [ACROSS, CORNER, BESIDE]])
def test_each_tool_gets_what_it_shares(tools: list[Solid]) -> None:
    for tool, found in zip(tools, shared_with(TWO_HORNS, tools), strict=True):
        expected = TWO_HORNS & tool
        assert found.solid.volume_mm3 == pytest.approx(expected.volume_mm3, rel=1e-12)
        np.testing.assert_array_equal(found.solid.bounds, expected.bounds)


def test_whose_surface_is_where() -> None:
    (found, _) = shared_with(TWO_HORNS, [ACROSS, CORNER])
    mesh, by_tool = found.surfaces
    assert mesh.part(by_tool).bounds[:, 2].tolist() == [9.0, 9.0]
    assert 0.5 * mesh.doubled_areas[by_tool].sum() == pytest.approx(2 * 4 * 10.0)
