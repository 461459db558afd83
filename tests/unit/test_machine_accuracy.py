"""Tooling separated from the crank by an index test, and what repeated readings can show."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

import autobalance as ab
from tests import jobs


def polar(value: complex) -> tuple[float, float]:
    return abs(value), math.degrees(cmath.phase(value)) % 360.0


def test_two_readings_at_half_a_turn_are_exact() -> None:
    crank, tooling = cmath.rect(21.0, 1.1), cmath.rect(13.0, -2.0)
    sizes, angles = zip(polar(tooling + crank), polar(tooling - crank), strict=True)
    found = ab.theory.index_test([0.0, 180.0], sizes, angles)
    assert (found.crank_g_mm, found.crank_deg) == pytest.approx(polar(crank))
    assert (found.tooling_g_mm, found.tooling_deg) == pytest.approx(polar(tooling))
    assert found.scatter_g_mm is None


def test_more_readings_are_fitted_and_tell_their_scatter() -> None:
    rng = np.random.default_rng(4)
    crank, tooling, sigma = cmath.rect(30.0, 0.4), cmath.rect(8.0, 2.5), 0.2
    turned = np.tile([0.0, 90.0, 180.0, 270.0], 100)
    noise = rng.normal(0.0, sigma, (2, len(turned)))
    read = tooling + crank * np.exp(1j * np.radians(turned)) + noise[0] + 1j * noise[1]
    found = ab.theory.index_test(turned.tolist(), np.abs(read).tolist(), np.degrees(np.angle(read)).tolist())
    assert found.crank_g_mm == pytest.approx(30.0, abs=5.0 * sigma / 20.0)
    assert found.tooling_g_mm == pytest.approx(8.0, abs=5.0 * sigma / 20.0)
    assert found.scatter_g_mm == pytest.approx(sigma, rel=0.15)


def test_repeated_readings_tell_the_least_residual() -> None:
    rng = np.random.default_rng(5)
    read = 12.0 + rng.normal(0.0, 0.3, 4000) + 1j * rng.normal(0.0, 0.3, 4000)
    found = ab.theory.repeated_readings(np.abs(read).tolist(), np.degrees(np.angle(read)).tolist())
    assert found.mean_g_mm == pytest.approx(12.0, abs=0.03)
    assert found.scatter_g_mm == pytest.approx(0.3, rel=0.05)
    assert found.umar_g_mm == pytest.approx(1.96 * 0.3, rel=0.05)


def test_the_least_residual_of_three_readings_holds_for_19_of_20_machines() -> None:
    """By drawing: a fourth reading's x is within Umar of the three's scatter 95 times in 100."""
    rng = np.random.default_rng(6)
    held = 0
    for _ in range(4000):
        noise = rng.normal(0.0, 0.3, 3) + 1j * rng.normal(0.0, 0.3, 3)
        read = 12.0 + noise
        found = ab.theory.repeated_readings(np.abs(read).tolist(), np.degrees(np.angle(read)).tolist())
        held += abs(rng.normal(0.0, 0.3)) <= found.umar_g_mm
    assert held / 4000 == pytest.approx(0.95, abs=0.012)


@pytest.mark.parametrize(
    ("turned", "sizes", "angles", "said"),
    [
        ([0.0], [1.0], [0.0], "expected two or more"),
        ([0.0, 360.0], [1.0, 2.0], [0.0, 0.0], "was not turned"),
        ([0.0, 180.0], [1.0, 2.0], [0.0], "expected as many"),
    ],
)
def test_what_can_not_be_separated_is_refused(
    turned: list[float], sizes: list[float], angles: list[float], said: str
) -> None:
    with pytest.raises(ValueError, match=said):
        ab.theory.index_test(turned, sizes, angles)
    with pytest.raises(ValueError, match="expected two or more"):
        ab.theory.repeated_readings([1.0], [0.0])


def test_the_command_line_calculates_it(capsys: pytest.CaptureFixture[str]) -> None:
    lists = ("turned_deg=[0,180]", "readings_g_mm=[30,10]", "readings_deg=[0,180]")
    assert jobs.run("calc", "index_test", *lists) == 0
    assert "20" in capsys.readouterr().out
