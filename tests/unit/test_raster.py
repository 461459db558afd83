"""A region on a grid: what it says of boxes for sure is true, and points inside are told apart at once."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.correction.faces.depth_limit import Cover
from autobalance.solid.csg.region import Region
from autobalance.solid.slicing.independent import Raster


def ring() -> Region:
    """A disc with a hole off its middle, and an island in the hole."""
    hole = Region.circle(12.0, 90, (4.0, -3.0))
    return (Region.circle(30.0, 200) - hole) + Region.circle(5.0, 40, (4.0, -3.0))


@pytest.mark.parametrize("cells", [32, 256])
def test_boxes_are_inside_or_outside_for_sure(cells: int) -> None:
    region = ring()
    raster = Raster.of(region.polygons, cells)
    rng = np.random.default_rng(1)
    low = rng.uniform(-35.0, 35.0, (3000, 2))
    high = low + rng.uniform(0.01, 3.0, (3000, 2))
    held, met = raster.holds(low, high), raster.meets(low, high)
    assert held.sum() > 200
    assert (~met).sum() > 200
    for some, full in ((np.flatnonzero(held), True), (np.flatnonzero(~met), False)):
        for row in some[:60].tolist():
            box = Region.rectangle(low[row].tolist(), high[row].tolist())
            shared = (box & region).area_mm2
            assert shared == pytest.approx(box.area_mm2 if full else 0.0, abs=1e-9)


def test_points_inside_are_told_from_those_outside() -> None:
    points = np.random.default_rng(2).uniform(-35.0, 35.0, (5000, 2))
    x, y = points.T
    off = np.hypot(x - 4.0, y + 3.0)
    inside = (np.hypot(x, y) < 30.0) & ((off > 12.0) | (off < 5.0))
    clear = np.min([abs(np.hypot(x, y) - 30.0), abs(off - 12.0), abs(off - 5.0)], axis=0) > 0.05
    assert (ring().contains(points)[clear] == inside[clear]).all()


@pytest.mark.parametrize("size", [6.0, 0.3])
def test_how_many_triangles_share_an_area(size: float) -> None:
    """Whether they are few and cut to the outline, or many and told by corners and middle."""
    region = ring()
    x, y = (
        each.reshape(-1) for each in np.meshgrid(np.arange(-45.0, 45.0, size), np.arange(-45.0, 45.0, size))
    )
    corner = np.stack([x, y], axis=1)
    triangles = corner[:, None] + np.array([[0.0, 0.0], [size, 0.0], [0.0, size]])
    triangles = triangles[np.random.default_rng(3).permutation(len(triangles))]
    half = 0.5 * region.area_mm2
    count = Cover(region, triangles).area_over(0.5 * half)
    assert count is not None
    shared = (Region.of(list(triangles[:count])) & region).area_mm2
    assert shared == pytest.approx(0.5 * half, abs=0.5 * size**2 + 2e-3 * half)
    assert Cover(region, triangles).area_over(2.0 * half) is None
