"""Means of loads, dry and rolling friction, oil, squeeze film: closed forms and limits."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad

from autobalance.engines.bearings import dry, loads
from autobalance.engines.bearings.fed_film import damping_N_s_m, uniform_pressure_damping_N_s_m
from autobalance.engines.bearings.oil import WaltherOil
from autobalance.engines.bearings.rolling import (
    FourParts,
    FourSources,
    Palmgren,
    PalmgrenParts,
    RollingBearing,
    friction_moment_N_m,
    friction_parts,
)

PALMGREN_6204_N_M = {3000.0: 0.067, 6000.0: 0.107, 9000.0: 0.140}
"""Two 6204, d_m 33.5 mm, f0 2, 100 mm²/s, no load."""
OIL = WaltherOil.of_points(((40.0, 100.0), (100.0, 11.0)))


@pytest.mark.parametrize(
    ("constant", "rotating"), [(3.0, 1.0), (1.0, 3.0), (2.0, 2.0), (0.0, 1.0), (5.0, 0.0)]
)
def test_means_are_those_of_the_turn(constant: float, rotating: float) -> None:
    def power(exponent: float) -> float:
        def force(angle: float) -> float:
            square = constant**2 + rotating**2 + 2.0 * constant * rotating * math.cos(angle)
            return math.pow(max(square, 0.0), 0.5 * exponent)

        return float(quad(force, 0.0, math.pi, epsabs=1e-13, limit=400)[0]) / math.pi

    assert float(loads.mean_load_N(constant, rotating)) == pytest.approx(power(1.0), rel=1e-10)
    assert float(loads.cubic_mean_load_N(constant, rotating)) == pytest.approx(
        power(3.0) ** (1.0 / 3.0), rel=1e-10
    )


def test_no_load_has_no_means() -> None:
    for mean in (loads.mean_load_N, loads.cubic_mean_load_N, loads.equivalent_load_N):
        assert float(mean(0.0, 0.0)) == 0.0


def test_dry_friction_and_its_inverse() -> None:
    for mu in (0.01, 0.3, 1.5):
        moment = float(dry.friction_moment_N_m(100.0, 0.02, mu))
        assert moment == pytest.approx(100.0 * 0.01 * math.sin(math.atan(mu)), rel=1e-14)
        assert dry.mu_of_moment(moment, 100.0, 0.02) == pytest.approx(mu, rel=1e-12)
    assert dry.mu_of_moment(1.0, 100.0, 0.02) is None
    assert dry.mu_of_moment(1.01, 100.0, 0.02) is None


def test_the_small_angle_is_2_percent_off_at_its_end() -> None:
    exact = float(dry.friction_moment_N_m(1.0, 2.0, dry.SMALL_ANGLE_MU))
    assert float(dry.small_angle_moment_N_m(1.0, 2.0, dry.SMALL_ANGLE_MU)) / exact - 1.0 == pytest.approx(
        0.02, abs=3e-4
    )


def test_friction_of_a_turning_load_follows_the_mean_of_its_magnitude() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    force = np.stack([25.0 + 42.2 * np.cos(angle), 42.2 * np.sin(angle)], axis=-1)
    moment = dry.friction_moment_N_m(np.hypot(*force.T), 0.02, 0.4).mean()
    assert moment == pytest.approx(
        float(dry.friction_moment_N_m(loads.mean_load_N(25.0, 42.2), 0.02, 0.4)), rel=1e-12
    )


def test_palmgren_numbers_of_two_6204() -> None:
    bearing = RollingBearing(33.5, Palmgren(2.0))
    for speed, printed in PALMGREN_6204_N_M.items():
        assert 2.0 * friction_moment_N_m(bearing, 0.0, speed, 100.0) == pytest.approx(printed, abs=5e-4)


def test_palmgren_is_flat_where_speed_and_viscosity_are_low() -> None:
    bearing = RollingBearing(33.5, Palmgren(2.0, 0.0004))
    slow = [friction_moment_N_m(bearing, 100.0, speed, 10.0) for speed in (10.0, 100.0, 199.999)]
    assert slow[0] == slow[1] == slow[2]
    assert friction_moment_N_m(bearing, 100.0, 200.0, 10.0) == pytest.approx(slow[0], rel=0.01)
    parts = friction_parts(bearing, 100.0, 10.0, 10.0)
    assert isinstance(parts, PalmgrenParts)
    assert parts.load_free_N_m == pytest.approx(160e-7 * 2.0 * 33.5**3 * 1e-3, rel=1e-14)
    assert parts.load_N_m == pytest.approx(0.0004 * 100.0 * 33.5e-3, rel=1e-14)


def test_four_sources_term_by_term() -> None:
    model = FourSources(r1=3.9e-7, s1=3.23e-3, bore_mm=20.0, outer_mm=47.0, seal_N_mm=1.5, drag_N_mm=0.25)
    parts = friction_parts(RollingBearing(33.5, model), 500.0, 3000.0, 30.0)
    assert isinstance(parts, FourParts)
    heating = 1.0 / (1.0 + 1.84e-9 * (3000.0 * 33.5) ** 1.28 * 30.0**0.64)
    starving = math.exp(-6e-8 * 30.0 * 3000.0 * 67.0 * math.sqrt(3.1 / 54.0))
    rolling = heating * starving * 3.9e-7 * 33.5**1.96 * 500.0**0.54 * 90000.0**0.6
    share = math.exp(-2.6e-8 * 90000.0**1.4 * 33.5)
    sliding = 3.23e-3 * 33.5**-0.26 * 500.0 ** (5.0 / 3.0) * (0.15 * share + 0.05 * (1.0 - share))
    expected = (rolling * 1e-3, sliding * 1e-3, 1.5e-3, 0.25e-3)
    assert (parts.rolling_N_m, parts.sliding_N_m, parts.seal_N_m, parts.drag_N_m) == pytest.approx(expected)
    assert parts.moment_N_m == pytest.approx(sum(expected))


def test_walther_falls_with_the_temperature_and_passes_its_points() -> None:
    assert OIL.kinematic_mm2_s(40.0) == pytest.approx(100.0, rel=1e-12)
    assert OIL.kinematic_mm2_s(100.0) == pytest.approx(11.0, rel=1e-12)
    viscosities = [OIL.kinematic_mm2_s(celsius) for celsius in range(-20, 200, 10)]
    assert all(thick > thin for thick, thin in itertools.pairwise(viscosities))
    middle = math.log10(math.log10(OIL.kinematic_mm2_s(70.0) + 0.7))
    assert middle == pytest.approx(OIL.walther_a - OIL.walther_b * math.log10(343.15), rel=1e-12)
    assert OIL.viscosity_Pa_s(40.0) == pytest.approx(0.086, rel=1e-12)


def test_the_order_of_an_oils_points_does_not_matter() -> None:
    assert WaltherOil.of_points(((100.0, 11.0), (40.0, 100.0))) == OIL


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (((40.0, 0.0), (100.0, 11.0)), "must be > 0.3"),
        (((40.0, 100.0), (40.0, 11.0)), "two temperatures"),
        (((40.0, 11.0), (100.0, 100.0)), "must fall"),
        (((-300.0, 100.0), (100.0, 11.0)), "must be above -273.15"),
    ],
)
def test_an_impossible_oil_is_refused(
    points: tuple[tuple[float, float], tuple[float, float]], words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        WaltherOil.of_points(points)


def test_squeeze_film_does_not_mind_which_side_is_longer_and_ends_at_the_strip() -> None:
    assert damping_N_s_m(0.01, 0.02, 0.05, 1e-5) == damping_N_s_m(0.01, 0.05, 0.02, 1e-5)
    strip = damping_N_s_m(0.01, 20.0, 0.02, 1e-5)
    assert strip == pytest.approx(0.01 * 20.0 * 0.02**3 / 1e-15, rel=1e-3)
    assert uniform_pressure_damping_N_s_m(0.01, 20.0, 0.02, 1e-5) / strip == pytest.approx(3.0, rel=1e-3)
