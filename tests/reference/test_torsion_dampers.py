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


# --- by the strain of the crank's own shafts, between speeds too --------------------------------------------


def one_mass_peak(mu: float, c: float, zeta: float = 0.0) -> float:
    """Greatest twist of one mass on a spring with a viscous ring over the static one, on a fine grid."""
    ratio = np.linspace(0.3, 2.0, 400001)
    w = ratio * OWN
    ring = mu * J
    link = 1j * w * c
    coupled = link * (-(w**2) * ring) / (link - w**2 * ring)
    angle = TORQUE / (K - w**2 * J + 2j * zeta * math.sqrt(K * J) * w + coupled)
    return float(np.abs(angle).max() * K / TORQUE)


@pytest.mark.parametrize("mu", [0.03, 0.05, 0.2])
def test_a_viscous_damper_is_tuned_to_half_a_percent(mu: float) -> None:
    """Peak and damping are Houdaille's, and what is told of the peak is its height, not its neighbour's."""
    found = damped("viscous", mu, tune=True)["dampers"][0]
    best = 1.0 / math.sqrt(2.0 * (1.0 + mu) * (2.0 + mu))
    assert found["N_m_s_rad"] == pytest.approx(2.0 * best * mu * J * OWN, rel=5e-3)
    peak = found["greatest_twist_mrad"] / (1e3 * TORQUE / K)
    assert peak == pytest.approx(1.0 + 2.0 / mu, rel=1e-3)
    assert peak == pytest.approx(one_mass_peak(mu, found["N_m_s_rad"]), rel=1e-5)
    assert found["greatest"]["torque_N_m"] == pytest.approx(peak * TORQUE, rel=1e-6)
    assert found["search_ended_at"] is None


def test_with_and_without_have_the_same_damping() -> None:
    bare = damped("viscous", 0.03, N_m_s_rad=0.5)["dampers"][0]
    assert bare["greatest_twist_without_mrad"] is None
    assert bare["modal_damping_ratio"] == 0.0
    rpm = OWN * 30.0 / math.pi
    file: Values = {
        "speed_rpm": [0.3 * rpm, 2.0 * rpm],
        "points": 101,
        "torsion": {"damping_ratio": 0.01},
        "inertia": [{"kg_mm2": WALL}, {"kg_mm2": 1e6 * J}],
        "spring": [{"N_m_rad": K}],
        "excitation": [{"station": 2, "order": 1, "N_m": TORQUE}],
        "damper": [{"station": 2, "kind": "viscous", "inertia_kg_mm2": 3e4 * J, "tune": True}],
    }
    result = ab.torsion(file)
    found = result.report["dampers"][0]
    static = 1e3 * TORQUE / K
    without = 1.0 / (2.0 * 0.01 * math.sqrt(1.0 - 0.01**2))
    assert found["greatest_twist_without_mrad"] == pytest.approx(without * static, rel=5e-5)  # the wall moves
    assert found["greatest_twist_mrad"] < 0.7 * found["greatest_twist_without_mrad"]
    assert "undamped: no limit" in ab.torsion({**file, "torsion": {"damping_ratio": 0.0}}).text()


CRANK = [0.004, 0.008, 0.008, 0.09]
SHAFTS = [6e5, 4e5, 5e5]
LOAD, SOFT, RING = 0.3, 2000.0, 0.006
TORQUES = {2.0: 400.0, 6.0: 150.0}
RANGE = (1000.0, 8000.0)


def crank_torque(c: float, zeta: float = 0.005) -> float:
    """Greatest torque in the crank's own shafts, by own matrices on a fine grid of speeds."""
    n = len(CRANK)
    inertia = np.array([*CRANK, LOAD, RING])
    stiff = np.zeros((n + 2, n + 2))
    for at, k in enumerate([*SHAFTS, SOFT]):
        stiff[at : at + 2, at : at + 2] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    viscous = np.zeros((n + 2, n + 2))
    viscous[np.ix_([0, n + 1], [0, n + 1])] = c * np.array([[1.0, -1.0], [-1.0, 1.0]])
    square, shapes = np.linalg.eig(np.diag(1.0 / inertia) @ stiff)
    shapes = shapes / np.sqrt((shapes**2 * inertia[:, None]).sum(axis=0))
    omega = np.sqrt(np.maximum(square.real, 0.0))
    omega[omega < 1.0] = 0.0
    moved = inertia[:, None] * shapes
    modal = (2.0 * zeta * omega) * moved @ moved.T
    most = 0.0
    for order, torque in TORQUES.items():
        w = order * np.linspace(*RANGE, 20001) * math.pi / 30.0
        drive = np.zeros((len(w), n + 2, 1), dtype=complex)
        drive[:, 1] = torque
        dynamic = stiff + 1j * w[:, None, None] * (viscous + modal) - w[:, None, None] ** 2 * np.diag(inertia)
        angle = np.linalg.solve(dynamic, drive)[..., 0]
        carried = np.abs(np.array(SHAFTS) * np.diff(angle[:, :n], axis=1))
        most = max(most, float(carried.max()))
    return most


def soft_train(**damper: Any) -> Values:
    return {
        "speed_rpm": list(RANGE),
        "points": 51,
        "torsion": {"damping_ratio": 0.005},
        "inertia": [{"kg_mm2": 1e6 * each} for each in [*CRANK, LOAD]],
        "spring": [{"N_m_rad": each} for each in [*SHAFTS, 1.0]],
        "coupling": [{"station": 4, "torque_N_m": [0, 100], "twist_rad": [0, 100 / SOFT], "mean_N_m": 50}],
        "excitation": [{"station": 2, "order": order, "N_m": torque} for order, torque in TORQUES.items()],
        "damper": [{"station": 1, "kind": "viscous", "inertia_kg_mm2": 1e6 * RING, **damper}],
    }


def test_a_soft_coupling_does_not_tune_the_cranks_damper() -> None:
    """The torque of the crank's own shafts decides; the coupling's twist, forty times theirs, does not."""
    found = ab.torsion(soft_train(tune=True)).report["dampers"][0]
    tried = np.geomspace(0.1, 1000.0, 33)
    best = min(crank_torque(float(c)) for c in tried)
    own = crank_torque(found["N_m_s_rad"])
    assert found["greatest"]["torque_N_m"] == pytest.approx(own, rel=1e-4)
    assert own <= 1.0005 * best
    assert found["N_m_s_rad"] < 100.0  # not a locked ring
    assert own < 0.5 * crank_torque(1e6)
    assert found["greatest_without"]["torque_N_m"] > 2.0 * own
    # the rule is that of the crank's own mode, not of the load on its coupling
    assert found["rule"]["mode_hz"] > 200.0


def test_a_search_that_ends_at_its_bound_says_so() -> None:
    """A ring at a node of all that resonates in range does best where it does nothing."""
    file = soft_train(tune=True)
    file["inertia"] = [{"kg_mm2": each} for each in (1e4, 1e8, 1e4)]
    file["spring"] = [{"N_m_rad": 1e5}, {"N_m_rad": 1e5}]
    file["coupling"] = []
    file["excitation"] = [{"station": 1, "order": 1, "N_m": 100}]
    file["speed_rpm"] = [20.0, 200.0]
    file["damper"][0]["station"] = 3
    report = ab.torsion(file).report
    ended = report["dampers"][0]["search_ended_at"]
    assert ended in ("least damping", "greatest damping")
    assert f"the search ended at its {ended}" in report["warnings"][0]


def test_the_peak_of_each_order_is_found_between_speeds() -> None:
    """With a viscous damper the peak is beside the frequencies of the train with its ring let loose."""
    report = ab.torsion(soft_train(N_m_s_rad=9.0)).report
    most = max(each["torque_N_m"] for each in report["peaks"])
    assert most >= crank_torque(9.0) * (1.0 - 1e-6)
    six = next(each for each in report["peaks"] if each["order"] == 6.0)
    free = next(each for each in report["critical"] if each["order"] == 6.0 and each["mode"] == 2)
    assert six["torque_N_m"] > 1.02 * free["torque_N_m"]
    assert six["speed_rpm"] < free["speed_rpm"]


def test_nothing_excites_is_said() -> None:
    file = {key: value for key, value in soft_train(N_m_s_rad=9.0).items() if key != "excitation"}
    result = ab.torsion(file)
    assert result.report["excited"] is False
    assert result.text().count("Nothing excites: neither [[excitation]] nor") == 1
    assert "meets a natural frequency" not in result.text()
