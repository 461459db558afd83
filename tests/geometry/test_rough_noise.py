"""Standard errors of fitted cylinders, against errors of simulated ones whose neighbours err alike."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.crank.recognition.rough_fits import (
    Fit,
    Noise,
    WeightedPoints,
    fit_circle_along_z,
    fit_line,
    fit_plane,
    noise_of,
)
from autobalance.types import Array

SIGMA_MM, WHITE_SHARE, EDGE_MM = 0.02, 0.1, 2.5
TWIN = ((-80.0, 20.0, 20.0, 0.0), (-40.0, 20.0, 18.0, 30.0), (0.0, 20.0, 20.0, 0.0), (80.0, 20.0, 20.0, 0.0))
SINGLE = ((-42.0, 24.0, 15.0, 0.0), (0.0, 22.0, 16.0, 29.0), (42.0, 24.0, 15.0, 0.0))
"""Cylinders of a crank: z of the middle, width, radius, distance from the axis [mm]."""

Cylinders = tuple[tuple[float, float, float, float], ...]


def _field(points: Array, reach_mm: float, rng: np.random.Generator) -> Array:
    """Return errors of standard deviation 1 whose correlation is exp(−½ (distance / reach)²)."""
    total = np.zeros(len(points))
    for way, phase in zip(
        rng.normal(size=(96, 3)) / reach_mm, rng.uniform(0.0, 2.0 * math.pi, 96), strict=True
    ):
        total += np.cos(points @ way + phase)
    return total * math.sqrt(2.0 / 96)


def _scanned(cylinders: Cylinders, reaches_mm: tuple[float, ...], seed: int) -> tuple[Fit, list[Fit]]:
    """Return the fits of the main journals' axis, and of every cylinder."""
    rng = np.random.default_rng(seed)
    ideal = []
    for z, width, radius, aside in cylinders:
        count = int(2.0 * math.pi * radius * width / EDGE_MM**2 * 2.0 / math.sqrt(3.0))
        angle = rng.uniform(0.0, 2.0 * math.pi, count)
        height = rng.uniform(z - 0.5 * width, z + 0.5 * width, count)
        outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
        ideal.append(
            (radius * outward + np.stack([0.0 * angle + aside, 0.0 * angle, height], axis=1), outward)
        )
    points = np.concatenate([place for place, _ in ideal])
    waves = sum(_field(points, reach, rng) for reach in reaches_mm) / math.sqrt(len(reaches_mm))
    move = math.sqrt(1.0 - WHITE_SHARE) * waves + math.sqrt(WHITE_SHARE) * rng.normal(size=len(points))
    ends = np.cumsum([len(place) for place, _ in ideal])[:-1]
    regions = [
        WeightedPoints(place + SIGMA_MM * off[:, None] * outward, np.ones(len(place)))
        for (place, outward), off in zip(ideal, np.split(move, ends), strict=True)
    ]
    starts = [(np.array([aside, 0.0]), radius) for _, _, radius, aside in cylinders]
    mains = [number for number, each in enumerate(cylinders) if each[3] == 0.0]
    line = fit_line([regions[number] for number in mains], [starts[number] for number in mains])
    return line, [fit_circle_along_z(region, *start) for region, start in zip(regions, starts, strict=True)]


@pytest.mark.parametrize("reaches_mm", [(3.0,), (3.0, 20.0), (20.0,), (40.0,)])
@pytest.mark.parametrize("cylinders", [SINGLE, TWIN], ids=["single", "twin"])
def test_an_axis_is_off_by_its_standard_errors(cylinders: Cylinders, reaches_mm: tuple[float, ...]) -> None:
    """Waves that are longer than a journal move it most, and show least on it."""
    ratios = []
    for seed in range(12):
        line, fits = _scanned(cylinders, reaches_mm, seed)
        ratios.append(line.values[:4] / np.sqrt(np.diag(noise_of(fits).of(line))[:4]))
    assert 0.35 < float(np.sqrt(np.mean(np.square(ratios)))) < 1.15
    assert float(np.abs(ratios).max()) < 3.0


def test_the_noise_of_surfaces_without_residual_is_none() -> None:
    line, fits = _scanned(SINGLE, (3.0,), 0)
    still = [Fit(fit.values, fit.rows, fit.weights, 0.0 * fit.residuals, fit.points) for fit in fits]
    assert not np.any(noise_of(still).of(line))
    assert isinstance(noise_of([]), Noise)


def test_a_plane_goes_through_most_of_its_area_where_most_points_stand_off_it() -> None:
    """A drawn face has few corners for much area; the rim of a groove beside it has many for little."""
    rng = np.random.default_rng(5)
    face = np.column_stack([rng.uniform(-20.0, 20.0, (40, 2)), np.full(40, 7.0)])
    face[:, 2] += 1e-3 * face[:, 0] - 2e-3 * face[:, 1]
    angle = rng.uniform(0.0, 2.0 * math.pi, 400)
    rim = np.column_stack([12.0 * np.cos(angle), 12.0 * np.sin(angle), np.full(400, 7.04)])
    rim[:, 2] += 1e-3 * rim[:, 0] - 2e-3 * rim[:, 1]
    fit = fit_plane(WeightedPoints(np.concatenate([face, rim]), np.repeat([40.0, 0.01], [40, 400])))
    assert len(fit.points) == 40
    assert fit.values[1:] == pytest.approx([1e-3, -2e-3], abs=1e-9)
    assert np.abs(fit.residuals).max() < 1e-9
    middle = fit.weights @ fit.points / fit.weights.sum()
    assert middle[2] == pytest.approx(7.0 + 1e-3 * middle[0] - 2e-3 * middle[1], abs=1e-9)
