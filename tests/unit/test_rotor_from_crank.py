"""The straight rotor in a crank's place."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank_dynamics.rotor.from_crank import rectangle_torsion_mm4, throw_bending
from autobalance.crank_dynamics.torsion.chain import ThrowShape
from autobalance.errors import UsageError
from tests.coarse import bundled_corners
from tests.generated import preset_crank
from tests.jobs import write_stl

E_MPA, G_MPA = 210e3, 80e3


@pytest.fixture(scope="module")
def single() -> ab.Crank:
    return preset_crank("single", 48)


def test_a_throw_is_its_frame() -> None:
    shape = ThrowShape(60, 20, 40, 50, 0, 30, 45, 22, 90)
    journal, pin = math.pi / 64 * (60**4 - 20**4), math.pi / 64 * 50**4
    shafts = (40 / journal + 30 / pin) / E_MPA
    bent = 2 * 45 / (E_MPA * 90 * 22**3 / 12)
    twisted = 2 * 45 / (G_MPA * rectangle_torsion_mm4(90, 22))
    found = throw_bending(shape, E_MPA, G_MPA)
    assert found.in_plane_n_mm2 == pytest.approx(114 / (shafts + bent), rel=1e-12)
    assert found.across_n_mm2 == pytest.approx(114 / (shafts + twisted), rel=1e-12)
    assert found.in_plane_n_mm2 < found.mean_n_mm2 < found.across_n_mm2


def test_a_narrow_rectangle_twists_as_a_strip() -> None:
    assert rectangle_torsion_mm4(100.0, 1.0) == pytest.approx(100.0 / 3.0, rel=0.01)
    assert rectangle_torsion_mm4(1.0, 100.0) == rectangle_torsion_mm4(100.0, 1.0)


def test_the_rotor_has_mass_centre_and_inertia_of_the_crank(single: ab.Crank) -> None:
    report = ab.rotor(single, bearing_n_m=0, speed_rpm=0).report
    assert report["rigid_body_modes"] == 4
    assert report["mass_kg"] == pytest.approx(1e-3 * single.mass_g, rel=1e-3)
    start = report["equivalent"]["z_of_start_mm"]
    assert report["centre_of_mass_mm"] + start == pytest.approx(single.centre_of_mass_mm[2], abs=0.05)
    discs = report["input"]["disc"]
    assert sum(each["polar_kg_mm2"] for each in discs) == pytest.approx(single.polar_inertia_kg_mm2, rel=1e-6)
    z = np.array([each["z_mm"] + start for each in discs])
    mass = np.array([each["mass_kg"] for each in discs])
    across = sum(each["diametral_kg_mm2"] for each in discs) + mass @ z**2
    mean = 0.5 * (single.inertia_kg_mm2[0, 0] + single.inertia_kg_mm2[1, 1])
    assert across == pytest.approx(mean, rel=1e-6)
    assert report["modes"][0]["frequency_hz"] > 1000.0


def test_mains_hold_the_crank_and_the_worth_is_said(single: ab.Crank) -> None:
    result = ab.rotor(single, speed_rpm=6000)
    assert result.report["rigid_body_modes"] == 0
    assert [each["kind"] for each in result.report["input"]["bearing"]] == ["pinned", "pinned"]
    assert "estimate of size alone" in result.text()
    soft = ab.rotor(single, speed_rpm=6000, bearing_n_m=1e7).report
    assert soft["modes"][0]["frequency_hz"] < result.report["modes"][0]["frequency_hz"]


def test_what_is_refused(single: ab.Crank, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="--unit is for a crank"):
        ab.rotor({"shaft": [{"length_mm": 5, "outer_mm": 5}]}, unit="mm")
    with pytest.raises(UsageError, match="--bearing is -1"):
        ab.rotor(single, bearing_n_m=-1)
    with pytest.raises(UsageError, match="--speed-rpm is -1"):
        ab.rotor(single, speed_rpm=-1)
    file = single.write(tmp_path / "crank.stl", "mm")
    by_file = ab.rotor(file, unit="mm").report
    assert by_file["modes"][0]["frequency_hz"] == pytest.approx(
        ab.rotor(single).report["modes"][0]["frequency_hz"], rel=1e-3
    )


def test_the_deviation_from_the_solid_is_the_one_that_is_told(tmp_path: Path) -> None:
    # fem --no-crankpin on three meshes down to 14 mm: 1.61 kHz (± 0.04) in plane, 2.41 kHz (± 0.06) across
    file = tmp_path / "crank.stl"
    write_stl(file, bundled_corners())
    crank = ab.read_crank(file, "mm", crankpin_in_file=False)
    result = ab.rotor(crank, speed_rpm=0, bearing_n_m=0)
    first = result.report["modes"][0]["frequency_hz"]
    assert first == pytest.approx(1241.0, rel=0.01)
    assert first / 1610.0 - 1.0 == pytest.approx(-0.23, abs=0.02)
    assert "came out at 1.24 kHz" in result.text()
