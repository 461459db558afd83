"""Whole engines: known zeros of usual layouts, and the factor that each is best served with."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from autobalance.engines.forces.factor_advice import advise
from autobalance.running_gear.loads import whole_turn
from autobalance.running_gear.parts import Parts
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import Cylinder, Engine, ForceOrder, inline, vee

CRANK = SliderCrank(43.0, 140.0)
PARTS = Parts(500.0, 450.0, 0.0)
SPEED = 600.0
PRIMARY_N = 450.0 * 43.0 * SPEED**2 * 1e-6
ZERO_N = 1e-9 * PRIMARY_N
ZERO_N_M = 1e-9 * PRIMARY_N
FACTORS = tuple(np.linspace(0.0, 1.0, 11))


def order(engine: Engine, number: float) -> ForceOrder:
    return next(found for found in engine.orders(SPEED) if found.order == number)


def degrees(*angles: float) -> list[float]:
    return [math.radians(angle) for angle in angles]


def test_inline_four_has_no_first_order_but_four_times_the_second() -> None:
    four = inline(degrees(0, 180, 180, 0), 90.0, CRANK, PARTS)
    assert order(four, 1).greatest_force_n < ZERO_N
    assert order(four, 1).greatest_moment_n_m < ZERO_N_M
    second = abs(CRANK.harmonics(2)[2]) * PRIMARY_N
    assert order(four, 2).greatest_force_n == pytest.approx(4.0 * second, rel=1e-12)
    assert order(four, 2).greatest_moment_n_m < ZERO_N_M
    assert order(four, 3).greatest_force_n < ZERO_N


def test_inline_six_has_no_force_or_moment_below_the_sixth_order() -> None:
    six = inline(degrees(0, 120, 240, 240, 120, 0), 90.0, CRANK, PARTS)
    for number in (1, 2, 3, 4, 5):
        assert order(six, number).greatest_force_n < ZERO_N
        assert order(six, number).greatest_moment_n_m < ZERO_N_M
    assert order(six, 6).greatest_force_n > 1e-4 * PRIMARY_N


def test_inline_three_has_a_first_order_moment_but_no_force() -> None:
    three = inline(degrees(0, 120, 240), 90.0, CRANK, PARTS)
    assert order(three, 1).greatest_force_n < ZERO_N
    assert order(three, 1).greatest_moment_n_m > 0.1 * PRIMARY_N


def test_cross_plane_v8_with_bob_weights_at_half_has_no_first_order_at_all() -> None:
    eight = vee(degrees(0, 90, 270, 180), 100.0, degrees(-45, 45), CRANK, PARTS)
    assert order(eight, 1).greatest_moment_n_m > 0.1 * PRIMARY_N
    balanced = eight.with_counterweights(0.5)
    for number in (1, 2):
        assert order(balanced, number).greatest_force_n < ZERO_N
    assert order(balanced, 1).greatest_moment_n_m < ZERO_N_M
    assert order(balanced.with_counterweights(0.4), 1).greatest_moment_n_m > 0.05 * PRIMARY_N


def test_v8_needs_its_rods_side_by_side_only_for_the_higher_moments() -> None:
    eight = vee(degrees(0, 90, 270, 180), 100.0, degrees(-45, 45), CRANK, PARTS, rod_pitch_mm=22.0)
    assert order(eight.with_counterweights(0.5), 1).greatest_force_n < ZERO_N


def boxer(*pairs: tuple[float, float]) -> Engine:
    """Pairs at (angle [deg], place [mm]): crankpins half a turn apart, pistons that move out together."""
    cylinders = [
        replace(vee(degrees(angle + bank), 0.0, degrees(bank), CRANK, PARTS).cylinders[0], z_mm=z + half)
        for angle, z in pairs
        for bank, half in ((0.0, -20.0), (180.0, 20.0))
    ]
    return Engine(tuple(cylinders))


def test_boxer_has_no_force_of_any_order() -> None:
    twin, four = boxer((0.0, 0.0)), boxer((0.0, -55.0), (180.0, 55.0))
    for engine in (twin, four):
        assert all(found.greatest_force_n < ZERO_N for found in engine.orders(SPEED))
    assert order(twin, 1).greatest_moment_n_m > 0.01 * PRIMARY_N
    assert order(four, 1).greatest_moment_n_m < ZERO_N_M
    assert order(four, 2).greatest_moment_n_m > 1e-4 * PRIMARY_N


def test_orders_add_up_to_the_force_over_the_angle() -> None:
    engine = vee(degrees(0, 90), 80.0, degrees(-30, 25), CRANK, PARTS).with_counterweights(0.3)
    turn = whole_turn(60)
    summed = sum(
        (found.force_n[None, :] * np.exp(1j * found.order * turn)[:, None]).real
        for found in engine.orders(SPEED, highest=24)
    )
    np.testing.assert_allclose(summed, engine.force_n(turn, SPEED), atol=1e-8 * PRIMARY_N)


def test_greatest_force_of_an_order_is_the_long_semi_axis() -> None:
    first = order(Engine((Cylinder(CRANK, 0.0, 450.0),)).with_counterweights(0.3), 1)
    turn = whole_turn(3600)
    force = (first.force_n[None, :] * np.exp(1j * turn)[:, None]).real
    assert first.greatest_force_n == pytest.approx(float(np.linalg.norm(force, axis=1).max()), rel=1e-6)
    assert first.circles_n == pytest.approx((0.2 * PRIMARY_N, 0.5 * PRIMARY_N))


def test_half_orders_of_inertia_are_nothing() -> None:
    found = inline([0.0], 0.0, CRANK, PARTS).orders(SPEED)
    assert [entry.order for entry in found] == [0.5 * number for number in range(1, 17)]
    assert all(entry.greatest_force_n == 0.0 for entry in found if entry.order % 1.0)


@pytest.mark.parametrize("banks", [(0.0,), (-45.0, 45.0), (-30.0, 30.0), (-22.5, 22.5), (0.0, 75.0, 140.0)])
def test_half_is_least_worst_on_one_crankpin_whatever_the_banks(banks: tuple[float, ...]) -> None:
    engine = vee([0.0], 0.0, degrees(*banks), CRANK, PARTS)
    assert advise(engine, SPEED, FACTORS).least_first_order == pytest.approx(0.5, abs=1e-12)
    greatest = [
        order(engine.with_counterweights(factor), 1).greatest_force_n for factor in np.linspace(0.0, 1.0, 101)
    ]
    assert int(np.argmin(greatest)) == 50
    slopes = np.diff(greatest)  # |forward| has the slope of all the reciprocating mass on either side
    np.testing.assert_allclose(np.abs(slopes), 0.01 * len(banks) * PRIMARY_N, rtol=1e-9)


def test_half_leaves_nothing_of_a_right_angled_twins_first_order() -> None:
    twin = vee([0.0], 0.0, degrees(-45, 45), CRANK, PARTS).with_counterweights(0.5)
    assert order(twin, 1).greatest_force_n < ZERO_N


def test_advice_for_a_single_shows_the_trade() -> None:
    single = inline([0.0], 0.0, CRANK, PARTS)
    advice = advise(single, SPEED, FACTORS)
    assert advice.least_transverse == pytest.approx(0.0, abs=1e-8)
    assert advice.rows[0].greatest_transverse_n < ZERO_N
    assert advice.rows[10].greatest_transverse_n == pytest.approx(PRIMARY_N, rel=1e-12)
    least = min(row.greatest_n for row in advice.rows)
    assert advice.least_greatest is not None
    best = advise(single, SPEED, [advice.least_greatest]).rows[0].greatest_n
    assert best <= least
    assert advice.rows[3].first_order_semi_axes_n == pytest.approx((0.7 * PRIMARY_N, 0.3 * PRIMARY_N))
    for row in advice.rows:
        assert row.rms_n <= row.greatest_n


def test_a_mount_soft_sideways_wants_a_lower_factor() -> None:
    single = inline([0.0], 0.0, CRANK, PARTS)
    stiff, even, soft = (advise(single, SPEED, [], weight).for_mount for weight in (0.0, 1.0, 3.0))
    assert stiff is not None
    assert even is not None
    assert soft is not None
    assert soft < even < stiff
    assert even == advise(single, SPEED, []).least_greatest


def test_a_turned_engine_gets_the_same_advice() -> None:
    straight = inline([0.0], 0.0, CRANK, PARTS)
    turned = vee([1.1], 0.0, [1.1], CRANK, PARTS)
    one, other = advise(straight, SPEED, [0.28], 2.0), advise(turned, SPEED, [0.28], 2.0)
    assert other.for_mount == pytest.approx(one.for_mount, abs=1e-6)
    assert other.rows[0].greatest_inline_n == pytest.approx(one.rows[0].greatest_inline_n)


def test_throws_that_cancel_out_have_no_best_factor() -> None:
    four = inline(degrees(0, 180, 180, 0), 90.0, CRANK, PARTS)
    advice = advise(four, SPEED, [])
    assert (advice.least_first_order, advice.least_greatest, advice.for_mount) == (None, None, None)


def test_errors_name_what_is_missing_or_wrong() -> None:
    with pytest.raises(ValueError, match="throw angles and bank angles are missing"):
        vee([], 100.0, [0.0], CRANK, PARTS)
    with pytest.raises(ValueError, match="throw angles and bank angles are missing"):
        vee([0.0], 100.0, [], CRANK, PARTS)
    with pytest.raises(ValueError, match=r"reciprocating_g is -1 g; must be ≥ 0"):
        Cylinder(CRANK, 1.0, -1.0)
    with pytest.raises(ValueError, match="small end weighs 2 g; must be between 0 and"):
        Cylinder(CRANK, 1.0, 1.0, small_end_g=2.0)
    with pytest.raises(ValueError, match="transverse weight of the mount is -1"):
        advise(inline([0.0], 0.0, CRANK, PARTS), SPEED, [], -1.0)


def test_firing_order_is_not_asked_for_but_places_matter() -> None:
    engine = inline(degrees(0, 120, 240), 90.0, CRANK, PARTS)
    shifted = Engine(tuple(replace(cylinder, z_mm=cylinder.z_mm + 50.0) for cylinder in engine.cylinders))
    one, other = order(engine, 1).greatest_moment_n_m, order(shifted, 1).greatest_moment_n_m
    assert one == pytest.approx(other)  # no resultant: the moment is a couple
