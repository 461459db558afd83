"""Beam rotors against closed forms, publications and another program."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import autobalance as ab
from tests.reference import published

Values = dict[str, Any]
E_PA, NU, DENSITY = 210e9, 0.3, 7850.0
LENGTH_M, DIAMETER_M = 0.188, 0.02
PROMISED = 1e-5
"""Of a frequency, with the number of elements that is found."""
ROSS = json.loads((Path(__file__).parent / "rotors_by_ross.json").read_text("utf-8"))


def solved(**file: Any) -> Values:
    return ab.rotor({"speed_rpm": 0, **file}).report


def uniform(ends: tuple[str, str], **file: Any) -> Values:
    shaft = {"length_mm": 1e3 * LENGTH_M, "outer_mm": 1e3 * DIAMETER_M, "elements": file.pop("elements", 0)}
    places = zip((0.0, 1e3 * LENGTH_M), ends, strict=True)
    held = [{"z_mm": z, "kind": kind} for z, kind in places if kind != "free"]
    return solved(shaft=[shaft], bearing=held, **file)


def frequencies(report: Values) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return one frequency for each pair of planes."""
    return np.array([mode["frequency_hz"] for mode in report["modes"]])[::2]


# --- uniform beams ------------------------------------------------------------------------------------------

ROOTS: dict[tuple[str, str], tuple[Callable[[float], float], Callable[[int], float]]] = {
    ("pinned", "pinned"): (np.sin, lambda n: n * np.pi),
    ("free", "free"): (lambda x: np.cos(x) - 1.0 / np.cosh(x), lambda n: (n + 0.5) * np.pi),
    ("clamped", "clamped"): (lambda x: np.cos(x) - 1.0 / np.cosh(x), lambda n: (n + 0.5) * np.pi),
    ("clamped", "free"): (lambda x: np.cos(x) + 1.0 / np.cosh(x), lambda n: (n - 0.5) * np.pi),
    ("clamped", "pinned"): (lambda x: np.tan(x) - np.tanh(x), lambda n: (n + 0.25) * np.pi),
    ("pinned", "free"): (lambda x: np.tan(x) - np.tanh(x), lambda n: (n + 0.25) * np.pi),
}
"""Ends of a beam → its characteristic equation in βL, and about where the n-th root lies."""


def euler_hz(ends: tuple[str, str], count: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    equation, near = ROOTS[ends]
    roots = np.array(
        [brentq(equation, near(n) - 0.4, near(n) + 0.4, xtol=1e-13) for n in range(1, count + 1)]
    )
    radius = DIAMETER_M / 4.0
    found = roots**2 / LENGTH_M**2 * radius * np.sqrt(E_PA / DENSITY) / (2.0 * np.pi)
    return np.asarray(found)


@pytest.mark.parametrize("ends", list(ROOTS))
def test_five_modes_of_a_uniform_beam_with_every_usual_end(ends: tuple[str, str]) -> None:
    found = frequencies(uniform(ends, beam="euler", max_modes=10))
    assert found[:5] == pytest.approx(euler_hz(ends, 5), rel=PROMISED)


@pytest.mark.parametrize("beam", ["euler", "timoshenko"])
def test_classical_elements_converge_at_second_order_or_better(beam: str) -> None:
    ends = ("clamped", "free")
    exact = frequencies(uniform(ends, beam=beam, max_modes=10))
    errors = [
        np.abs(frequencies(uniform(ends, beam=beam, max_modes=10, elements=n))[:5] / exact[:5] - 1.0)
        for n in (16, 32)
    ]
    order = np.log2(errors[0] / errors[1])
    assert (order > 1.95).all()


def timoshenko_pinned_hz(number: int) -> float:
    """Solve Timoshenko's frequency equation of a pinned beam for its lower branch."""
    area, second = np.pi / 4.0 * DIAMETER_M**2, np.pi / 64.0 * DIAMETER_M**4
    shear = 6.0 * (1.0 + NU) / (7.0 + 6.0 * NU) * E_PA / (2.0 * (1.0 + NU)) * area
    k = number * np.pi / LENGTH_M
    a = DENSITY * area * DENSITY * second
    b = DENSITY * area * (shear + E_PA * second * k**2) + DENSITY * second * shear * k**2
    c = shear * E_PA * second * k**4
    return float(np.sqrt((b - np.sqrt(b**2 - 4.0 * a * c)) / (2.0 * a)) / (2.0 * np.pi))


def test_the_pinned_steel_shaft_by_both_theories() -> None:
    ends = ("pinned", "pinned")
    euler, timoshenko = (frequencies(uniform(ends, beam=beam)) for beam in ("euler", "timoshenko"))
    assert euler[0] == pytest.approx(1149.34, abs=0.005)
    assert timoshenko[0] == pytest.approx(1133.96, abs=0.005)
    assert timoshenko[:5] == pytest.approx([timoshenko_pinned_hz(n) for n in range(1, 6)], rel=PROMISED)


def test_a_cone_is_the_limit_of_many_cylinders() -> None:
    cone = frequencies(
        solved(shaft=[{"length_mm": 300, "outer_mm": 20, "outer_end_mm": 60, "inner_end_mm": 20}])
    )
    off = []
    for count in (30, 60):
        share = (np.arange(count) + 0.5) / count
        steps = [
            {"length_mm": 300 / count, "outer_mm": 20 + 40 * s, "inner_mm": 20 * s, "elements": 1}
            for s in share
        ]
        off.append(frequencies(solved(shaft=steps))[:3] / cone[:3] - 1.0)
    assert np.abs(off[1]).max() < 1e-3
    assert off[0] / off[1] == pytest.approx([4.0, 4.0, 4.0], rel=0.1)


# --- publications -------------------------------------------------------------------------------------------

INCH_MM = 25.4
STATIONS_INCH = (0, 0.5, 2, 3, 3.5, 4, 4.2, 4.5, 5, 5.3, 6.5, 7.5, 9, 10.5, 11.3, 12, 12.4, 13.6, 14)
OUTER_INCH = (0.2, 0.4, 0.3, 0.8, 0.8, 1.3, 1.3, 1, 1, 0.5, 0.5, 0.6, 0.6, 0.5, 0.5, 1.5, 0.8, 0.8)
INNER_INCH = {6: 0.6, 7: 0.7, 17: 0.6}
PUBLISHED_RPM = {"backward": [15470, 46612, 64752], "forward": [17159, 49983, 96457]}
NO_SHEAR = 1e6


def test_nelson_and_mcvaugh() -> None:
    """H. D. Nelson, J. M. McVaugh, J. Eng. Ind. 98 (1976) 593: critical speeds with isotropic bearings.

    Radii and stations are theirs in inches (printed in cm, rounded); their element has rotary inertia
    and gyroscopic moments but no shear.
    """
    shaft = [
        {
            "length_mm": INCH_MM * (b - a),
            "outer_mm": 2 * INCH_MM * OUTER_INCH[n],
            "inner_mm": 2 * INCH_MM * INNER_INCH.get(n, 0.0),
            "e_gpa": 207.8,
            "density_kg_m3": 7806,
            "shear_factor": NO_SHEAR,
        }
        for n, (a, b) in enumerate(pairwise(STATIONS_INCH))
    ]
    report = solved(
        speed_rpm=[0, 100000],
        points=2,
        shaft=shaft,
        disc=[{"z_mm": 88.9, "mass_kg": 1.401, "polar_kg_mm2": 2030, "diametral_kg_mm2": 1360}],
        bearing=[{"z_mm": INCH_MM * z, "k_n_m": 4.378e7} for z in (6.5, 11.3)],
    )
    for whirl, expected in PUBLISHED_RPM.items():
        found = [each["speed_rpm"] for each in report["criticals"] if each["whirl"] == whirl]
        assert found == pytest.approx(expected, rel=1.5e-3)


@pytest.mark.parametrize("name", list(ROSS["rotors"]))
def test_frequencies_and_response_of_another_program(name: str) -> None:
    case = ROSS["rotors"][name]
    for found, stored in zip(solved(**case["file"])["modes"], case["modes"], strict=False):
        assert found["frequency_hz"] == pytest.approx(stored["frequency_hz"], rel=1e-4)
        assert found["log_decrement"] == pytest.approx(stored["log_decrement"], abs=1e-4)
    for stored in case["response_at_first_disc"]:
        at = {**case["file"], "speed_rpm": stored["speed_rpm"], "max_modes": 2}
        point = solved(**at)["response"][0]["points"][0]
        for axis in "xy":
            assert point[f"{axis}_um"] == pytest.approx(stored[f"{axis}_um"], rel=1e-3)
            assert point[f"{axis}_phase_deg"] == pytest.approx(stored[f"{axis}_phase_deg"], abs=0.01)


# --- Jeffcott's rotor ---------------------------------------------------------------------------------------

DISC_KG, SHAFT_MM = 5.0, 20.0
WEIGHTLESS = 1e-6


def jeffcott(damping_ratio: float, eccentricity_um: float, **file: Any) -> tuple[Values, float]:
    """Return the report of a disc amid a weightless pinned shaft, and its critical speed [rad/s]."""
    stiffness = 48.0 * E_PA * np.pi / 64.0 * (1e-3 * SHAFT_MM) ** 4 / 1.0**3
    natural = float(np.sqrt(stiffness / DISC_KG))
    damper = 2.0 * damping_ratio * np.sqrt(stiffness * DISC_KG)
    file["speed_rpm"] = np.multiply(file.get("share", 1.0), 30.0 / np.pi * natural).tolist()
    file.pop("share", None)
    report = solved(
        beam="euler",
        max_modes=2,
        shaft=[{"length_mm": 1000, "outer_mm": SHAFT_MM, "density_kg_m3": WEIGHTLESS}],
        disc=[{"z_mm": 500, "mass_kg": DISC_KG}],
        bearing=[
            {"z_mm": 0, "kind": "pinned"},
            {"z_mm": 1000, "kind": "pinned"},
            {"z_mm": 500, "k_n_m": 0, "c_n_s_m": damper},
        ],
        unbalance=[{"z_mm": 500, "g_mm": DISC_KG * eccentricity_um, "angle_deg": 25}],
        **file,
    )
    return report, natural


def test_syn_04_jeffcott_amplitude() -> None:
    given = published.inputs("SYN-04") if "SYN-04" in published.CASES else {"e": 10.0, "s": 0.5, "z": 0.05}
    below, _ = jeffcott(given["z"], given["e"], share=given["s"])
    at, _ = jeffcott(given["z"], given["e"], share=1.0)
    point = below["response"][0]["points"][0]
    assert point["x_um"] == pytest.approx(3.32595053, rel=1e-6)
    lag = np.degrees(np.arctan2(2 * given["z"] * given["s"], 1.0 - given["s"] ** 2))
    assert point["x_phase_deg"] == pytest.approx(25.0 - lag, abs=1e-4)
    assert point["y_phase_deg"] == pytest.approx(25.0 - lag - 90.0, abs=1e-4)
    assert point["minor_um"] == pytest.approx(point["major_um"], rel=1e-9)
    peak = at["response"][0]["points"][0]
    assert peak["x_um"] == pytest.approx(100.0, rel=1e-6)
    assert peak["x_phase_deg"] == pytest.approx(25.0 - 90.0, abs=1e-3)


def test_a_run_through_resonance_is_the_convolution_with_the_impulse_response() -> None:
    ratio, microns, seconds = 0.05, 10.0, 1.0
    _, natural = jeffcott(ratio, microns)
    top = 2.0 * natural
    run = {"to_rpm": 30.0 / np.pi * top, "time_s": seconds, "points": 201}
    report, _ = jeffcott(ratio, microns, run_up=run)
    t = np.linspace(0.0, seconds, 200001)
    rate = top / seconds
    pull = microns * ((rate * t) ** 2 - 1j * rate) * np.exp(1j * (0.5 * rate * t**2 + np.radians(25.0)))
    damped = natural * np.sqrt(1.0 - ratio**2)
    impulse = np.exp(-ratio * natural * t) * np.sin(damped * t) / damped
    size = 1 << 19
    moved = np.fft.ifft(np.fft.fft(pull, size) * np.fft.fft(impulse, size))[: len(t)] * t[1]
    points = report["run_up"][0]["points"]
    found = np.array([point["x_um"] + 1j * point["y_um"] for point in points])
    assert np.abs(found - moved[::1000]).max() < 2e-3 * np.abs(moved).max()
    assert report["run_up"][0]["greatest_um"] == pytest.approx(np.abs(moved).max(), rel=2e-3)
    assert report["run_up"][0]["greatest_um"] < 100.0  # less than the steady peak, and later
    assert report["run_up"][0]["at_rpm"] > 30.0 / np.pi * natural
