"""Outlines without the corners that stand in line."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.solid.csg.region import Region
from autobalance.solid.slicing.slices import FEW_CORNERS, thinned
from autobalance.types import Array

SQUARE = np.array([[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]])


def divided(corners: Array, parts: int) -> Array:
    """Return an outline with each side in so many parts."""
    share = np.arange(parts)[:, None] / parts
    ends = np.roll(corners, -1, axis=0)
    return np.concatenate([a + share * (b - a) for a, b in zip(corners, ends, strict=True)])


@pytest.mark.parametrize("parts", [8, 9, 100, 1001])
@pytest.mark.parametrize("first", [0, 1, 5])
def test_corners_in_line_go_and_the_others_stay(parts: int, first: int) -> None:
    noise = np.random.default_rng(parts).normal(scale=1e-7, size=(4 * parts, 2))
    outline = np.roll(divided(SQUARE, parts) + noise, first, axis=0)
    left = thinned(outline, 2e-6)
    assert len(left) <= max(FEW_CORNERS, 8)
    for corner in SQUARE:
        assert np.linalg.norm(left - corner, axis=1).min() < 1e-6
    assert Region.of([left]).area_mm2 == pytest.approx(600.0, abs=1e-4)


@pytest.mark.parametrize("corners", [17, 500, 20_000])
def test_a_finely_drawn_circle_stays_a_circle(corners: int) -> None:
    radius, within = 40.0, 1e-5
    angle = 2.0 * math.pi * np.arange(corners) / corners
    circle = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    left = thinned(circle, within)
    chord = np.linalg.norm(np.roll(left, -1, axis=0) - left, axis=1)
    drawn = np.linalg.norm(circle[1] - circle[0])
    sag = (chord**2 - drawn**2) / (8.0 * radius)
    assert sag.max() < 8.0 * within
    assert (len(left) < corners) == (drawn**2 / (2.0 * radius) < within)
    assert {*map(tuple, left.tolist())} <= {*map(tuple, circle.tolist())}
