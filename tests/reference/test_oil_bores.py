"""Outlets of oil bores in crankpins: the rule's factors, statics by hand, and a hole in a plate."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.crank_dynamics.strength.fatigue import (
    fatigue_strength_MPa,
    oil_bore_equivalent_MPa,
    oil_bore_factors,
)
from autobalance.errors import JobError
from tests.reference.test_fillets import FILLETS, STEEL, _first_moment_mm3, job, single

BORE = {"diameter_mm": 5.0}


IDEAL = {"bore_mm": 76.8, "compression_ratio": 12.0, "heat_J": 600.0, "gas": "ideal"}
"""Gas of high pressure, beside which what the pin's own oil hole pulls is small."""


def with_bore(**tables: Any) -> ab.Job:
    return job(strength={**FILLETS, "oil_bore": {**BORE, **tables.pop("oil_bore", {})}}, **tables)


@pytest.mark.parametrize(("bending", "torsion"), [(70.0, 0.0), (0.0, 55.0), (70.0, 55.0), (12.0, 90.0)])
def test_the_rules_equivalent_is_the_edge_of_a_hole_in_a_plate(bending: float, torsion: float) -> None:
    """Kirsch: σ_θ = σ (1 − 2 cos 2θ) − 4 τ sin 2θ along the edge of a small hole."""
    turn = np.linspace(0.0, math.tau, 200_001)
    edge = bending * (1.0 - 2.0 * np.cos(2.0 * turn)) - 4.0 * torsion * np.sin(2.0 * turn)
    factors = oil_bore_factors(1e-9, 50.0)
    local = factors.bending * bending, factors.torsion * torsion
    assert oil_bore_equivalent_MPa(*local) == pytest.approx(edge.max(), rel=1e-8)


def test_stress_is_that_of_main_bearing_and_metal_in_the_middle_of_the_pin() -> None:
    """Reactions of `cycle`, and the centrifugal force of the metal summed section by section."""
    pin, main = single().throws[0].crankpin, single().main_journals[0]
    solid = single().measured.source.solid.moved(single().file_to_rotor)
    low, middle = float(solid.bounds[0, 2]), float(pin.centre_mm[2])
    nodes, weights = np.polynomial.legendre.leggauss(3)
    ends = np.linspace(low, middle, 121)
    pull = sum(
        0.5 * (stop - start) * weight * _first_moment_mm3(solid.section(z)) * (middle - z)
        for start, stop in pairwise(ends)
        for node, weight in zip(nodes, weights, strict=True)
        for z in (float(0.5 * (start + stop) + 0.5 * (stop - start) * node),)
    )
    moment_along = 7.85e-3 * pull * (6000.0 * math.pi / 30.0) ** 2 * 1e-6
    modulus = math.pi / 32.0 * pin.diameter_mm**3
    for angle in (0.0, 90.0, 37.0):
        found = ab.strength(with_bore(oil_bore={"angle_deg": angle}, cycle=IDEAL), crank=single())
        main_n = found.analysis.loads.main_in_crank_frame_n()[0]  # of the crank on main 1
        moment = np.array([moment_along, 0.0]) - main_n * (middle - float(main.centre_mm[2]))
        away = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
        wanted = -moment @ away / modulus  # a load on the pin from outside presses its outer side
        (row,) = found.report["oil_bores"]
        scale = np.abs(wanted).max()
        assert row["nominal"]["bending_MPa"] == pytest.approx(
            [wanted.min(), wanted.max()], abs=4e-3 * scale
        )  # the pin's own oil hole pulls a little across
        assert row["angle_deg"] == pytest.approx(angle)
        fillet = next(each for each in found.report["fillets"] if each["place"] == "crankpin")
        assert row["nominal"]["torsion_MPa"] == fillet["nominal"]["torsion_MPa"]


def test_a_row_follows_the_rule() -> None:
    (row,) = ab.strength(with_bore(oil_bore={"angle_deg": 80.0}), crank=single()).report["oil_bores"]
    diameter = single().throws[0].crankpin.diameter_mm
    q = 5.0 / diameter
    assert row["factors"]["bending"] == pytest.approx(3.0 - 5.88 * q + 34.6 * q**2)
    assert row["factors"]["torsion"] == pytest.approx(4.0 - 6.0 * q + 30.0 * q**2)
    local = {}
    for name in ("bending", "torsion"):
        low, high = row["nominal"][f"{name}_MPa"]
        local[name] = row["factors"][name] * 0.5 * (high - low)
        assert row["stress"][f"{name}_alternating_MPa"] == pytest.approx(local[name])
    inner = math.sqrt(1.0 + 2.25 * (local["torsion"] / local["bending"]) ** 2)
    equivalent = local["bending"] / 3.0 * (1.0 + 2.0 * inner)
    assert row["stress"]["equivalent_alternating_MPa"] == pytest.approx(equivalent)
    bears = fatigue_strength_MPa(800.0, diameter, 2.5)
    assert row["fatigue_strength_MPa"] == pytest.approx(bears)
    assert row["m53"] == {
        "factor": pytest.approx(bears / equivalent),
        "wanted": 1.15,
        "met": bears / equivalent >= 1.15,
    }
    assert row["outside_of_range"] == []


def test_without_an_angle_the_worst_one_counts() -> None:
    (worst,) = ab.strength(with_bore(), crank=single()).report["oil_bores"]
    swings = [
        ab.strength(with_bore(oil_bore={"angle_deg": angle}), crank=single()).report["oil_bores"][0]["stress"]
        for angle in (0.0, 45.0, 90.0, 135.0)
    ]
    assert all(
        each["bending_alternating_MPa"] <= worst["stress"]["bending_alternating_MPa"] for each in swings
    )
    again = ab.strength(with_bore(oil_bore={"angle_deg": worst["angle_deg"]}), crank=single()).report
    assert again["oil_bores"][0]["stress"] == pytest.approx(worst["stress"], rel=1e-12)


def test_a_clockwise_engine_has_its_mirror_image() -> None:
    mesh = single().measured.source.solid.mesh
    mirrored = ab.crank_from_mesh(
        np.array(mesh.vertices) * [1, -1, 1], np.array(mesh.triangles)[:, ::-1], density_kg_m3=7850
    )
    engine = {**job().raw["engine"], "turns": "cw"}
    (here,) = ab.strength(with_bore(oil_bore={"angle_deg": 50.0}), crank=single()).report["oil_bores"]
    there = ab.strength(with_bore(oil_bore={"angle_deg": -50.0}, engine=engine), crank=mirrored).report
    assert there["oil_bores"][0]["nominal"]["bending_MPa"] == pytest.approx(
        here["nominal"]["bending_MPa"], rel=1e-6
    )
    assert there["oil_bores"][0]["stress"] == pytest.approx(here["stress"], rel=1e-6)


def test_vibration_counts_and_ranges_are_told() -> None:
    wide = with_bore(oil_bore={"diameter_mm": 12.0})
    found = ab.strength(wide, crank=single())
    (row,) = found.report["oil_bores"]
    assert row["outside_of_range"]
    assert row["outside_of_range"][0].startswith("oil bore over crankpin 1 = 0.")
    assert "Outlets of oil bores" in found.text()
    swinging = ab.strength(with_bore(oil_bore={"diameter_mm": 12.0}, torsion={}), crank=single())
    fillet = next(each for each in swinging.report["fillets"] if each["place"] == "crankpin")
    assert swinging.report["oil_bores"][0]["nominal"]["torsion_MPa"] == fillet["nominal"]["torsion_MPa"]
    assert fillet["nominal"]["torsion_MPa"] != row["nominal"]["torsion_MPa"]
    without = ab.strength(job(strength={**FILLETS, "material": STEEL}), crank=single())
    assert without.report["oil_bores"] == []
    assert "not computed without strength.oil_bore" in without.text()


def test_a_bore_as_wide_as_its_pin_is_refused() -> None:
    with pytest.raises(JobError, match=r"strength.oil_bore.diameter_mm is 200; crankpin 1 is .* mm thick"):
        ab.strength(with_bore(oil_bore={"diameter_mm": 200.0}), crank=single())
