"""An engine on its mounts against hand-made matrices, closed forms, Newton and Euler."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import autobalance as ab
from autobalance.engines.mounts.rigid_body import Mount, MountedEngine
from autobalance.errors import JobError, UsageError

Amplitudes = NDArray[Any]
CORNERS = [(x, y, z) for x in (-150.0, 150.0) for y in (-100.0, 100.0) for z in (-120.0, 120.0)]


def test_a_box_on_springs_at_its_corners() -> None:
    """Centre in the middle: each motion by itself, ω² = 8k/m and 8(k_a b² + k_b a²)/J."""
    k, mass, inertia = np.array([2e5, 3e5, 5e5]), 5e4, np.array([4e8, 6e8, 5e8])
    engine = MountedEngine(
        mass, np.zeros(3), np.diag(inertia), tuple(Mount(np.array(at), k, 0.0) for at in CORNERS)
    )
    x, y, z = 150.0, 100.0, 120.0
    square = [*(8.0 * k / mass)]
    square += [8.0 * (k[2] * y * y + k[1] * z * z) / inertia[0]]
    square += [8.0 * (k[0] * z * z + k[2] * x * x) / inertia[1]]
    square += [8.0 * (k[1] * x * x + k[0] * y * y) / inertia[2]]
    assert engine.modes()[0] == pytest.approx(np.sqrt(sorted(square)), rel=1e-12)


def test_the_response_against_newton_and_euler() -> None:
    """Free body by Newton and Euler, each mount's force where it is; viscous dampers of the same loss."""
    rng = np.random.default_rng(2)
    half = rng.normal(size=(3, 3))
    inertia = 4e8 * np.eye(3) + 3e7 * (half + half.T)
    omega = 70.0
    centre = np.array([12.0, -30.0, 55.0])
    mounts = tuple(Mount(np.array(at), rng.uniform(1e8, 3e8, 3), 0.08) for at in CORNERS[1:5])
    engine = MountedEngine(6e4, centre, inertia, mounts)
    force = np.array([3e8, 1e8 * 1j, 0.0])
    moment = np.array([2e9, -1e9j, 5e9])
    found = engine.response(np.array([omega]), engine.wrench(force[None], moment[None]))[0]

    def rate(state: Amplitudes, drive: Amplitudes, twist: Amplitudes) -> Amplitudes:
        """Return the state's rate by Newton and Euler; linear, so complex amplitudes go through."""
        u, turn, v, spin = state.reshape(4, 3)
        f, m = drive, twist - np.cross(centre, drive)
        for mount in mounts:
            arm = mount.at_mm - centre
            moved, speed = u + np.cross(turn, arm), v + np.cross(spin, arm)
            pull = -mount.stiffness_g_s2 * (moved + 2.0 * mount.damping_ratio / omega * speed)
            f, m = f + pull, m + np.cross(arm, pull)
        return np.concatenate([v, spin, f / engine.mass_g, np.linalg.solve(inertia, m)])

    none = np.zeros(3)
    system = np.stack([rate(unit, none, none) for unit in np.eye(12)], axis=1)
    driven = rate(np.zeros(12, dtype=complex), force, moment)
    steady = np.linalg.solve(1j * omega * np.eye(12) - system, driven)
    assert found == pytest.approx(steady[:6], rel=1e-9)


def job(**tables: Any) -> ab.Job:
    mount = {"k_N_mm": [400.0, 400.0, 400.0]}
    return ab.Job.from_dict(
        {
            "engine": {
                "rod_length_mm": 120,
                "rotating_g": {"big_end": 200.0},
                "reciprocating_g": {"piston": 350.0},
                "layout": {"bank_deg": 0.0},
            },
            "balance": {"factor": 0.5, "grade": 16, "speed_rpm": 6000},
            "correction": {"method": "drill"},
            "mounts": {
                "mass_kg": 45.0,
                "centre_mm": [60.0, 0.0, 0.0],
                "inertia_kg_mm2": [[9e5, 0, 0], [0, 8e5, 0], [0, 0, 7e5]],
                "speed_rpm": [3000, 6000],
                "points": 5,
                "mount": [{"at_mm": [x, y, 0.0], **mount} for x in (-50, 150) for y in (-120, 120)],
                "point": [{"name": "handlebar", "at_mm": [600.0, 300.0, 0.0]}],
            },
            **tables,
        }
    )


@pytest.fixture(scope="module")
def single() -> ab.Crank:
    return ab.generate("single", segments=32).crank


def test_far_above_its_mounts_an_engine_moves_as_if_free(single: ab.Crank) -> None:
    """Without gas a free engine's centre moves by (m_rec r)/M in its first order, whatever holds it."""
    soft = job().raw["mounts"]
    soft = {**soft, "mount": [{**each, "k_N_mm": [0.5] * 3} for each in soft["mount"]]}
    report = ab.forces(job(mounts=soft), crank=single, factors=(0.0, 0.5, 1.0), mounts=True).report["mounts"]
    assert len(report["natural_frequencies_hz"]) == 6
    rows = {each["factor"]: each for each in report["responses"]}
    radius = single.throws[0].crank_radius_mm
    first = 350.0 * radius / 45000.0
    for factor in (0.0, 0.5, 1.0):
        centre = next(each for each in rows[factor]["places"] if each["name"] == "centre")
        ellipse = math.hypot(1.0 - factor, factor) * first / math.sqrt(2.0)
        second = 0.25 * (radius / 120.0) * first / math.sqrt(2.0)
        assert centre["displacement_rms_mm"][-1] == pytest.approx(math.hypot(ellipse, second), rel=5e-3)
    # half the reciprocating mass is least at the centre
    assert set(report["best_factor_for"]) == {"handlebar"}


def test_the_best_factor_is_least_at_its_place(single: ab.Crank) -> None:
    best = ab.forces(job(), crank=single, mounts=True).report["mounts"]["best_factor_for"]["handlebar"]
    inside = min(max(best, 0.0), 1.0)
    tried = (inside, max(0.0, inside - 0.1), min(1.0, inside + 0.1))
    rows = ab.forces(job(), crank=single, factors=tried, mounts=True).report["mounts"]["responses"]
    worst = {
        row["factor"]: max(next(p["velocity_rms_mm_s"] for p in row["places"] if p["name"] == "handlebar"))
        for row in rows
    }
    assert min(worst, key=lambda factor: worst[factor]) == inside


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mount": []}, r"\[\[mounts.mount\]\] is missing"),
        ({"inertia_kg_mm2": [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}, "inertia_kg_mm2 is not an inertia"),
        ({"speed_rpm": [2000, 1000]}, "the first must be the lower one"),
    ],
)
def test_bad_input_is_one_line(change: dict[str, Any], words: str) -> None:
    with pytest.raises(JobError, match=words) as refused:
        job(mounts={**job().raw["mounts"], **change})
    assert "\n" not in str(refused.value)


def test_a_job_without_mounts_says_so(single: ab.Crank) -> None:
    values = {key: table for key, table in job().raw.items() if key != "mounts"}
    with pytest.raises(JobError, match=r"\[mounts\] is missing"):
        ab.forces(values, crank=single, mounts=True)


def test_factors_beyond_0_and_1_are_for_mounts_alone(single: ab.Crank) -> None:
    report = ab.forces(job(), crank=single, factors=(-0.2, 1.3), mounts=True).report["mounts"]
    assert [each["factor"] for each in report["responses"]] == [-0.2, 0.5, 1.3]
    with pytest.raises(UsageError, match="each must be 0 to 1"):
        ab.forces(job(), crank=single, factors=(1.3,))
    with pytest.raises(UsageError, match=r"each must be -0\.5 to 1\.5"):
        ab.forces(job(), crank=single, factors=(1.7,), mounts=True)
