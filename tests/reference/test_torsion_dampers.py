"""Tuned dampers: on one inertia and one spring they are Den Hartog's and Houdaille's."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.errors import JobError

Values = dict[str, Any]
J, K, TORQUE = 0.02, 3e4, 10.0
OWN = math.sqrt(K / J)
WALL = 1e9
"""Inertia of what stands still [kg·mm²]."""


def damped(kind: str, ratio: float, **damper: Any) -> Values:
    """Return the report of one inertia on a spring to a wall, order 1 exciting it over its resonance."""
    rpm = OWN * 30.0 / math.pi
    return ab.torsion(
        {
            "speed_rpm": [0.3 * rpm, 2.0 * rpm],
            "points": 2001,
            "inertia": [{"kg_mm2": WALL}, {"kg_mm2": 1e6 * J}],
            "spring": [{"N_m_rad": K}],
            "excitation": [{"station": 2, "order": 1, "N_m": TORQUE}],
            "damper": [{"station": 2, "kind": kind, "inertia_kg_mm2": 1e6 * J * ratio, **damper}],
        }
    ).report


@pytest.mark.parametrize("ratio", [0.1, 0.3])
def test_the_best_ring_is_den_hartogs(ratio: float) -> None:
    found = damped("ring", ratio, tune=True)["dampers"][0]
    rule = found["rule"]
    assert rule["mass_ratio"] == pytest.approx(ratio, rel=1e-4)
    assert rule["mode_hz"] == pytest.approx(OWN / (2.0 * math.pi), rel=1e-4)
    assert rule["frequency_ratio"] == pytest.approx(1.0 / (1.0 + ratio), rel=1e-4)
    peak = found["greatest_twist_mrad"] / (1e3 * TORQUE / K)
    assert peak == pytest.approx(math.sqrt(1.0 + 2.0 / ratio), rel=5e-3)
    assert found["N_m_rad"] == pytest.approx(rule["N_m_rad"], rel=0.02)
    assert found["N_m_s_rad"] == pytest.approx(rule["N_m_s_rad"], rel=0.05)


@pytest.mark.parametrize("ratio", [0.3, 1.0])
def test_the_best_viscous_damper_is_houdailles(ratio: float) -> None:
    found = damped("viscous", ratio, tune=True)["dampers"][0]
    assert found["greatest_twist_mrad"] / (1e3 * TORQUE / K) == pytest.approx(1.0 + 2.0 / ratio, rel=5e-3)
    assert found["N_m_s_rad"] == pytest.approx(found["rule"]["N_m_s_rad"], rel=0.05)
    assert found["rule"]["frequency_ratio"] is None


def test_the_heat_of_a_damper_is_the_work_of_what_excites() -> None:
    """Nothing else damps: the mean power of the torque is the damper's heat, at every speed."""
    report = damped("viscous", 0.5, N_m_s_rad=8.0)
    assert report["damping"] == {"ratio": 0.0, "dampers": True}
    mass = np.diag([WALL * 1e-6, J, 0.5 * J])
    spring = K * np.array([[1, -1, 0], [-1, 1, 0], [0, 0, 0]])
    damper = 8.0 * np.array([[0, 0, 0], [0, 1, -1], [0, -1, 1]])
    for row in report["dampers"][0]["heat_W"][::400]:
        w = row["speed_rpm"] * math.pi / 30.0
        angle = np.linalg.solve(spring + 1j * w * damper - w**2 * mass, [0.0, TORQUE, 0.0])
        power = 0.5 * TORQUE * (1j * w * angle[1]).real
        assert row["heat_W"] == pytest.approx(power, rel=1e-9)


def test_tuning_needs_something_that_excites() -> None:
    file: Values = {
        "inertia": [{"kg_mm2": 1e4}, {"kg_mm2": 2e4}],
        "spring": [{"N_m_rad": 1e4}],
        "damper": [{"station": 1, "kind": "viscous", "inertia_kg_mm2": 1e3, "tune": True}],
    }
    with pytest.raises(JobError, match=r"damper\[1\].tune needs torques in the range of speeds; found none"):
        ab.torsion(file)
