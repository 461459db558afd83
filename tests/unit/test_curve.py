"""Depth curves against functions whose integral is known."""

import math

import numpy as np
import pytest

from autobalance.correction.faces.layer import NODES, ROUGH_CHECK_SHARE, DepthCurve


def test_a_polynomial_is_exact_from_one_piece_also_above_its_first_sample() -> None:
    asked = []

    def sample(depth: float) -> np.ndarray:
        asked.append(depth)
        return np.array([3.0, depth**4])

    curve = DepthCurve(sample, 0.01, 5.0, np.ones(2), np.zeros(0))
    assert len(asked) == NODES[1]
    for depth in (0.0, 0.005, 1.3, 5.0):
        np.testing.assert_allclose(curve.value(depth), [3.0, depth**4], atol=1e-11)
        np.testing.assert_allclose(curve.integral(depth), [3.0 * depth, depth**5 / 5.0], atol=1e-11)


def test_a_draft_takes_few_samples() -> None:
    asked = []

    def sample(depth: float) -> np.ndarray:
        asked.append(depth)
        return np.array([2.0 + depth + 0.5 * depth**2])

    curve = DepthCurve(sample, 0.01, 5.0, np.ones(1), np.zeros(0))
    assert len(asked) == NODES[0]
    assert (min(asked), max(asked)) == (0.01, 5.0)
    assert curve.integral(3.0)[0] == pytest.approx(6.0 + 4.5 + 4.5, rel=1e-13)


def test_a_kink_that_is_told_is_exact() -> None:
    curve = DepthCurve(lambda d: np.array([abs(d - 1.1)]), 0.0, 2.0, np.ones(1), np.array([1.1]))
    assert curve.integral(2.0)[0] == pytest.approx(0.5 * (1.1**2 + 0.9**2), rel=1e-13)
    assert curve.value(1.6)[0] == pytest.approx(0.5, rel=1e-12)


def test_a_kink_that_is_not_told_is_closed_in_on() -> None:
    curve = DepthCurve(lambda d: np.array([math.sqrt(max(d - 1.23, 0.0))]), 0.0, 2.0, np.ones(1), np.zeros(0))
    assert curve.integral(2.0)[0] == pytest.approx(2.0 / 3.0 * 0.77**1.5, rel=2e-3)


def test_waves_of_a_rough_face_take_few_samples_and_keep_the_integral() -> None:
    asked = []

    def sample(depth: float) -> np.ndarray:
        asked.append(depth)
        return np.array([2.0 + depth + 3e-4 * math.sin(40.0 * depth)])

    curve = DepthCurve(sample, 0.0, 5.0, 7.0 * np.ones(1), np.zeros(0), ROUGH_CHECK_SHARE)
    assert len(asked) == NODES[0]
    assert curve.integral(5.0)[0] == pytest.approx(22.5, rel=1e-4)
