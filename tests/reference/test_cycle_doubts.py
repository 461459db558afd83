"""Bearings of an articulated engine as they are; warnings where a cycle's models are not to be trusted."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.errors import JobError
from tests.generated import preset_crank

Values = dict[str, Any]


def preset(name: str) -> ab.Crank:
    return preset_crank(name)


def radial(**cycle: Any) -> Values:
    links = [
        {
            "cylinder": n + 2,
            "bank_deg": bank,
            "rod_length_mm": 108.0,
            "knuckle_radius_mm": 32.0,
            "knuckle_angle_deg": bank,
        }
        for n, bank in enumerate((72.0, 144.0, 216.0, 288.0))
    ]
    return {
        "engine": {
            "rod_length_mm": 140.0,
            "rotating_g": {"rod_share": 210.0},
            "reciprocating_g": {"piston": 260.0},
            "layout": {"kind": "articulated", "bank_deg": 0.0},
            "throw": [{"number": 1, "link": links}],
        },
        "balance": {"factor": 0.5, "grade": 16, "speed_rpm": 3600},
        "correction": {"method": "drill"},
        "cycle": {
            "bore_mm": 70.0,
            "compression_ratio": 8.0,
            "heat_J": 620.0,
            "firing_order": [1, 3, 5, 2, 4],
            "gas": "ideal",
            **cycle,
        },
    }


def test_an_articulated_engine_has_one_big_end_that_carries_all_rods() -> None:
    film = {"main_clearance_mm": 0.03, "crankpin_clearance_mm": 0.05, "viscosity_Pa_s": 0.02}
    result = ab.cycle(radial(film=film), crank=preset("single"))
    (end,) = result.report["films"]["big_ends"]
    assert end["number"] == 1
    pin = preset("single").throws[0].crankpin
    # the same film by itself: all of the crankpin's load, all of its width, turning under the master rod
    loads = result.report["loads"]
    assert loads["crankpins"][0]["greatest_N"] == pytest.approx(13629.0, rel=1e-3)
    assert [row.get("on") for row in loads["big_ends"]] == ["no bearing", *["knuckle pin"] * 4]
    orbit = own_orbit(result, pin.diameter_mm, pin.width_mm, 0.05, 0.02)
    assert end["least_film_mm"] == pytest.approx(orbit, rel=5e-3)
    text = result.text()
    assert "knuckle pin of cylinder 2" in text
    assert "master rod without its links, cylinder 1" in text
    assert "big end of cylinder 2" not in text


def own_orbit(result: Any, diameter: float, width: float, clearance: float, viscosity: float) -> float:
    """Least film [mm] of Ocvirk's short bearing under the crankpin's whole load, followed by Heun's steps.

    Half film by its impedance: the journal turns at Ω in a bush that swings about zero.
    """
    analysis = result.analysis
    grid = analysis.grid
    load = analysis.crankpins_n[0]
    fine, even = np.arange(0.0, 720.0, 0.05), np.degrees(grid.even_rad)
    fx, fy = (np.interp(fine, even, grid.even(load[:, k]), period=720.0) for k in (0, 1))
    force = -(fx + 1j * fy)  # on the journal's film, of the rod's bush: the journal is pressed by −load
    omega = analysis.speed_rad_s
    gain = 2.0 * (clearance * 1e-3) ** 2 / (viscosity * diameter * 0.5e-3 * (width * 1e-3) ** 3)
    step = math.radians(0.05) / omega

    def speed(e: complex, f: complex) -> complex:
        """Booth's mobility of the short bearing: velocity over the clearance, in the bush's frame."""
        size = abs(f)
        if size == 0.0:
            return complex(0.5j * omega * e)
        zeta = e * np.conj(f) / size  # along and across the load
        x, y = zeta.real, zeta.imag
        m_x = (1.0 - x) ** 2.5 / math.pi
        m_y = -4.0 * y * (1.0 - x) ** 1.5 / math.pi**2
        return complex(0.5j * omega * e + gain * complex(m_x, m_y) * f)

    e, least = 0.1 + 0.0j, 1.0
    for turn in range(6):
        for n in range(len(force)):
            f0, f1 = force[n], force[(n + 1) % len(force)]
            k1 = speed(e, f0)
            k2 = speed(e + step * k1, f1)
            e += 0.5 * step * (k1 + k2)
            if abs(e) > 0.9999:
                e *= 0.9999 / abs(e)
            if turn == 5:
                least = min(least, 1.0 - abs(e))
    return least * clearance


def test_gas_without_wall_heat_and_a_swinging_speed_are_doubted() -> None:
    report = ab.cycle(radial(), crank=preset("single")).report
    efficiency = report["cylinder"]["thermal_efficiency"]
    assert efficiency == pytest.approx(0.49, abs=0.01)
    gas, swing = report["warnings"]
    assert f"constant gamma and no wall heat: an efficiency of {100.0 * efficiency:.0f} %" in gas
    assert f"{report['cylinder']['peak_temperature_K']:.0f} K" in gas
    assert 'set cycle.gas = "real"' in gas
    speed = report["speed"]
    low, high = speed["least_rpm"], speed["greatest_rpm"]
    assert f"swings from {low:.0f} to {high:.0f} rpm within a cycle" in swing
    assert (high - low) / speed["mean_rpm"] > 0.1


def test_burning_gas_is_real_unless_a_job_says_otherwise() -> None:
    """Wall heat and γ(T) together: an efficiency that engines have, and energy that goes nowhere else."""
    first = ab.cycle(radial(gas="real", flywheel_kg_mm2=4e5), crank=preset("single"))
    report, told = first.report, first.report["input"]["cycle"]
    assert (told["gas"], told["wall_heat"], told["gamma_per_K"]) == ("real", "woschni", -7e-5)
    assert report["warnings"] == []
    one = report["cylinder"]
    assert 0.3 < one["thermal_efficiency"] < 0.45
    assert one["peak_temperature_K"] < 2800.0
    # d(p V) = (γ − 1)(dQ − dQ_wall − p dV): heat less wall heat less work is what is left in the gas
    gas = first.analysis.firing.cycles[0]
    low, high = gas.known_rad
    volume = gas.chamber.volume_mm3(np.array([low, high - 1e-4]))
    held = gas.pressure_mpa(np.array([low, high - 1e-4])) * volume
    angle = np.linspace(low, high - 1e-4, 200001)
    inside = gas.chamber.volume_mm3(angle)
    state = gas.pressure_mpa(angle, inside) * inside
    gamma = 1.35 - 7e-5 * 330.0 * (state / held[0] - 1.0)
    inner = float(np.trapezoid(1.0 / (gamma - 1.0), state))
    left = 1e3 * (620.0 - one["wall_heat_J"] - one["closed_work_J"])
    assert inner == pytest.approx(left, rel=2e-4)
    default = radial(flywheel_kg_mm2=4e5)
    del default["cycle"]["gas"]
    assert ab.cycle(default, crank=preset("single")).report["cylinder"] == one


@pytest.mark.parametrize(
    "stated", [{"gas": "ideal"}, {"wall_heat": "none"}, {"gamma": 1.35}, {"gamma_per_K": 0.0}]
)
def test_one_key_brings_back_the_ideal_gas(stated: Values) -> None:
    ideal = ab.cycle(radial(), crank=preset("single")).report["cylinder"]
    job = radial(**stated)
    if "gas" not in stated:
        del job["cycle"]["gas"]
    assert ab.cycle(job, crank=preset("single")).report["cylinder"] == ideal


def test_too_cold_and_too_hot_gas_is_doubted() -> None:
    late = radial(gas="real", flywheel_kg_mm2=4e5, start_deg=60.0)
    (cold,) = ab.cycle(late, crank=preset("single")).report["warnings"]
    assert "engines have 25 to 45 %" in cold
    assert "check start_deg" in cold
    (hot,) = ab.cycle(radial(gas="real", flywheel_kg_mm2=4e5, heat_J=900.0), crank=preset("single")).report[
        "warnings"
    ]
    assert "up to 2800 K" in hot
    assert "give less heat_J" in hot


def test_orbits_wider_than_the_bearings_clearance_are_doubted() -> None:
    job: Values = {
        "engine": {
            "rod_length_mm": 104.0,
            "rotating_g": {"big_end": 134.0},
            "reciprocating_g": {"piston": 260.0},
        },
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 6000},
        "correction": {"method": "drill"},
        "cycle": {"bore_mm": 76.8, "compression_ratio": 12.0, "heat_J": 600.0, "flywheel_kg_mm2": 90000.0},
        "bearings": {"k_N_mm": 1e5},
    }
    soft = ab.cycle(job, crank=preset("single"), flexible=True).report
    orbit = max(each["greatest_orbit_um"] for each in soft["flexible"]["main_journals"])
    assert orbit > 30.0  # a thousandth of the journals' 30 mm
    (told,) = [text for text in soft["warnings"] if "on its spring" in text]
    number = next(
        each["number"] for each in soft["flexible"]["main_journals"] if each["greatest_orbit_um"] > 30.0
    )
    assert f"main {number} moves" in told
    assert "more than a usual radial clearance of 30 µm" in told
    stiff = ab.cycle({**job, "bearings": {"k_N_mm": 2e6}}, crank=preset("single"), flexible=True).report
    assert not [text for text in stiff["warnings"] if "on its spring" in text]


def test_weights_of_a_link_may_have_names() -> None:
    """A table of named weights is their sum, as everywhere else; a number stays one."""
    numbers, named = radial(), radial()
    for link in numbers["engine"]["throw"][0]["link"]:
        link.update(rotating_g=200.0, reciprocating_g=250.0)
    for link in named["engine"]["throw"][0]["link"]:
        link.update(rotating_g={"rod": 180.0, "pin": 20.0}, reciprocating_g={"piston": 210.0, "rings": 40.0})
    one, other = (ab.forces(each, crank=preset("single")).report for each in (numbers, named))
    assert one["roll"] == other["roll"]
    assert one["states"] == other["states"]
    named["engine"]["throw"][0]["link"][1]["rotating_g"] = {"rod": -1.0}
    with pytest.raises(JobError, match=r"engine\.throw\[1\]\.link\[2\]\.rotating_g\.rod is -1; must be ≥ 0"):
        ab.forces(named, crank=preset("single"))
