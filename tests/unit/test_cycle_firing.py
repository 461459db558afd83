"""Firing angles, the counterweight of least reaction, and the pendulum absorber."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from autobalance.engines.cycle.factors import (
    best_counterweight,
    best_counterweight_at,
    smallest_circle,
)
from autobalance.engines.cycle.firing import dead_centres_rad, firing_as_given, firing_in_order
from autobalance.engines.cycle.model import Pendulum
from autobalance.engines.cycle.speed import run_up_s
from autobalance.running_gear.loads import loads, whole_turn
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import Cylinder, Engine
from autobalance.types import Array, Complex

FOUR = 4.0 * math.pi


def degrees(angles: list[float]) -> list[float]:
    return [round(math.degrees(angle), 6) for angle in angles]


def test_dead_centres_with_bank_throw_and_offset() -> None:
    crank = SliderCrank(40.0, 140.0, 6.0)
    top = math.degrees(crank.dead_centres_rad[0])
    cylinders = [
        Cylinder(crank, 1.0, 1.0, throw_angle_rad=math.radians(throw), bank_rad=math.radians(bank))
        for throw, bank in ((0.0, 0.0), (90.0, 0.0), (0.0, 45.0))
    ]
    assert degrees(dead_centres_rad(cylinders)) == pytest.approx([top, 270.0 + top, 45.0 + top], abs=1e-6)
    for each, at in zip(cylinders, dead_centres_rad(cylinders), strict=True):
        turned = at + each.throw_angle_rad - each.bank_rad + np.linspace(-0.1, 0.1, 201)
        assert int(np.argmax(crank.position_mm(turned))) == 100


@pytest.mark.parametrize(
    ("tops", "order", "expected"),
    [
        ([0, 180, 180, 0], [1, 3, 4, 2], [0, 540, 180, 360]),
        ([0, 180, 180, 0], [2, 4, 3, 1], [540, 180, 900 - 360, 0]),
        ([0, 120, 240, 240, 120, 0], [1, 5, 3, 6, 2, 4], [0, 480, 240, 600, 120, 360]),
        ([0, 90], [1, 2], [0, 450]),
        ([315, 45], [1, 2], [315, 45 + 720 - 360 - 360 + 360]),
    ],
)
def test_an_order_gives_the_most_even_intervals(
    tops: list[float], order: list[int], expected: list[float]
) -> None:
    found = degrees(firing_in_order([math.radians(top) for top in tops], order, FOUR))
    assert sorted(each % 360.0 for each in found) == sorted(top % 360.0 for top in tops)
    first = found[order[0] - 1]
    assert 0.0 <= first < 360.0
    after = [(found[number - 1] - first) % 720.0 for number in order]
    assert after == sorted(after)
    if order == [2, 4, 3, 1]:
        assert after == [0.0, 180.0, 360.0, 540.0]
    elif tops == [315, 45]:
        assert after == [0.0, 450.0]
    else:
        assert found == expected


@pytest.mark.parametrize("seed", range(6))
def test_the_intervals_are_least_by_brute_force(seed: int) -> None:
    draw = np.random.default_rng(seed)
    count = int(draw.integers(3, 7))
    tops = draw.uniform(0.0, 2.0 * math.pi, count)
    order = [1, *(2 + draw.permutation(count - 1)).tolist()]
    best = math.inf
    for turns in itertools.product((0, 1), repeat=count - 1):
        after = [0.0]
        for number, turn in zip(order[1:], turns, strict=True):
            after.append((tops[number - 1] - tops[0]) % (2.0 * math.pi) + 2.0 * math.pi * turn)
        if after == sorted(after):
            best = min(best, sum(np.diff([*after, FOUR]) ** 2))
    if math.isinf(best):
        with pytest.raises(ValueError, match="no dead centres of these cylinders follow each other"):
            firing_in_order(tops.tolist(), order, FOUR)
        return
    found = np.array(firing_in_order(tops.tolist(), order, FOUR))
    later = np.sort((found - tops[0]) % FOUR)
    assert sum(np.diff([*later, FOUR]) ** 2) == pytest.approx(best)


def test_a_dead_centre_a_hair_before_zero_fires_at_zero() -> None:
    found = firing_in_order([-1e-7, math.pi + 1e-7], [1, 2], 2.0 * math.pi)
    assert found == pytest.approx([0.0, math.pi], abs=1e-6)


@pytest.mark.parametrize(
    ("order", "text"),
    [
        ([1, 3, 4], r"misses 2; must name each of 4 cylinders once"),
        ([1, 3, 4, 4, 2], "names a cylinder twice"),
        ([1, 3, 4, 5], "misses 2"),
    ],
)
def test_an_order_that_misses_a_cylinder_is_refused(order: list[int], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        firing_in_order([0.0, math.pi, math.pi, 0.0], order, FOUR)


def test_two_strokes_keep_an_order_or_refuse_it() -> None:
    tops = [0.0, math.radians(120.0), math.radians(240.0)]
    assert degrees(firing_in_order(tops, [2, 3, 1], 2.0 * math.pi)) == [0.0, 120.0, 240.0]
    with pytest.raises(ValueError, match="follow each other so in a cycle of 360°"):
        firing_in_order(tops, [1, 3, 2], 2.0 * math.pi)


def test_given_angles_are_brought_to_dead_centre() -> None:
    tops = [0.0, math.radians(182.0)]
    assert degrees(firing_as_given(tops, [math.radians(720.0), math.radians(540.0)], FOUR)) == [0.0, 542.0]
    with pytest.raises(ValueError, match="has 90° for cylinder 2, whose top dead centres lie at 182°"):
        firing_as_given(tops, [0.0, 0.5 * math.pi], FOUR)
    with pytest.raises(ValueError, match="has 1 angles; expected one for each of 2 cylinders"):
        firing_as_given(tops, [0.0], FOUR)


# --- smallest circle ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_the_smallest_circle_agrees_with_brute_force(seed: int) -> None:
    draw = np.random.default_rng(seed)
    points: Complex = draw.normal(size=24) + 1j * draw.normal(size=24) * 0.3
    found = smallest_circle(points)
    assert np.abs(points - found.centre).max() == pytest.approx(found.radius, rel=1e-12)
    centres = [0.5 * (a + b) for a, b in itertools.combinations(points, 2)]
    for a, b, c in itertools.combinations(points, 3):  # where the bisectors of two sides meet
        sides = np.array([[(b - a).real, (b - a).imag], [(c - a).real, (c - a).imag]])
        at = np.linalg.solve(sides, 0.5 * np.sum(sides**2, axis=1))
        centres.append(a + complex(at[0], at[1]))
    reach = np.abs(points[None, :] - np.array(centres)[:, None]).max(axis=1)
    assert found.radius == pytest.approx(float(reach.min()), rel=1e-12)


def test_circles_of_few_points_and_of_a_line() -> None:
    assert smallest_circle(np.array([2.0 + 1.0j])).radius == 0.0
    line = smallest_circle(np.array([k * (0.5 + 0.5j) for k in range(9)]))
    assert line.centre == pytest.approx(2.0 + 2.0j)
    assert line.radius == pytest.approx(2.0 * math.sqrt(2.0))
    right = smallest_circle(np.array([0.0, 2.0, 2.0j], dtype=np.complex128))
    assert right.centre == pytest.approx(1.0 + 1.0j)
    assert right.radius == pytest.approx(math.sqrt(2.0))
    equal = smallest_circle(np.exp(2j * math.pi * np.arange(3) / 3))
    assert abs(equal.centre) == pytest.approx(0.0, abs=1e-12)
    assert equal.radius == pytest.approx(1.0)


def test_pure_inertia_is_balanced_by_half() -> None:
    engine = Engine((Cylinder(SliderCrank(26.9, 1e6), 134.04, 261.5),))
    angle, speed = whole_turn(720), 900.0
    load = loads(engine, [-40.0, 40.0], speed, angle).crankpin_n[0]
    best = best_counterweight(load[:, 0] + 1j * load[:, 1], angle, speed)
    assert math.cos(best.angle_rad) == pytest.approx(-1.0)
    factor = (best.product_g_mm - 134.04 * 26.9) / (261.5 * 26.9)
    assert factor == pytest.approx(0.5, abs=1e-4)
    assert best.greatest_n == pytest.approx(0.5 * 261.5 * 26.9 * speed**2 * 1e-6, rel=1e-4)
    facing = best_counterweight_at(load[:, 0] + 1j * load[:, 1], angle, speed, math.pi)
    assert facing.product_g_mm == pytest.approx(best.product_g_mm, rel=1e-6)
    worse = best_counterweight_at(load[:, 0] + 1j * load[:, 1], angle, speed, 0.0)
    assert worse.product_g_mm == 0.0


@pytest.mark.parametrize("place", [2.0, 3.0])
def test_an_allowed_direction_is_searched_as_brute_force_does(place: float) -> None:
    draw = np.random.default_rng(4)
    angle = whole_turn(360)
    load = 900.0 * np.exp(1j * angle) + draw.normal(size=360) * 300.0 + 200.0j * draw.normal(size=360)
    found = best_counterweight_at(load, angle, 500.0, place)
    products = np.linspace(0.0, 2e4, 20001)
    pull = products * 500.0**2 * 1e-6 * np.exp(1j * place)
    left = np.abs(load[None, :] * np.exp(-1j * angle)[None, :] + pull[:, None]).max(axis=1)
    assert found.greatest_n == pytest.approx(float(left.min()), abs=0.3)
    assert found.product_g_mm == pytest.approx(float(products[left.argmin()]), abs=2.0)


# --- pendulum and run-up ------------------------------------------------------------------------------------


def test_a_pendulum_is_as_long_as_order_squared_says() -> None:
    for order in (0.5, 1.5, 2.0, 3.0):
        assert Pendulum(order, 60.0).length_mm == pytest.approx(60.0 / order**2)
    with pytest.raises(ValueError, match="order of the pendulum is 0"):
        Pendulum(0.0, 60.0)


@pytest.mark.parametrize("swing_deg", [5.0, 60.0])
@pytest.mark.parametrize("path", ["circular", "epicycloidal"])
def test_the_order_of_a_swing_is_that_of_its_motion(swing_deg: float, path: str) -> None:
    """The mass in the field of the centrifugal force, integrated."""
    pendulum = Pendulum(1.5, 60.0, path)  # type: ignore[arg-type]
    swing = math.radians(swing_deg)

    def motion(_: float, state: Array) -> Array:
        pull = math.sin(state[0]) if path == "circular" else state[0]
        return np.array([state[1], -(pendulum.distance_mm / pendulum.length_mm) * pull])

    def at_rest(_: float, state: Array) -> float:
        return float(state[1])

    at_rest.direction = -1.0  # type: ignore[attr-defined]
    run = solve_ivp(motion, (0.0, 9.0), [swing, 0.0], rtol=1e-10, atol=1e-12, events=at_rest)
    assert run.t_events is not None
    back = next(at for at in run.t_events[0] if at > 0.1)
    assert pendulum.order_at(swing) == pytest.approx(2.0 * math.pi / back, rel=1e-6)


def test_a_pendulum_takes_the_torque_its_mass_was_asked_for() -> None:
    pendulum, speed, swing = Pendulum(2.0, 60.0), 300.0, 0.05
    mass = pendulum.mass_g(25.0, swing, speed)
    angle = np.linspace(0.0, math.pi, 4001)
    phi = swing * np.sin(2.0 * angle)
    rho = np.array([60.0 + 15.0 * np.cos(phi), 15.0 * np.sin(phi)])
    # Angular momentum of the mass about the crank axis; its rate is the torque, mean Ω kept.
    spin = np.gradient(phi, angle)
    arm = rho[0] ** 2 + rho[1] ** 2 + (15.0**2 + 60.0 * 15.0 * np.cos(phi)) * spin
    torque = mass * speed**2 * np.gradient(arm, angle) * 1e-9
    second = 2.0 * np.mean(torque[:-1] * np.exp(-2j * angle[:-1]))
    assert abs(second) == pytest.approx(25.0, rel=3e-3)
    assert pendulum.inertia_g_mm2(mass) == pytest.approx(mass * 75.0**2)
    assert Pendulum(2.0, 60.0, "epicycloidal").widest_swing_rad == pytest.approx(
        75.0 / (2.0 * 5.0**0.5) / 15.0
    )


def test_run_up_is_the_integral_of_inertia_over_torque() -> None:
    speeds = np.linspace(100.0, 500.0, 5)
    even = run_up_s(lambda _: 20.0, 4e6, speeds)
    assert even == pytest.approx((speeds - 100.0) * 4e-3 / 20.0)
    dragged = run_up_s(lambda speed: 30.0 - 0.05 * speed, 4e6, speeds)
    assert dragged is not None
    assert dragged[-1] == pytest.approx(4e-3 / 0.05 * math.log(25.0 / 5.0), rel=1e-6)
    assert run_up_s(lambda speed: 30.0 - 0.1 * speed, 4e6, speeds) is None
