"""Orders, maps, cuts and cycles of records whose orders are known."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.signals.by_angle import Turning, by_angle, circles, samples_per_turn
from autobalance.signals.speed import crossings, order_cuts, order_lines, order_map, waterfall
from tests.signals import TURN, Array, channel, instants, orders_of, ramp, turning

RATE = 5000.0
CONTENT = {0.5: (0.2, 1.0), 1.0: (1.0, 0.5), 5.5: (0.03, -2.0), 12.0: (0.1, 3.0)}


def _run_up() -> tuple[Array, Array, Turning]:
    t = instants(12.0, RATE)
    angle = ramp(t, 10.0, 38.0)
    return t, angle, turning(t, angle)


def test_orders_of_a_run_up_are_exact() -> None:
    _, angle, course = _run_up()
    lines = order_lines(channel(0.3 + orders_of(angle, CONTENT), RATE), course, 12.0)
    assert lines is not None
    assert lines.turns == 2 * int(angle[-1] / (2.0 * TURN))
    expected = np.zeros(24, dtype=complex)
    for order, (amplitude, phase) in CONTENT.items():
        expected[round(2 * order) - 1] = amplitude * np.exp(1j * phase)
    assert lines.amplitudes == pytest.approx(expected, abs=1e-9)
    assert lines.standard_errors() == pytest.approx(np.zeros(24), abs=1e-9)


@pytest.mark.parametrize("rpm", [1500.0, 1523.7])
def test_orders_at_a_given_speed(rpm: float) -> None:
    """Whole samples a turn or not, orders are exact; angle 0 is the first sample."""
    t = instants(10.0, RATE)
    angle = TURN * rpm / 60.0 * t
    lines = order_lines(channel(orders_of(angle, CONTENT), RATE), Turning.steady(rpm, 10.0), 12.0)
    assert lines is not None
    assert lines.turns == 2 * int(rpm / 12.0)
    assert lines.amplitudes[1] == pytest.approx(np.exp(0.5j), abs=1e-9)


def test_standard_error_is_that_of_the_noise() -> None:
    t = instants(20.0, RATE)
    noise = 0.1 * np.random.default_rng(4).standard_normal(len(t))
    lines = order_lines(channel(np.cos(TURN * 25.0 * t) + noise, RATE), Turning.steady(1500.0, 20.0), 12.0)
    assert lines is not None
    # Of white noise, σ √(2/N) for real and imaginary part each.
    assert np.median(lines.standard_errors()) == pytest.approx(0.1 * np.sqrt(2.0 / len(t)), rel=0.15)
    assert abs(lines.amplitudes[1] - 1.0) < 5 * 0.1 * np.sqrt(4.0 / len(t))


def test_fewer_than_two_turns_have_no_orders() -> None:
    assert order_lines(channel(np.zeros(1000), RATE), Turning.steady(300.0, 0.2), 12.0) is None


def test_resampled_by_angle_keeps_orders_and_stops_those_that_would_fold() -> None:
    """Order 120 would fold to 8 with 128 values a turn: the filter leaves 2e-5 of it at most."""
    _, angle, course = _run_up()
    per_turn = samples_per_turn(12.0)
    assert per_turn == 128
    kept = orders_of(angle, CONTENT)
    folding = np.where(per_turn * course.speed_rad_s(_run_up()[0]) < TURN * RATE, np.cos(120.0 * angle), 0.0)
    turns = int(angle[-1] / TURN)
    for values, expected in ((kept, CONTENT), (folding, {})):
        found = np.concatenate(list(by_angle(channel(values, RATE), course, per_turn, 12.0, turns)))
        inner = slice(8 * per_turn, 100 * per_turn)
        by = np.arange(len(found)) * TURN / per_turn
        error = (found - orders_of(by, expected))[inner]
        size = np.abs(np.fft.rfft(error * np.hanning(len(error)))) / (0.25 * len(error))
        orders = np.arange(len(size)) * per_turn / len(error)
        assert size[orders <= 12.5].max() < 2e-5


def test_order_map_holds_orders_while_the_waterfall_s_lines_move() -> None:
    _, angle, course = _run_up()
    record = channel(orders_of(angle, {1.0: (1.0, 0.2), 4.0: (0.3, 0.0)}), RATE)
    mapped = order_map(record, course, 12.0)
    assert mapped is not None
    assert mapped.speeds_rpm is not None
    assert mapped.amplitudes[:, 16] == pytest.approx(1.0, abs=1e-5)
    assert mapped.amplitudes[:, 64] == pytest.approx(0.3, abs=1e-5)
    assert mapped.speeds_rpm == pytest.approx(60.0 * (10.0 + 28.0 / 12.0 * mapped.times_s), rel=1e-6)
    fall = waterfall(record, "hann", 200.0, course)
    loudest = fall.columns[np.argmax(fall.amplitudes, axis=1)]
    assert fall.speeds_rpm is not None
    assert loudest == pytest.approx(fall.speeds_rpm / 60.0, abs=2.0)


def test_a_waterfall_is_seen_through_the_window_that_was_asked_for() -> None:
    between_bins = 40.5 * RATE / 4096
    record = channel(np.cos(2.0 * np.pi * between_bins * np.arange(8 * RATE) / RATE), RATE)
    flat, bell = (waterfall(record, name, RATE / 4.0) for name in ("flattop", "hann"))
    assert flat.columns[1] == pytest.approx(RATE / 4096)
    assert flat.amplitudes.max(axis=1) == pytest.approx(1.0, abs=2e-3)
    assert bell.amplitudes.max(axis=1) == pytest.approx(8.0 / (3.0 * np.pi), abs=1e-3)


def test_cuts_follow_amplitude_and_phase() -> None:
    _, angle, course = _run_up()
    speed = np.sqrt(1.0 + 4.0 * 28.0 / 12.0 / TURN * angle / 100.0)  # grows with the angle
    cuts = order_cuts(channel(speed * np.cos(2.0 * angle + 0.7), RATE), course, 4.0)
    second = cuts[3]
    assert second.order == 2.0
    expected = np.interp(second.times_s, np.arange(len(speed)) / RATE, speed)
    assert np.abs(second.amplitudes) == pytest.approx(expected, rel=3e-3)  # a mean over two turns
    assert np.angle(second.amplitudes) == pytest.approx(0.7, abs=1e-3)


def test_crossing_of_order_4_with_115_hz_is_at_1725_rpm() -> None:
    """RU-11; the document says "around 1800"."""
    found = {
        (each.order, each.frequency_hz): each.speed_rpm for each in crossings([115.0, 230.0, 172.0], 12.0)
    }
    assert found[4.0, 115.0] == found[8.0, 230.0] == 1725.0
    assert found[5.5, 172.0] == pytest.approx(1876.36364, abs=1e-5)
    assert len(found) == 3 * 24


@pytest.mark.parametrize(
    ("x", "y", "forward", "backward", "verdict"),
    [
        (1.0, -1j, 1.0, 0.0, "rotating"),
        (1.0, 1j, 0.0, 1.0, "rotating"),
        (1.0, 0.0, 0.5, 0.5, "reciprocating"),
        (0.6, 0.8, 0.5, 0.5, "reciprocating"),
        (1.0, -0.3j, 0.65, 0.35, "mixed"),
        (0.0, 0.0, 0.0, 0.0, "rotating"),
    ],
)
def test_circles_of_two_axes(x: complex, y: complex, forward: float, backward: float, verdict: str) -> None:
    found = circles(1.0, x, y)
    assert (found.forward, found.backward) == pytest.approx((forward, backward), abs=1e-12)
    assert found.verdict == verdict
