"""Pulses: between samples, mended, evened; the angle that comes of them."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.errors import FormatError
from autobalance.signals.tacho import TachoPulses, crossings_s, mend, pulses
from tests.signals import TURN, channel, instants, ramp, smooth_tacho, tacho

RATE = 20_000.0


def _pulses(values: object, per_turn: int, threshold: float | None = None) -> TachoPulses:
    found = pulses(channel(np.asarray(values), RATE, "tacho"), per_turn, threshold)
    assert isinstance(found, TachoPulses)
    return found


@pytest.mark.parametrize("per_turn", [1, 2, 60])
def test_steady_speed(per_turn: int) -> None:
    t = instants(5.0, RATE)
    turning = _pulses(smooth_tacho(TURN * 25.3 * t + 0.3, per_turn), per_turn).turning()
    assert turning.mean_rpm == pytest.approx(1518.0, rel=1e-5)
    speeds = turning.speeds_rpm()
    assert (speeds.min(), speeds.max()) == pytest.approx((1518.0, 1518.0), rel=1e-3)


def test_crossings_stand_between_samples() -> None:
    t = instants(1.0, 1000.0)
    found = crossings_s(channel(smooth_tacho(TURN * 10.0 * t - 1.0), 1000.0))
    # The straight line between samples against a sine: (ωΔt)²/(9√3) of a step at most.
    assert found == pytest.approx(
        0.1 * np.arange(10) + 1.0 / (TURN * 10.0), abs=1e-3 * 0.0628**2 / 15.5 * 1.1
    )


def test_threshold_and_hysteresis() -> None:
    t = instants(1.0, 1000.0)
    noisy = smooth_tacho(TURN * 10.0 * t - 1.0) + 0.05 * np.random.default_rng(1).standard_normal(1000)
    assert len(crossings_s(channel(noisy, 1000.0))) == 10
    shifted = crossings_s(channel(smooth_tacho(TURN * 10.0 * t), 1000.0), 0.5)
    assert shifted == pytest.approx(0.1 * np.arange(10) + np.arcsin(0.5) / (TURN * 10.0), abs=1e-5)


def test_speed_of_a_run_up_is_smooth() -> None:
    """From once-a-turn pulses the speed is that of the shaft between them too: no steps."""
    t = instants(10.0, RATE)
    turning = _pulses(smooth_tacho(ramp(t, 5.0, 55.0)), 1).turning()
    at = np.linspace(1.0, 9.5, 500)
    assert turning.speed_rad_s(at) / TURN == pytest.approx(5.0 + 5.0 * at, rel=2e-3)
    assert turning.time_s(turning.angle_rad(at)) == pytest.approx(at, abs=1e-9)


def test_missing_and_doubled_pulses_are_mended_and_counted() -> None:
    true = np.arange(300) / 25.0
    damaged = np.sort(np.append(np.delete(true, [50, 51, 120]), [3.013, 7.508]))
    mended, missing, extra = mend(damaged)
    assert (missing, extra) == (3, 2)
    assert mended == pytest.approx(true, abs=1e-9)


def test_missing_teeth_of_a_wheel() -> None:
    t = instants(4.0, RATE)
    angle = TURN * 20.0 * t
    tooth = (angle * 60 / TURN).astype(int) % 60
    found = _pulses(np.where(tooth < 58, smooth_tacho(angle, 60), -1.0), 60)
    assert found.missing == pytest.approx(2 * 80, abs=2)
    assert found.repeats == 60
    assert found.turning().mean_rpm == pytest.approx(1200.0, rel=1e-4)


def test_jitter_is_the_intervals_scatter() -> None:
    rng = np.random.default_rng(2)
    t = instants(10.0, RATE)
    late = np.interp(t, np.arange(260) / 25.0, rng.normal(0.0, 0.01, 260))  # 1 % of an interval, a pulse
    found = _pulses(smooth_tacho(TURN * 25.0 * t - TURN * late), 1)
    assert 0.01 * found.jitter / 0.01 == pytest.approx(0.01 * np.sqrt(2.0), rel=0.25)
    assert found.speed_uncertainty_rpm(1500.0) == pytest.approx(1500.0 * 0.01414 / 249, rel=0.25)


def test_encoder_s_own_pattern_is_told_from_jitter_and_corrected() -> None:
    rng = np.random.default_rng(3)
    t = instants(10.0, RATE)
    uneven = rng.normal(0.0, 0.05, 12)
    uneven -= uneven[0]
    angle = TURN * 10.0 * t
    tooth = angle * 12 / TURN
    shift = np.interp(tooth % 12.0, np.arange(13.0), np.append(uneven, uneven[0]))
    found = _pulses(smooth_tacho(angle - TURN / 12 * shift, 12), 12)
    assert found.pattern == pytest.approx(np.std(uneven), rel=0.15)
    assert found.jitter < 0.005
    speeds = found.turning().speeds_rpm()
    assert speeds.max() - speeds.min() < 3.0  # of 600; uncorrected it is 60


def test_no_pulses_are_told_in_words() -> None:
    found = pulses(channel(np.full(1000, 0.1), RATE, "tacho"), 1)
    assert isinstance(found, str)
    assert "no pulses" in found
    found = pulses(channel(tacho(TURN * 20.0 * instants(1.0, RATE)), RATE, "tacho"), 1, 9.0)
    assert isinstance(found, str)
    assert "threshold is 9" in found


def test_count_of_pulses_must_be_one() -> None:
    with pytest.raises(FormatError, match="0 pulses a turn"):
        pulses(channel(np.zeros(10), RATE), 0)
