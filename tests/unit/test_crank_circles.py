"""Circles in outlines, exact at any number of facets, whatever is cut out of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.crank.recognition.circles import corners_of, fit_circle, whole_circle
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid
from autobalance.solid.slicing.slices import cross_sections
from autobalance.types import Array

GRAIN_MM = 1e-5


def outline(region: Region) -> Array:
    (polygon,) = region.polygons
    return polygon


@pytest.mark.parametrize("segments", [8, 12, 100, 4000])
def test_a_polygon_on_a_circle_is_that_circle(segments: int) -> None:
    found = whole_circle(outline(Region.circle(20.0, segments, (3.0, -4.0))), GRAIN_MM)
    assert found is not None
    assert found.radius == pytest.approx(20.0, abs=1e-7)
    assert found.centre == pytest.approx([3.0, -4.0], abs=1e-7)


@pytest.mark.parametrize("segments", [3, 4, 6, 7])
def test_seven_corners_are_no_circle(segments: int) -> None:
    assert whole_circle(outline(Region.circle(20.0, segments)), GRAIN_MM) is None


def test_points_along_the_facets_do_not_count() -> None:
    corners = outline(Region.circle(20.0, 12))
    share = np.linspace(0.0, 1.0, 17)[:-1, None]
    following = np.roll(corners, -1, axis=0)
    fine = np.concatenate([a + share * (b - a) for a, b in zip(corners, following, strict=True)])
    assert len(corners_of(fine, GRAIN_MM)) == 12
    found = whole_circle(fine, GRAIN_MM)
    assert found is not None
    assert found.radius == pytest.approx(20.0, abs=1e-6)


def test_a_keyway_and_a_flat_are_overlooked() -> None:
    shaft = Region.circle(20.0, 60) - Region.rectangle([15.0, -3.0], [30.0, 3.0])
    shaft = shaft - Region.rectangle([-30.0, -30.0], [-18.5, 30.0])
    found = whole_circle(outline(shaft), GRAIN_MM)
    assert found is not None
    assert found.radius == pytest.approx(20.0, abs=1e-6)
    assert found.centre == pytest.approx([0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize(
    "shape",
    [
        Region.rectangle([-10.0, -10.0], [10.0, 10.0]),
        Region.circle(20.0, 60) + Region.circle(10.0, 60, (18.0, 0.0)),  # a cam
        Region.circle(20.0, 60) + Region.rectangle([0.0, -3.0], [30.0, 3.0]),  # something stands out
    ],
)
def test_other_outlines_are_no_circle(shape: Region) -> None:
    assert whole_circle(outline(shape), GRAIN_MM) is None


def test_an_ellipse_is_no_circle() -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, 200, endpoint=False)
    assert whole_circle(np.stack([20.0 * np.cos(angle), 18.0 * np.sin(angle)], axis=1), GRAIN_MM) is None


def test_a_circle_is_fitted_exactly_to_part_of_it() -> None:
    angle = np.linspace(0.1, 1.4, 9)
    points = 5.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1) + [100.0, -50.0]
    centre, radius = fit_circle(points)
    assert radius == pytest.approx(5.0, abs=1e-8)
    assert centre == pytest.approx([100.0, -50.0], abs=1e-8)


def test_sections_have_the_area_of_the_solids_slices() -> None:
    ring = Region.circle(30.0, 24) - Region.circle(10.0, 24, (5.0, 0.0))
    solid = Solid.prism(ring, 0.0, 10.0) + Solid.prism(Region.circle(8.0, 24, (18.0, 0.0)), 0.0, 25.0)
    heights = np.array([0.0, 3.0, 10.0, 10.5, 24.999, 25.0])
    sections = cross_sections(solid.mesh.vertices, solid.mesh.triangles, heights)
    for height, outlines in zip(heights, sections, strict=True):
        area = 0.0
        for x, y in (points.T for points in outlines):
            area += 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
        just_below = solid.section(height - 1e-6).area_mm2  # a corner on the plane counts as above it
        assert area == pytest.approx(just_below, abs=1e-4)
    assert [len(outlines) for outlines in sections] == [0, 2, 2, 1, 1, 1]
