"""Bearings by the documented formulas: the reference cases that they can tell, and what they refuse."""

from __future__ import annotations

import math

import pytest

from autobalance import theory
from autobalance.engines.bearings.film import JournalBearing, film_at_eccentricity
from autobalance.engines.bearings.reynolds import ocvirk
from autobalance.errors import UsageError
from autobalance.formulas.calc import call
from tests.reference.published import CASES, EXACT, inputs


def value(case: str, name: str) -> float:
    return float(CASES[case]["values"][name]["value"])


def test_the_reference_cases() -> None:
    half = theory.mean_bearing_loads(0.5, 0.5)
    assert half.mean_N == pytest.approx(value("FM-01", "p1_half"), rel=EXACT)
    assert half.cubic_mean_N == pytest.approx(value("FM-01", "p3_half"), rel=EXACT)
    dry = inputs("FR-07")
    found = theory.dry_friction(dry["W"], dry["d"], dry["mu"])
    assert found.moment_N_m == pytest.approx(value("FR-07", "T_exact"), rel=EXACT)
    assert found.small_angle_N_m == pytest.approx(value("FR-07", "T_small_angle"), rel=EXACT)
    bench = inputs("FR-01")
    for torque, mu in (("T3", "mu3"), ("T6", "mu6"), ("T9", "mu9")):
        coefficient = theory.friction_coefficient(bench[torque], bench["W"], bench["d"])
        assert coefficient.mu_small_angle == pytest.approx(value("FR-01", mu), rel=EXACT)
        assert (coefficient.mu is None) == (coefficient.mu_small_angle >= 1.0)
    size = {"diameter_mm": 30.0, "length_mm": 15.0, "radial_clearance_mm": 0.02}
    petroff = theory.journal_friction_n_m(**size, viscosity_Pa_s=0.01, speed_rpm=6000.0)
    assert petroff == pytest.approx(value("FR-08", "T_concentric"), rel=EXACT)
    eccentric = theory.journal_friction_n_m(
        **size,
        viscosity_Pa_s=0.01,
        speed_rpm=6000.0,
        eccentricity_ratio=0.6,
        load_N=500.0,
        attitude_angle_deg=50.0,
    )
    assert eccentric == pytest.approx(value("FR-08", "T_ecc_0.6"), rel=EXACT)
    plates = theory.squeeze_film(500.0, 0.02, 0.01, 20.0, 20.0)
    assert plates.stiffness_N_m == pytest.approx(value("FR-10", "k"), rel=EXACT)
    assert plates.damping_source_N_s_m == pytest.approx(value("FR-09", "C_doc"), rel=EXACT)
    assert plates.damping_N_s_m == pytest.approx(value("FR-09", "C_reynolds"), rel=EXACT)


def test_the_short_bearings_friction_is_that_of_its_film() -> None:
    film = film_at_eccentricity(JournalBearing(0.05, 0.0125, 25e-6), ocvirk(0.25), 0.01, 300.0, 0.7)
    assert film is not None
    petroff = 2.0 * math.pi * 0.01 * 300.0 * 0.025**3 * 0.0125 / 25e-6
    assert theory.short_bearing(0.7, 0.25).friction_over_petroff == pytest.approx(
        film.moment_N_m / petroff, rel=1e-12
    )


@pytest.mark.parametrize(
    ("name", "values", "words"),
    [
        ("mean_bearing_loads", {"constant_N": "0", "rotating_N": "0"}, "both loads are 0"),
        ("dry_friction", {"load_N": "-1", "diameter_mm": "20", "mu": "0.1"}, "load_N is -1; must be ≥ 0"),
        ("friction_coefficient", {"torque_N_m": "1", "load_N": "0", "diameter_mm": "20"}, "must be > 0"),
        ("short_bearing", {"eccentricity_ratio": "1", "length_over_diameter": "0.5"}, "between 0 and 1"),
        ("oil_viscosity_mm2_s", {"temperature_C": "-300"}, "must be above -273.15"),
    ],
)
def test_the_impossible_is_refused(name: str, values: dict[str, str], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        call(name, values)
