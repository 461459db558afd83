"""Torsional vibration through a run-up: its limits, its energy, and a second integration.

A resonance passed at a rate is lower than steady and comes late (F. M. Lewis, Vibration during acceleration
through a critical speed, Trans. ASME 54 (1932) 253-261).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import autobalance as ab
from autobalance.errors import JobError

TWO: dict[str, Any] = {
    "inertia": [{"name": "crank", "kg_mm2": 20000.0}, {"name": "flywheel", "kg_mm2": 50000.0}],
    "spring": [{"N_m_rad": 20000.0, "diameter_mm": 30.0}],
    "excitation": [{"station": 1, "order": 2.0, "N_m": 50.0}],
    "torsion": {"damping_ratio": 0.01},
    "speed_rpm": [3000.0, 7000.0],
}
CRITICAL_RPM = 5649.44
COUPLED = [
    {"station": 1, "torque_N_m": [0.0, 100.0, 300.0], "twist_rad": [0.0, 0.005, 0.01], "mean_N_m": 50.0}
]


def run_up(rate: float, low: float = 4500.0, high: float = 6500.0, **tables: Any) -> dict[str, Any]:
    ramp = {"from_rpm": low, "to_rpm": high, "ramp_rpm_s": rate}
    found: dict[str, Any] = ab.torsion({**TWO, "run_up": ramp, **tables}).report["run_up"]
    return found


def test_a_slow_ramp_gives_the_steady_peak() -> None:
    peaks = [run_up(rate, 5400.0, 5900.0)["shafts"][0] for rate in (1000.0, 200.0, 40.0)]
    shares = [each["greatest_torque_N_m"] / each["steady_torque_N_m"] for each in peaks]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0, abs=0.003)
    for each in peaks:  # T J₂/(J₁ + J₂) raised by 1/(2 ζ), though no speed of the plot meets the resonance
        assert each["steady_torque_N_m"] == pytest.approx(50.0 * (5.0 / 7.0) / (2.0 * 0.01), rel=2e-4)
        assert each["steady_at_rpm"] == pytest.approx(CRITICAL_RPM, rel=2e-4)
    late = [each["at_rpm"] - CRITICAL_RPM for each in peaks]
    assert late[0] > late[1] > late[2] > 0.0


def test_a_run_down_passes_the_resonance_early_below_it() -> None:
    down = run_up(2000.0, 6500.0, 4500.0)["shafts"][0]
    assert down["at_rpm"] < CRITICAL_RPM
    up = run_up(2000.0)["shafts"][0]
    assert down["greatest_torque_N_m"] == pytest.approx(up["greatest_torque_N_m"], rel=0.05)


@pytest.mark.parametrize("rate", [300.0, 3000.0])
def test_work_is_found_again_in_damping_and_strain(rate: float) -> None:
    found = run_up(rate)
    assert found["work_J"] > 0.0
    assert found["energy_error"] < 1e-9


def test_an_undamped_resonance_is_passed_as_fresnels_integrals_say() -> None:
    # no damping: the envelope of x'' + ω² x = (T/J) cos(ψ(t)) past the resonance is
    # (T/(2 J ω)) |∫ e^{i (ψ(s) − ω s)} ds|, whose limit is √(2 π/(n a)) with the order n and the rate a
    rate = 2000.0
    found = run_up(rate, 3500.0, 7800.0, torsion={"damping_ratio": 0.0})
    last = found["points"][-1]["torque_N_m"][0]
    inertia = 1.0 / (1.0 / 0.02 + 1.0 / 0.05)
    omega = 2.0 * CRITICAL_RPM * math.pi / 30.0
    acceleration = 2.0 * rate * math.pi / 30.0
    begin = (3500.0 - CRITICAL_RPM) * 2.0 * math.pi / 30.0 / acceleration
    end = (7800.0 - CRITICAL_RPM) * 2.0 * math.pi / 30.0 / acceleration
    parts = (
        quad(lambda s: math.cos(0.5 * acceleration * s**2), begin, end, limit=4000)[0],
        quad(lambda s: math.sin(0.5 * acceleration * s**2), begin, end, limit=4000)[0],
    )
    # 50 N·m at the crank: 50 · J/J_crank twists the shaft as on one inertia J = J1 J2/(J1 + J2)
    swing = 50.0 * (inertia / 0.02) / (2.0 * inertia * omega) * math.hypot(*parts)
    assert math.hypot(*parts) == pytest.approx(math.sqrt(2.0 * math.pi / acceleration), rel=0.1)
    assert last == pytest.approx(20000.0 * swing, rel=0.05)


@pytest.mark.parametrize("stiffness", [1e7, 1e10])
def test_a_rigid_shaft_carries_what_turns_the_other_inertia(stiffness: float) -> None:
    """Limit k → ∞: of a torque T on one inertia the shaft carries T J₂/(J₁ + J₂), at any rate.

    The stiffest swings a thousand times as fast as its torque: a step of the torque's has many turns of it.
    """
    rigid = [{"N_m_rad": stiffness, "diameter_mm": 30.0}]
    omega = 2.0 * 6500.0 * math.pi / 30.0
    raised = 1.0 / (1.0 - omega**2 / (stiffness / 0.02 + stiffness / 0.05))
    for rate in (500.0, 20000.0):
        found = run_up(rate, spring=rigid)
        (shaft,) = found["shafts"]
        assert shaft["greatest_torque_N_m"] == pytest.approx(raised * 50.0 * 50.0 / 70.0, rel=5e-4)
        assert found["energy_error"] < 1e-5


def test_two_integrations_agree() -> None:
    exact = run_up(3000.0)["shafts"][0]
    # a coupling whose two slopes are almost one takes the other way, by Runge and Kutta
    nearly = [{"station": 1, "torque_N_m": [0.0, 100.0, 200.0000004], "twist_rad": [0.0, 0.005, 0.01]}]
    found = run_up(3000.0, coupling=nearly)
    assert found["nonlinear"]
    assert found["shafts"][0]["greatest_torque_N_m"] == pytest.approx(exact["greatest_torque_N_m"], rel=1e-5)


@pytest.mark.slow
def test_a_coupling_that_hardens_and_dry_friction_change_the_peak() -> None:
    linear = run_up(6000.0, 5000.0)["shafts"][0]["greatest_torque_N_m"]
    hard = run_up(6000.0, 5000.0, coupling=COUPLED)
    assert hard["nonlinear"]
    assert hard["energy_error"] < 1e-6
    assert hard["shafts"][0]["greatest_torque_N_m"] < 0.8 * linear
    rubbed = run_up(
        6000.0,
        5000.0,
        coupling=[
            {"station": 1, "torque_N_m": [0.0, 100.0], "twist_rad": [0.0, 0.005], "friction_N_m": 20.0}
        ],
    )
    assert rubbed["energy_error"] < 1e-6
    assert rubbed["shafts"][0]["greatest_torque_N_m"] < 0.7 * linear


def test_text_plots_and_steady_curve() -> None:
    ramp = {"from_rpm": 4500.0, "to_rpm": 6500.0, "ramp_rpm_s": 2000.0}
    result = ab.torsion({**TWO, "run_up": ramp})
    assert "Run-up from 4500 to 6500 rpm at 2000 rpm/s" in result.text()
    assert "torsion-run-up" in result.plots()
    points = result.report["run_up"]["points"]
    steady = np.array([each["steady_torque_N_m"][0] for each in points])
    speeds = np.array([each["speed_rpm"] for each in points])
    assert speeds[int(steady.argmax())] == pytest.approx(CRITICAL_RPM, abs=20.0)
    assert "run_up" not in ab.torsion(TWO).report


@pytest.mark.parametrize(
    ("ramp", "words"),
    [
        ({"from_rpm": 3000.0, "to_rpm": 3000.0, "ramp_rpm_s": 10.0}, "as from_rpm"),
        ({"from_rpm": 1000.0, "to_rpm": 6000.0, "ramp_rpm_s": 0.1}, "a faster ramp_rpm_s"),
    ],
)
def test_an_impossible_ramp_is_refused(ramp: dict[str, float], words: str) -> None:
    with pytest.raises(JobError, match=words):
        ab.torsion({**TWO, "run_up": ramp})
