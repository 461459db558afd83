"""Natural frequencies and damping: from forces, from the orders that pass, from responses alone."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from scipy.signal import chirp

from autobalance.signals.modes import modes_of_response, modes_of_run_up, modes_of_sweep, modes_of_transfer
from tests.signals import TURN, instants, orders_of, ramp, resonated, turning

RATE = 2000.0


@pytest.mark.parametrize("method", ["linear", "logarithmic"])
@pytest.mark.parametrize(("frequency", "damping"), [(50.0, 0.01), (50.0, 0.03), (120.0, 0.005)])
def test_chirp_through_a_single_mass(
    method: Literal["linear", "logarithmic"], frequency: float, damping: float
) -> None:
    """Frequency to 0.1 %, damping to 3 %: with the force, and from the response alone."""
    t = instants(10.0, RATE)
    force = np.asarray(chirp(t, 5.0, 10.0, 300.0, method=method))
    response = resonated(force, RATE, frequency, damping)
    response += 0.01 * response.std() * np.random.default_rng(1).standard_normal(len(t))
    for found in (modes_of_transfer(response, force, RATE), modes_of_sweep(response, RATE)):
        [mode] = found
        assert mode.frequency_hz == pytest.approx(frequency, rel=1e-3)
        assert mode.damping_ratio == pytest.approx(damping, rel=0.03)


def test_two_modes_from_random_force() -> None:
    t = instants(30.0, RATE)
    force = np.random.default_rng(2).standard_normal(len(t))
    response = resonated(force, RATE, 115.0, 0.012) + 0.5 * resonated(force, RATE, 187.0, 0.008)
    found = modes_of_transfer(response, force, RATE)
    alone = modes_of_sweep(response, RATE)
    assert [mode.frequency_hz for mode in alone] == pytest.approx([115.0, 187.0], rel=5e-3)
    assert [mode.damping_ratio for mode in alone] == pytest.approx([0.012, 0.008], rel=0.3)
    assert [mode.frequency_hz for mode in found] == pytest.approx([115.0, 187.0], rel=1e-4)
    assert [mode.damping_ratio for mode in found] == pytest.approx([0.012, 0.008], rel=0.01)


def test_run_up_tells_natural_frequencies_from_orders() -> None:
    """Four orders of different size pass two resonances; a tone that stays in hertz is no resonance.

    The run-up takes 20 s from 600 to 3600 1/min: fast enough to shift a peak that is merely looked up.
    """
    t = instants(20.0, RATE)
    angle = ramp(t, 10.0, 60.0)
    speed = TURN * (10.0 + 2.5 * t)
    force = 1e-4 * speed**2 * np.cos(angle + 0.3) + orders_of(
        angle, {2: (0.8, 1.0), 4: (0.5, 0.0), 0.5: (0.2, 0.0)}
    )
    response = resonated(force, RATE, 115.0, 0.012) + 0.5 * resonated(force, RATE, 187.0, 0.008)
    response += 0.02 * response.std() * np.random.default_rng(3).standard_normal(len(t))
    response += 0.3 * np.cos(TURN * 150.0 * t)
    found = modes_of_run_up(response, RATE, turning(t, angle), [1.0, 2.0, 4.0, 0.5])
    assert [mode.frequency_hz for mode in found] == pytest.approx([115.0, 187.0], rel=5e-4)
    assert [mode.damping_ratio for mode in found] == pytest.approx([0.012, 0.008], rel=0.03)


def test_steady_tones_and_noise_are_no_modes() -> None:
    t = instants(20.0, RATE)
    noise = np.random.default_rng(4).standard_normal(len(t))
    tones = np.cos(TURN * 50.0 * t) + 0.4 * np.cos(TURN * 100.0 * t)
    assert modes_of_sweep(tones + 0.01 * noise, RATE) == []
    assert modes_of_response(noise, RATE) == []
