"""Slider-crank: exact motion against finite differences and transforms; each error fires."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.running_gear.slider_crank import SliderCrank, harmonic_coefficient, harmonic_series
from autobalance.types import Array

STEP = 1e-5
"""Of central differences; their error is about STEP² times the third derivative."""
ANGLES = np.linspace(0.0, 2.0 * math.pi, 37)


@pytest.mark.parametrize("offset", [0.0, 10.0, -7.0])
def test_derivatives_are_those_of_the_position(offset: float) -> None:
    crank = SliderCrank(44.9, 152.0, offset)
    here, before, after = (crank.motion(ANGLES + step) for step in (0.0, -STEP, STEP))

    def slope(of_after: Array, of_before: Array) -> Array:
        result: Array = (of_after - of_before) / (2.0 * STEP)
        return result

    np.testing.assert_allclose(slope(after.x_mm, before.x_mm), here.dx_mm, atol=1e-7)
    np.testing.assert_allclose(slope(after.dx_mm, before.dx_mm), here.ddx_mm, atol=1e-7)
    np.testing.assert_allclose(
        slope(after.rod_sine, before.rod_sine), here.rod_cosine * here.dtilt, atol=1e-9
    )
    np.testing.assert_allclose(slope(after.dtilt, before.dtilt), here.ddtilt, atol=1e-9)


@pytest.mark.parametrize("offset", [0.0, 10.0, -7.0])
def test_rod_keeps_its_length(offset: float) -> None:
    crank = SliderCrank(44.9, 152.0, offset)
    motion = crank.motion(ANGLES)
    across = offset - 44.9 * motion.crank_sine
    np.testing.assert_allclose(np.hypot(motion.x_mm - 44.9 * motion.crank_cosine, across), 152.0, rtol=1e-14)


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.3, 0.45, 0.6])
def test_series_is_the_transform_of_the_exact_acceleration(ratio: float) -> None:
    count = 4096
    motion = SliderCrank(ratio, 1.0).motion(2.0 * math.pi * np.arange(count) / count)
    transformed = np.fft.rfft(-motion.ddx_mm / ratio) / (count / 2)
    series = SliderCrank(ratio, 1.0).harmonics(16)
    np.testing.assert_allclose(series, transformed[:17], rtol=0.0, atol=1e-10)


def test_offset_harmonics_add_up_to_the_exact_acceleration() -> None:
    crank = SliderCrank(44.9, 152.0, 10.0)
    harmonics = crank.harmonics(60)
    summed = (harmonics[None, :] * np.exp(1j * np.outer(ANGLES, np.arange(61)))).real.sum(axis=1)
    np.testing.assert_allclose(-44.9 * summed, crank.motion(ANGLES).ddx_mm, atol=1e-9)


def test_small_offset_reduces_to_none() -> None:
    np.testing.assert_allclose(
        SliderCrank(44.9, 152.0, 1e-9).harmonics(8), SliderCrank(44.9, 152.0).harmonics(8), atol=1e-10
    )


def test_dead_centres_are_where_the_piston_stands_still() -> None:
    crank = SliderCrank(44.9, 152.0, 10.0)
    motion = crank.motion(np.array(crank.dead_centres_rad))
    np.testing.assert_allclose(motion.dx_mm, 0.0, atol=1e-12)
    assert float(motion.x_mm[0] - motion.x_mm[1]) == pytest.approx(crank.stroke_mm, rel=1e-14)


def test_speed_is_greatest_at_its_angles() -> None:
    crank = SliderCrank(44.9, 152.0, 10.0)
    down, up = crank.greatest_speed_angles_rad
    speed = crank.motion(np.linspace(0.0, 2.0 * math.pi, 100001)).dx_mm
    at = crank.motion(np.array([down, up])).dx_mm
    assert float(at[0]) == pytest.approx(float(speed.min()), rel=1e-8)
    assert float(at[1]) == pytest.approx(float(speed.max()), rel=1e-8)


@pytest.mark.parametrize(("length", "offset"), [(40.0, 0.0), (44.9, 0.0), (50.0, 6.0), (math.nan, 0.0)])
def test_a_rod_too_short_is_refused(length: float, offset: float) -> None:
    with pytest.raises(
        ValueError, match=r"rod length is .* must be more than crank radius and offset together"
    ):
        SliderCrank(44.9, length, offset)


@pytest.mark.parametrize("radius", [0.0, -1.0, math.nan])
def test_a_crank_radius_must_be_positive(radius: float) -> None:
    with pytest.raises(ValueError, match=r"crank radius is .* must be > 0"):
        SliderCrank(radius, 152.0)


@pytest.mark.parametrize("order", [0, 1, 3])
def test_odd_orders_have_no_series(order: int) -> None:
    with pytest.raises(ValueError, match="even orders from 2"):
        harmonic_series(order, 1)


@pytest.mark.parametrize("ratio", [1.0, -0.1, math.nan])
def test_ratio_is_crank_radius_over_rod_length(ratio: float) -> None:
    with pytest.raises(ValueError, match="below 1"):
        harmonic_coefficient(2, ratio)
