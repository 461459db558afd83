"""Oil whirl: the threshold of a rigid rotor, and the film as a bearing of a beam rotor."""

from __future__ import annotations

import math

import numpy as np
import pytest

import autobalance as ab
from autobalance.engines.bearings.film import Film, JournalBearing, film_at_eccentricity
from autobalance.engines.bearings.reynolds import ocvirk
from autobalance.errors import JobError

BEARING = JournalBearing(0.05, 0.025, 50e-6)
SPEED_RAD_S = 100.0 * math.pi
FILM = {
    "kind": "hydrodynamic",
    "diameter_mm": 50.0,
    "length_mm": 25.0,
    "radial_clearance_mm": 0.05,
    "viscosity_Pa_s": 0.01,
    "solver": "ocvirk",
    "load_N": 400.0,
    "speed_rpm": 3000,
}
ALWAYS_STABLE_FROM = 0.756
"""Eccentricity ratio from which a short bearing carries a rigid rotor of any mass without whirl."""


def film(ratio: float) -> Film:
    found = film_at_eccentricity(BEARING, ocvirk(0.5), 0.01, SPEED_RAD_S, ratio)
    assert found is not None
    return found


def test_a_light_load_whirls_at_half_the_speed() -> None:
    assert film(1e-3).whirl.whirl_ratio == pytest.approx(0.5, abs=1e-5)
    assert film(0.0).whirl.critical_mass_kg == 0.0


def test_a_short_bearing_is_stable_beyond_its_known_eccentricity() -> None:
    assert film(ALWAYS_STABLE_FROM - 0.002).whirl.critical_mass_kg is not None
    assert film(ALWAYS_STABLE_FROM + 0.002).whirl.critical_mass_kg is None


@pytest.mark.parametrize("ratio", [0.1, 0.4, 0.7])
def test_the_threshold_is_a_pair_of_undamped_eigenvalues(ratio: float) -> None:
    found = film(ratio)
    whirl = found.whirl
    assert whirl.critical_mass_kg is not None
    assert whirl.whirl_ratio is not None
    growth = []
    for share in (0.99, 1.0, 1.01):
        mass = share * whirl.critical_mass_kg
        state = np.block(
            [
                [np.zeros((2, 2)), np.eye(2)],
                [-found.stiffness_N_m / mass, -found.damping_N_s_m / mass],
            ]
        )
        values = np.linalg.eigvals(state)
        worst = values[np.argmax(values.real)]
        growth.append(float(worst.real))
        if share == 1.0:
            assert abs(worst.imag) == pytest.approx(whirl.whirl_ratio * SPEED_RAD_S, rel=1e-8)
    assert growth[0] < 0.0 < growth[2]
    assert growth[1] == pytest.approx(0.0, abs=1e-6 * SPEED_RAD_S)


def test_a_beam_rotor_on_the_film_whirls_at_its_threshold() -> None:
    """A stiff, light shaft with a disc of twice the critical mass: each bearing carries half of it."""
    bearing = ab.bearing(FILM)
    told = bearing.report["film"]
    supports = [bearing.rotor_bearing(0.0), bearing.rotor_bearing(400.0)]
    decrements = []
    for share in (0.99, 1.01):
        rotor = ab.rotor(
            {
                "speed_rpm": 3000,
                "beam": "euler",
                "shaft": [
                    {
                        "length_mm": 400.0,
                        "outer_mm": 200.0,
                        "e_gpa": 20000.0,
                        "density_kg_m3": 100.0,
                        "elements": 4,
                    }
                ],
                "disc": [
                    {
                        "z_mm": 200.0,
                        "mass_kg": 2.0 * share * told["critical_mass_kg"] - 1.0,  # the shaft is 1.26 kg
                        "polar_kg_mm2": 1.0,
                        "diametral_kg_mm2": 3e7,
                    }
                ],
                "bearing": supports,
            }
        )
        lowest = rotor.report["modes"][0]
        assert lowest["whirl"] == "forward"
        assert lowest["frequency_hz"] / 50.0 == pytest.approx(told["whirl_ratio"], rel=0.01)
        decrements.append(lowest["log_decrement"])
    assert decrements[0] > 0.0 > decrements[1]


def test_several_speeds_make_a_table_in_the_rotors_axes() -> None:
    bearing = ab.bearing({**FILM, "speed_rpm": [6000, 1000, 3000]})
    down, along_x = bearing.rotor_bearing(10.0), bearing.rotor_bearing(10.0, load_deg=0.0)
    assert down["speeds_rpm"] == [1000, 3000, 6000]
    assert down["z_mm"] == 10.0
    assert down["kyy_n_m"] == pytest.approx(along_x["kxx_n_m"])
    assert down["kxy_n_m"] == pytest.approx([-value for value in along_x["kyx_n_m"]])
    row = bearing.report["rows"][2]
    assert along_x["cxy_n_s_m"][1] == pytest.approx(row["damping_N_s_m"][0][1])


def test_a_film_that_breaks_is_no_support() -> None:
    bearing = ab.bearing({**FILM, "speed_rpm": [3000, 0.01]})
    with pytest.raises(JobError, match=r"no film carries the journal at 0\.01 1/min"):
        bearing.rotor_bearing(0.0)
