"""Couples: factors that are chosen by them, shafts that cancel them, and where moments are taken about."""

import math
from dataclasses import replace

import numpy as np
import pytest

from autobalance.engines.forces.factor_advice import advise
from autobalance.running_gear.loads import whole_turn
from autobalance.running_gear.parts import Parts
from autobalance.running_gear.shafts import (
    BalanceShaft,
    cancelling_shafts,
    couple_shafts,
    orders_with_shafts,
    place_of_least_moment_mm,
    second_order_pair,
)
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import Engine, ForceOrder, about, inline, vee
from tests.shafts import placed

SPEED = 600.0
CRANK, PARTS = SliderCrank(45.0, 144.0), Parts(500.0, 480.0, 0.0)
EXACT = 1e-9


def order_of(engine: Engine, number: float) -> ForceOrder:
    return next(order for order in engine.orders(SPEED) if order.order == number)


def shifted(engine: Engine, by_mm: float) -> Engine:
    cylinders = tuple(replace(each, z_mm=each.z_mm + by_mm) for each in engine.cylinders)
    return replace(engine, cylinders=cylinders)


def v8() -> Engine:
    angles = [math.radians(each) for each in (0.0, 90.0, 270.0, 180.0)]
    return vee(angles, 110.0, [-math.pi / 4.0, math.pi / 4.0], CRANK, PARTS)


def inline_three() -> Engine:
    return inline([math.radians(each) for each in (0.0, 240.0, 120.0)], 100.0, CRANK, PARTS)


def test_a_v8_chooses_its_factor_by_the_couple() -> None:
    """A cross-plane 90° V8 has no first-order force; its couple falls in line with the factor."""
    advice = advise(v8(), SPEED, [0.0, 0.25, 0.5])
    assert advice.least_first_order is None
    couples = [row.first_order_moment_n_m for row in advice.rows]
    assert couples[0] > 100.0
    assert couples[1] == pytest.approx(0.5 * couples[0], rel=1e-6)
    assert couples[2] < 1e-6 * couples[0]
    assert advice.least_moment == pytest.approx(0.5, abs=1e-3)
    assert advice.least_in_planes == pytest.approx(0.5, abs=1e-3)


def test_an_inline_four_has_no_factor_that_is_better() -> None:
    advice = advise(inline([0.0, math.pi, math.pi, 0.0], 90.0, CRANK, PARTS), SPEED, [0.0, 1.0])
    assert advice.least_first_order is advice.least_moment is advice.least_in_planes is None


def test_the_moment_over_the_turn_is_its_orders() -> None:
    engine, about_mm = shifted(inline_three(), 35.0), 12.0
    angle = whole_turn(720)
    exact = engine.moment_n_m(angle, SPEED, about_mm)
    orders = about(engine.orders(SPEED, 24), about_mm)
    summed = sum((np.exp(1j * order.order * angle)[:, None] * order.moment_n_m).real for order in orders)
    np.testing.assert_allclose(exact, summed, atol=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize("by_mm", [0.0, 70.0])
def test_an_exact_lanchester_pair_leaves_no_force_and_no_moment(by_mm: float) -> None:
    """Task 5, Eq. 5.28, for four cylinders: an eighth of the second order on each shaft, at their middle."""
    four = shifted(inline([0.0, math.pi, math.pi, 0.0], 90.0, CRANK, PARTS), by_mm)
    pair = placed(second_order_pair(4.0 * PARTS.reciprocating_g, CRANK.crank_radius_mm, CRANK.rod_length_mm))
    before = order_of(four, 2.0)
    assert place_of_least_moment_mm(before) == pytest.approx(by_mm, abs=1e-9)
    (left,) = orders_with_shafts([before], [replace(shaft, z_mm=by_mm) for shaft in pair], SPEED)
    assert left.greatest_force_n < 1e-3 * before.greatest_force_n  # the series of A₂ ends
    shafts = [replace(shaft, z_mm=by_mm) for shaft in cancelling_shafts(before, SPEED)]
    (none,) = about(orders_with_shafts([before], shafts, SPEED), by_mm)
    assert none.greatest_force_n < EXACT * before.greatest_force_n
    assert none.greatest_moment_n_m < EXACT * before.greatest_force_n


def test_couple_shafts_take_the_couple_of_an_inline_three() -> None:
    three = inline_three().with_counterweights(0.0)
    for number in (1.0, 2.0):
        before = order_of(three, number)
        assert before.greatest_force_n < EXACT * 1e4
        assert before.greatest_moment_n_m > 1.0
        shafts: list[BalanceShaft] = []
        for shaft in couple_shafts(before, SPEED):
            low, high = shaft.between(-150.0, 130.0)
            assert low.product_g_mm == high.product_g_mm == pytest.approx(shaft.couple_g_mm2 / 280.0)
            shafts += [low, high]
        (left,) = orders_with_shafts([before], shafts, SPEED)
        assert left.greatest_moment_n_m < EXACT * before.greatest_moment_n_m
        assert left.greatest_force_n < 1e-6
