"""Parts of a throw, bob-weights, and the balance factor."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.running_gear.parts import (
    Parts,
    ThrowLoad,
    balance_factor,
    bob_weight_moments,
    factor_direction_g_mm,
)

PARTS = Parts(rotating_g=100.0, reciprocating_g=200.0, crankpin_g=10.0, rods=2)


def test_bob_weight_counts_every_rod_but_the_crankpin_once() -> None:
    assert PARTS.bob_weight_g(0.5) == 10.0 + 2 * (100.0 + 100.0)
    assert PARTS.bob_weight_g(0.0) == 210.0
    assert PARTS.reciprocating_on_throw_g == 400.0


@pytest.mark.parametrize("name", ["rotating_g", "reciprocating_g", "crankpin_g"])
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_impossible_masses_are_named(name: str, value: float) -> None:
    masses = {"rotating_g": 1.0, "reciprocating_g": 1.0, "crankpin_g": 1.0, name: value}
    with pytest.raises(ValueError, match=f"{name} is .* must be ≥ 0"):
        Parts(**masses)  # type: ignore[arg-type]  # rods keeps its default


def test_a_throw_without_rods_is_refused() -> None:
    with pytest.raises(ValueError, match="rods is 0"):
        Parts(1.0, 1.0, 1.0, rods=0)


def test_bob_weights_are_points_at_their_crankpins() -> None:
    moments = bob_weight_moments([ThrowLoad(PARTS, 30.0, math.pi / 2, 7.0)], 0.5)
    np.testing.assert_allclose(moments.first_g_mm, [0.0, 410.0 * 30.0, 410.0 * 7.0], atol=1e-9)
    assert moments.second_g_mm2[1, 2] == pytest.approx(410.0 * 30.0 * 7.0)


def test_throws_that_cancel_out_have_no_factor() -> None:
    throws = [ThrowLoad(PARTS, 30.0, angle, 0.0) for angle in (0.0, math.pi, math.pi, 0.0)]
    assert math.hypot(*factor_direction_g_mm(throws)) == pytest.approx(0.0, abs=1e-9)
    assert balance_factor(np.array([1.0, 0.0]), throws) is None
    assert balance_factor(np.array([1.0, 0.0]), []) is None


def test_throws_that_cancel_as_far_as_they_are_made_and_scanned_have_no_balance_factor() -> None:
    at = ((40.008, 0.0), (39.994, math.radians(180.02)), (39.997, math.radians(179.99)), (40.003, 0.0))
    throws = [ThrowLoad(PARTS, radius, angle, 90.0 * k) for k, (radius, angle) in enumerate(at)]
    assert balance_factor(np.array([2500.0, 2000.0]), throws) is None
