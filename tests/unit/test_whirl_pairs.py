"""Whirl where forward and backward modes share a frequency, and rotors that numbers cannot hold."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank_dynamics.rotor.whirl_modes import whirl_of_orbits, with_circular_pairs
from autobalance.errors import JobError


def rotor(**changes: Any) -> dict[str, Any]:
    """Return a rotor on equal bearings with its disc at mid-span, where the disc does not tilt."""
    return {
        "speed_rpm": [500, 3000],
        "points": 3,
        "max_modes": 4,
        "beam": "euler",
        "shaft": [{"length_mm": 1000, "outer_mm": 40}],
        "disc": [{"z_mm": 500, "mass_kg": 20, "polar_kg_mm2": 250000, "diametral_kg_mm2": 130000}],
        "bearing": [{"z_mm": z, "k_n_m": 1e7} for z in (0, 1000)],
        "unbalance": [{"z_mm": 500, "g_mm": 100}],
        **changes,
    }


def test_a_pair_of_one_frequency_is_told_as_both_circles_and_one_critical_speed() -> None:
    report = ab.rotor(rotor()).report
    assert [mode["whirl"] for mode in report["modes"]] == ["backward", "forward"] * 2
    one, other = (mode["frequency_hz"] for mode in report["modes"][:2])
    assert one == pytest.approx(other, rel=1e-9)
    assert len(report["criticals"]) == 1
    assert report["criticals"][0]["speed_rpm"] == pytest.approx(60.0 * one, rel=1e-9)
    assert "passes 1 critical speed" in ab.rotor(rotor()).text()


def test_any_mixture_of_a_pair_splits_into_its_circles() -> None:
    rng = np.random.default_rng(5)
    shape = rng.normal(size=4)
    circles = np.zeros((8, 2), dtype=complex)
    circles[0::2, :], circles[1::2, 0], circles[1::2, 1] = shape[:, None], 1j * shape, -1j * shape
    mixture = rng.normal(size=(2, 2)) + 1j * rng.normal(size=(2, 2))
    value = 0.1 + 200.0j
    made = with_circular_pairs(np.array([value, value * (1.0 + 1e-12)]), circles @ mixture)
    whirls = [whirl_of_orbits(each[0::2], each[1::2]) for each in made.T]
    assert whirls == ["backward", "forward"]


def test_a_nearly_massless_shaft_has_the_modes_of_its_disc_alone() -> None:
    bare: dict[str, Any] = {"beam": "timoshenko", "unbalance": [], "max_modes": 12}
    disc = {"z_mm": 400, "mass_kg": 20, "polar_kg_mm2": 250000, "diametral_kg_mm2": 130000}
    found = {
        density: ab.rotor(
            rotor(**bare, disc=[disc], shaft=[{"length_mm": 1000, "outer_mm": 40, "density_kg_m3": density}])
        ).report["modes"]
        for density in (1e-2, 1e-7)
    }
    assert len(found[1e-7]) == 4  # the disc moves and tilts in two planes; nothing else has a mass
    for light, lighter in zip(found[1e-2], found[1e-7], strict=False):
        assert lighter["frequency_hz"] == pytest.approx(light["frequency_hz"], rel=1e-4)


def test_a_shaft_so_stiff_that_its_bearings_are_lost_in_rounding_is_refused() -> None:
    stiff = [{"length_mm": 1000, "outer_mm": 400, "e_gpa": 1e9}]
    soft = [{"z_mm": z, "k_n_m": 1e3} for z in (0, 1000)]
    with pytest.raises(JobError, match=r"times as stiff as bearing\[1\]; expected at most 1e\+13 times"):
        ab.rotor(rotor(shaft=stiff, bearing=soft))
