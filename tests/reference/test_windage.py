"""Windage: Hoem & Røsholm (2016), Sec. 5.2.1, "As the air resistance is neglected": how much it is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.engines.cycle.windage import (
    Gas,
    WebShape,
    disc_windage,
    edge_windage,
    enclosed_disc_coefficient,
    free_disc_coefficients,
    rim_coefficient,
)
from autobalance.errors import JobError
from tests.coarse import bundled_corners
from tests.jobs import write_stl

AIR = Gas.air(20.0, 1.01325)
BENCH: dict[str, Any] = {
    "rotor": {
        "inertia_kg_mm2": 2847.335,
        "disc_mm": 98.0,
        "shaft_mm": 20.0,
        "length_mm": 188.0,
        "weight_N": 25.01,
    },
    "bearing": {
        "kind": "dry",
        "diameter_mm": 20.0,
        "small_angle": True,
        "mu_by_speed": [[3000, 0.7773], [6000, 1.2771], [9000, 1.4718]],
    },
    "windage": {},
}


def test_the_thesis_neglects_one_or_two_percent_of_the_friction() -> None:
    result = ab.bench(BENCH)
    rows = result.report["windage"]
    assert [row["speed_rpm"] for row in rows] == [3000.0, 6000.0, 9000.0]
    shares = [row["greatest_of_friction"] for row in rows]
    assert shares == sorted(shares)
    assert 0.002 < rows[0]["least_of_friction"] < 0.01
    assert 0.01 < rows[2]["greatest_of_friction"] < 0.03
    assert rows[2]["greatest_of_friction"] * 0.368 == pytest.approx(rows[2]["greatest_N_m"], rel=0.01)
    assert "Windage, an estimate" in result.text()
    assert b"Windage of disc and shaft" in result.plots()["bench-windage"]["svg"]


def test_coefficients_are_those_in_print() -> None:
    laminar, turbulent = free_disc_coefficients(1e5)
    assert laminar == pytest.approx(3.87 / math.sqrt(1e5))
    assert turbulent == pytest.approx(0.0146)
    # Daily and Nece's four states, each where it is the largest
    assert enclosed_disc_coefficient(1e3, 0.01) == pytest.approx(2.0 * math.pi / (0.01 * 1e3))
    assert enclosed_disc_coefficient(1e4, 0.1) == pytest.approx(3.7 * 0.1**0.1 / 100.0)
    assert enclosed_disc_coefficient(1e7, 0.1) == pytest.approx(0.102 * 0.1**0.1 / 1e7**0.2)
    # Theodorsen and Regier's implicit law, and the laminar cylinder
    root = math.sqrt(rim_coefficient(1e5))
    assert 1.0 / root == pytest.approx(-0.6 + 4.07 * math.log10(1e5 * root), rel=1e-9)
    assert rim_coefficient(10.0) == pytest.approx(0.4)


def test_the_laminar_disc_is_von_karmans_integral() -> None:
    # with the layer's wall shear G'(0) = 0.61592: M = 2 ∫ r τ 2π r dr = π G'(0) ρ √(ν Ω³) R⁴ for both faces
    speed, radius = 100.0, 0.05
    exact = math.pi * 0.61592 * AIR.density_kg_m3 * math.sqrt(AIR.viscosity_Pa_s / AIR.density_kg_m3)
    exact *= speed**1.5 * radius**4
    disc = disc_windage(radius, 0.0, AIR, speed, None)
    reynolds = AIR.density_kg_m3 * speed * radius**2 / AIR.viscosity_Pa_s
    size = 0.5 * AIR.density_kg_m3 * speed**2 * radius**5
    assert size * free_disc_coefficients(reynolds)[0] == pytest.approx(exact, rel=1e-3)
    assert disc.low_N_m <= exact * 1.001
    assert exact * 0.999 <= disc.high_N_m


def test_a_round_web_has_no_edges_and_a_half_disc_two() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    disc = WebShape.of_outline(np.full(720, 0.05), 0.02)
    assert disc.rises_m4 == 0.0
    assert disc.face_radius_m == pytest.approx(0.05)
    half = WebShape.of_outline(np.where(angle < np.pi, 0.05, 0.02), 0.02)
    assert half.rises_m4 == pytest.approx(0.05**4 - 0.02**4)
    # ½ C ρ (Ω r)² on the face between both radii, times r: C ρ Ω² b (R⁴ − r⁴)/8
    radii = np.linspace(0.02, 0.05, 20001)
    force = 0.5 * AIR.density_kg_m3 * (300.0 * radii) ** 2 * 0.02
    exact = 1.2 * float(np.trapezoid(force * radii, radii))
    assert edge_windage(half.rises_m4, 0.02, AIR, 300.0, cased=False).high_N_m == pytest.approx(
        exact, rel=1e-6
    )


def test_without_speed_or_without_gas_there_is_none() -> None:
    web = WebShape.of_outline(np.full(720, 0.05), 0.02)
    still = web.windage(AIR, 0.0, None)
    assert (still.low_N_m, still.high_N_m) == (0.0, 0.0)
    thin = web.windage(Gas.air(20.0, 1e-9), 500.0, None)
    # what is left is the laminar shear of the rim, 4 π μ Ω R² b, which knows no density
    assert thin.high_N_m / 1.2 == pytest.approx(
        4.0 * math.pi * AIR.viscosity_Pa_s * 500.0 * 0.05**2 * 0.02, rel=0.01
    )


def test_the_webs_of_a_crank_by_speed_and_oil(tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("windage") / "crank.stl"
    write_stl(path, bundled_corners("straight"))
    job: dict[str, Any] = {
        "crankshaft": {
            "file": str(path),
            "unit": "mm",
            "density_kg_m3": 7850.0,
            "crankpin_in_file": False,
        },
        "engine": {
            "rod_length_mm": 104.0,
            "rotating_g": {"rod": 134.0},
            "reciprocating_g": {"piston": 261.5},
            "crankpin_g": {"crankpin": 114.65},
        },
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 9000.0},
        "correction": {"method": "drill"},
        "cycle": {"bore_mm": 76.8, "compression_ratio": 13.0, "heat_J": 900.0},
    }

    def windage(**air: object) -> dict[str, Any]:
        raw = {**job, "cycle": {**job["cycle"], "friction": {"main_mu": 0.02}, "windage": air}}
        found: dict[str, Any] = ab.cycle(raw, 9000.0, [0.5]).report["windage"]
        return found

    dry, wet = windage(gap_mm=3.0), windage(gap_mm=3.0, oil_kg_m3=[0.0, 5.0])
    assert dry["least_N_m"] < dry["greatest_N_m"] < wet["greatest_N_m"]
    assert wet["least_N_m"] == dry["least_N_m"]
    assert [web["face_radius_mm"] for web in dry["webs"]] == pytest.approx([48.0, 48.0], abs=4.0)
    assert dry["of_friction"][0] < dry["of_friction"][1] < 1.0


def test_windage_needs_the_rotors_shape_and_a_range() -> None:
    with pytest.raises(JobError, match="windage needs the shape"):
        ab.bench({**BENCH, "rotor": {"inertia_kg_mm2": 2847.335, "mass_kg": 2.5}})
    with pytest.raises(JobError, match="the first must be the lower"):
        ab.bench({**BENCH, "windage": {"oil_kg_m3": [2.0, 1.0]}})
