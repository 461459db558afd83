"""Bearing orders and the envelope."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.errors import FormatError
from autobalance.signals.bearing import defects, envelope, liveliest_band
from autobalance.signals.by_angle import Turning
from autobalance.signals.sources import BearingSource
from tests.signals import TURN, channel, instants, ramp, turning

RATE = 20_000.0
B6205 = BearingSource(9, 0.3126, 1.537)


def test_6205_as_its_maker_tells() -> None:
    orders = B6205.orders()
    assert orders["bpfo"] == pytest.approx(3.5848, abs=1e-4)
    assert orders["bpfi"] == pytest.approx(5.4152, abs=1e-4)
    assert orders["ftf"] == pytest.approx(0.3983, abs=1e-4)
    assert orders["ball_defect"] == pytest.approx(4.7134, abs=2e-4)
    assert orders["bsf"] == pytest.approx(orders["ball_defect"] / 2.0)


def test_orders_add_up() -> None:
    """BPFO + BPFI = N; BPFO = N FTF: kinematics, whatever the angle."""
    bearing = BearingSource(11, 8.0, 40.0, np.radians(15.0), 0.5)
    assert bearing.bpfo + bearing.bpfi == pytest.approx(11 * 0.5)
    assert bearing.bpfo == pytest.approx(11 * bearing.ftf)


def test_ru_14_eleven_balls_at_half_speed_give_no_order_5_5() -> None:
    """The document took N f = 5.5 for a defect order; it is BPFO + BPFI."""
    bearing = BearingSource(11, 0.2, 1.0, 0.0, 0.5)
    assert (bearing.bpfo, bearing.bpfi) == pytest.approx((2.2, 3.3))
    assert all(abs(order - 5.5) > 0.5 for order in bearing.orders().values())


@pytest.mark.parametrize("slip", [0.0, 0.004])
def test_envelope_reads_the_modulation_s_amplitude(slip: float) -> None:
    t = instants(10.0, RATE)
    strike = B6205.bpfo * (1.0 - slip) * 29.95
    carrier = 0.7 * (1.0 + 0.4 * np.cos(TURN * strike * t)) * np.cos(TURN * 6000.0 * t)
    values = (
        carrier + 0.5 * np.cos(TURN * 29.95 * t) + 0.01 * np.random.default_rng(1).standard_normal(len(t))
    )
    found = {
        each.name: each
        for each in defects(
            envelope(channel(values, RATE), 4000.0, 8000.0), Turning.steady(1797.0, 10.0), B6205
        )
    }
    assert found["bpfo"].found
    assert found["bpfo"].amplitude == pytest.approx(0.28, rel=2e-3)
    assert found["bpfo"].frequency_hz == pytest.approx(strike, rel=1e-5)
    assert found["bpfo"].order == B6205.bpfo
    assert not any(found[name].found for name in ("bpfi", "ftf", "bsf", "ball_defect"))


def test_envelope_by_angle_does_not_smear_in_a_run_up() -> None:
    t = instants(10.0, RATE)
    angle = ramp(t, 15.0, 30.0)
    values = (1.0 + 0.5 * np.cos(B6205.bpfi * angle)) * np.cos(TURN * 5000.0 * t)
    found = {
        each.name: each
        for each in defects(envelope(channel(values, RATE), 3000.0, 7000.0), turning(t, angle), B6205)
    }
    assert found["bpfi"].found
    assert found["bpfi"].amplitude == pytest.approx(0.5, rel=1e-3)
    assert not found["bpfo"].found


def test_liveliest_band_holds_the_ringing() -> None:
    t = instants(5.0, RATE)
    since = np.mod(t, 1.0 / 107.0)
    rings = np.exp(-since * 1500.0) * np.sin(TURN * 5500.0 * since)
    low, high = liveliest_band(channel(rings + 0.05 * np.random.default_rng(2).standard_normal(len(t)), RATE))
    assert low <= 5500.0 <= high


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((0, 1.0, 5.0), "balls is 0"),
        ((9, 5.0, 1.0), "ball is 5 and pitch 1"),
        ((9, 1.0, 5.0, 2.0), "contact is 114"),
        ((9, 1.0, 5.0, 0.0, -1.0), "speed is -1"),
    ],
)
def test_impossible_bearing(arguments: tuple[float, ...], words: str) -> None:
    with pytest.raises(FormatError, match=words):
        BearingSource(int(arguments[0]), *arguments[1:])


def test_band_must_be_the_record_s() -> None:
    with pytest.raises(FormatError, match="between 0 and half the sample rate, 10000"):
        envelope(channel(np.zeros(1000), RATE), 4000.0, 12_000.0)
