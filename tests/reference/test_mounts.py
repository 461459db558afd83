"""An engine on its mounts against hand-made matrices, closed forms, Newton and Euler."""

from __future__ import annotations

import json
import math
from functools import lru_cache
from pathlib import Path
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


# --- by order and axis --------------------------------------------------------------------------------------


def shaken_job(points: int = 5, **mount: Any) -> dict[str, Any]:
    held = [
        {"at_mm": [-250.0, 700.0, 0.0], "k_N_mm": [18.0, 60.0, 40.0], **mount},
        {"at_mm": [-250.0, -650.0, -80.0], "k_N_mm": [12.0, 45.0, 20.0], **mount},
        {"at_mm": [-250.0, -650.0, 80.0], "k_N_mm": [12.0, 45.0, 20.0], **mount},
    ]
    return {
        "engine": {
            "rod_length_mm": 120.0,
            "layout": {"bank_deg": 0.0},
            "rotating_g": {"big_end": 200.0},
            "reciprocating_g": {"piston": 330.0},
        },
        "balance": {"factor": 0.6, "grade": 16, "speed_rpm": 7500},
        "correction": {"method": "drill"},
        "mounts": {
            "mass_kg": 145.0,
            "centre_mm": [120.0, -60.0, 0.0],
            "inertia_kg_mm2": [[9.0e6, 0, 0], [0, 1.1e7, 0], [0, 0, 1.4e7]],
            "damping_ratio": 0.08,
            "speed_rpm": [1000.0, 5000.0],
            "points": points,
            "mount": held,
            "point": [{"name": "bar", "at_mm": [620.0, 380.0, 330.0]}],
        },
    }


def mounted_report(job: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = ab.forces(job, preset_single(), mounts=True, factors=[0.6]).report["mounts"]
    return found


@lru_cache(maxsize=1)
def preset_single() -> ab.Crank:
    return ab.generate("single", segments=24).crank


def own_motion(job: dict[str, Any], order: float, rpm: float, spring: Any) -> tuple[Any, Any]:
    """Motion (6,) of the centre and force (3,) [g·mm/s²] of an order: what Ruckle 2014, ch. 5, measures."""
    mounts = job["mounts"]
    omega = order * rpm * math.pi / 30.0
    centre = np.array(mounts["centre_mm"])
    mass = np.zeros((6, 6))
    mass[:3, :3] = np.eye(3) * mounts["mass_kg"] * 1e3
    mass[3:, 3:] = np.array(mounts["inertia_kg_mm2"]) * 1e3
    stiff = np.zeros((6, 6), dtype=complex)
    for each in mounts["mount"]:
        rows = place_rows(np.array(each["at_mm"]) - centre)
        stiff += rows.T @ np.diag(spring(np.array(each["k_N_mm"]), omega)) @ rows
    crank = preset_single()
    r, length, speed = crank.throws[0].crank_radius_mm, 120.0, rpm * math.pi / 30.0
    angle = 2.0 * math.pi * np.arange(720) / 720
    x = r * np.cos(angle) + np.sqrt(length**2 - (r * np.sin(angle)) ** 2)
    second = np.fft.irfft(-(np.arange(361) ** 2) * np.fft.rfft(x), 720) * speed**2
    slope = np.fft.irfft(1j * np.arange(361) * np.fft.rfft(x), 720)
    force = np.zeros((720, 3))
    force[:, 0] = -330.0 * second - 0.6 * 330.0 * r * speed**2 * np.cos(angle)
    force[:, 1] = -0.6 * 330.0 * r * speed**2 * np.sin(angle)
    roll = 330.0 * second * slope
    wrench = np.zeros((720, 6))
    wrench[:, :3] = force
    wrench[:, 3:] = np.cross(-centre, force)
    wrench[:, 5] += roll
    amplitude = np.fft.rfft(wrench, axis=0)[int(order)] / 360.0
    return np.linalg.solve(stiff - omega**2 * mass, amplitude), amplitude[:3]


def place_rows(arm: Any) -> Any:
    x, y, z = arm
    return np.hstack([np.eye(3), np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])])


SPRINGS: dict[str, tuple[dict[str, Any], Any]] = {
    "ratio": ({}, lambda k, _: k * 1e6 * (1.0 + 0.16j)),
    "loss": ({"loss_factor": 0.3}, lambda k, _: k * 1e6 * (1.0 + 0.3j)),
    "by frequency": (
        {"loss_factor_by_hz": [[0.0, 0.1], [200.0, 0.5]]},
        lambda k, w: k * 1e6 * (1.0 + 1j * (0.1 + 0.4 * min(w / (2.0 * math.pi * 200.0), 1.0))),
    ),
    "viscous": (
        {"c_N_s_mm": [0.2, 0.1, 0.3]},
        lambda k, w: k * 1e6 * (1.0 + 0.16j) + 1j * w * 1e6 * np.array([0.2, 0.1, 0.3]),
    ),
}


@pytest.mark.parametrize("kind", list(SPRINGS))
def test_orders_by_axis_against_own_matrices(kind: str) -> None:
    keys, spring = SPRINGS[kind]
    job = shaken_job(**keys)
    report = mounted_report(job)
    balanced = next(each for each in report["orders"] if each["name"] == "balanced")
    rows = place_rows(np.array([620.0, 380.0, 330.0]) - np.array([120.0, -60.0, 0.0]))
    bar = next(each for each in balanced["places"] if each["name"] == "bar")
    seen = 0
    for row in bar["orders"]:
        if row["order"] not in (1.0, 2.0, 4.0) or row["axis"] == "z":
            continue
        for place, rpm in enumerate(report["speeds_rpm"]):
            motion, _ = own_motion(job, row["order"], rpm, spring)
            omega = row["order"] * rpm * math.pi / 30.0
            own = 1j * omega * (rows @ motion)["xyz".index(row["axis"])]
            told = row["velocity_mm_s"][place] * np.exp(1j * math.radians(row["phase_deg"][place]))
            assert told == pytest.approx(own, rel=1e-5, abs=1e-6)
            assert row["acceleration_m_s2"][place] == pytest.approx(
                abs(own) * omega * 1e-3, rel=1e-5, abs=1e-8
            )
            seen += 1
    assert seen >= 20
    first = next(row for row in balanced["mounts"][0]["orders"] if row["order"] == 1.0)
    motion, force = own_motion(job, 1.0, report["speeds_rpm"][-1], spring)
    arm = place_rows(np.array([-250.0, 700.0, 0.0]) - np.array([120.0, -60.0, 0.0]))
    omega = report["speeds_rpm"][-1] * math.pi / 30.0
    push = np.linalg.norm(np.abs(spring(np.array([18.0, 60.0, 40.0]), omega) * (arm @ motion)))
    assert first["force_N"][-1] == pytest.approx(push * 1e-6, rel=1e-5)
    assert first["transmissibility"][-1] == pytest.approx(push / np.linalg.norm(np.abs(force)), rel=1e-5)


def test_rms_of_all_orders_is_their_sum_and_the_file_has_its_own_row() -> None:
    job = shaken_job()
    report = mounted_report(job)
    now, state = report["as_the_file_is"], report["orders"][0]
    assert state["name"] == "as the file is"
    bar = next(each for each in now["places"] if each["name"] == "bar")
    orders = next(each for each in state["places"] if each["name"] == "bar")["orders"]
    total = np.sqrt(sum(0.5 * np.array(row["velocity_mm_s"]) ** 2 for row in orders))
    assert total == pytest.approx(bar["velocity_rms_mm_s"], rel=1e-4)
    text = ab.forces(job, preset_single(), mounts=True, factors=[0.6]).text()
    assert "as the file is" in text
    assert "bar, order 1, x" in text
    through = {row["order"]: row["transmissibility"] for row in report["orders"][1]["mounts"][0]["orders"]}
    (line,) = [each for each in text.splitlines() if "mount 1, order 1" in each]
    assert float(line.split()[-1]) == pytest.approx(max(through[1.0]), rel=5e-3)


def test_far_above_its_mounts_nothing_gets_through() -> None:
    """Limits: mass line (1/ω² of the spring), and all of the force where the springs are hard."""
    soft, hard = shaken_job(), shaken_job()
    for each in soft["mounts"]["mount"]:
        each["k_N_mm"] = [1e-6] * 3
    for each in hard["mounts"]["mount"]:
        each["k_N_mm"] = [1e9] * 3
    through = [mounted_report(job)["orders"][1]["mounts"] for job in (soft, hard)]
    assert max(row["orders"][0]["transmissibility"][-1] for row in through[0]) < 1e-6
    assert max(row["orders"][0]["transmissibility"][-1] for row in through[1]) > 0.3


@pytest.mark.parametrize(("stiffness_g_s2", "precision"), [(1e16, 1e-4), (1e20, 1e-8)])
def test_on_mounts_of_no_give_all_force_and_moment_get_through(
    stiffness_g_s2: float, precision: float
) -> None:
    """Limit k → ∞: forces of the mounts and their moments are those that shake the engine; nothing moves."""
    rng = np.random.default_rng(5)
    places = np.array([[-250.0, 700.0, 0.0], [-250.0, -650.0, -80.0], [-250.0, -650.0, 80.0]])
    held = tuple(Mount(each, stiffness_g_s2 * rng.uniform(1.0, 3.0, 3), 0.07) for each in places)
    centre = np.array([120.0, -60.0, 0.0])
    engine = MountedEngine(145e3, centre, np.diag([9e9, 1.1e10, 1.4e10]), held)
    omega = np.array([30.0, 700.0])
    wrench = rng.normal(size=(2, 6)) + 1j * rng.normal(size=(2, 6))
    wrench[:, 3:] *= 300.0
    motion = engine.response(omega, wrench)
    through = np.zeros((2, 6), dtype=complex)
    for row, rate in enumerate(omega):
        for number, mount in enumerate(held):
            force = mount.spring_g_s2(np.array([rate]))[0] * (engine.stretches(number) @ motion[row])
            through[row, :3] += force
            through[row, 3:] += np.cross(places[number] - centre, force)
    assert through == pytest.approx(wrench, rel=precision, abs=precision)
    assert np.abs(motion[:, :3]).max() < 1e3 / stiffness_g_s2


def test_measured_orders_stand_beside_the_computed_ones(tmp_path: Path) -> None:
    job = shaken_job()
    computed = mounted_report(job)["orders"][0]
    bar = next(each for each in computed["places"] if each["name"] == "bar")
    x = {row["order"]: row for row in bar["orders"] if row["axis"] == "x"}
    seconds = np.arange(20000) / 10000.0
    turn = 2.0 * math.pi * 50.0 * seconds
    signal = sum(x[n]["acceleration_m_s2"][2] / 9.80665 * np.cos(n * turn) for n in (1.0, 2.0))
    rows = np.stack([seconds, signal], axis=1)
    np.savetxt(tmp_path / "bar.csv", rows, delimiter=",", header="time_s,accel_g", comments="")
    measured = ab.orders(tmp_path / "bar.csv", speed_rpm=3000.0)
    (tmp_path / "bar.json").write_text(json.dumps(measured.report), encoding="utf-8")
    job["mounts"]["measured"] = [{"point": "bar", "axis": "x", "file": str(tmp_path / "bar.json")}]
    result = ab.forces(job, preset_single(), mounts=True, factors=[0.6])
    told = {row["order"]: row for row in result.report["mounts"]["measured"]}
    for n in (1.0, 2.0):
        assert told[n]["unit"] == "m/s²"
        assert told[n]["measured"] == pytest.approx(told[n]["as_the_file_is"], rel=1e-6)
    assert told[1.0]["balanced"] != pytest.approx(told[1.0]["as_the_file_is"], rel=1e-3)
    assert "bar, x, order 1, 3000 rpm" in result.text()
    drawn = result.plots()
    for name, words in (
        ("mounts-1", "as the file is"),
        ("mounts-1-order-1", "x, measured"),
        ("mounts-transmissibility-order-1", "mount 1"),
    ):
        assert words in drawn[name]["svg"].decode()
    job["mounts"]["measured"][0]["point"] = "seat"
    with pytest.raises(
        JobError, match=r"mounts\.measured\[1\]\.point is 'seat'; must be a \[\[mounts\.point\]\]: bar"
    ):
        ab.forces(job, preset_single(), mounts=True)
