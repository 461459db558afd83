"""Engine and rotor together, run up with noise: the unbalance comes back from the record.

The shaft's motion at each speed is that of ``rotor``; the torque orders of ``cycle`` shake the same sensor.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import autobalance as ab
from autobalance.signals.record import Channel
from autobalance.signals.speed import order_cuts
from autobalance.signals.tacho import TachoPulses, pulses
from tests.jobs import BUNDLED
from tests.signals import TURN, Array, instants, orders_of, ramp, smooth_tacho, turning

RATE = 5000.0
UNBALANCE = 50.0 * np.exp(1j * np.radians(40.0))
ENGINE = {
    "crankshaft": {
        "file": str(BUNDLED / "drafted" / "crank.stl"), "unit": "mm", "density_kg_m3": 7850.0,
        "crankpin_in_file": False,
    },
    "engine": {
        "rod_length_mm": 104.0, "rotating_g": {"rod": 134.04}, "reciprocating_g": {"rest": 261.5},
        "crankpin_g": {"crankpin": 114.65},
    },
    "balance": {"factor": 0.28, "grade": 6.3, "speed_rpm": 3000},
    "correction": {"method": "shoulder"},
    "cycle": {"bore_mm": 76.8, "compression_ratio": 13.0, "heat_J": 900.0},
}  # fmt: skip


def _rotor(
    speeds_rpm: Sequence[float] | float,
    discs: Sequence[float],
    unbalances: Sequence[complex],
    points: int = 25,
) -> list[list[dict[str, float]]]:
    """Return the response at each disc of a shaft on two damped bearings, as ``rotor`` tells it."""
    support = {"k_n_m": 5e6, "c_n_s_m": 4000.0}
    found = ab.rotor(
        {
            "speed_rpm": speeds_rpm if isinstance(speeds_rpm, float) else list(speeds_rpm),
            "points": points,
            "shaft": [{"length_mm": 400.0, "outer_mm": 20.0, "elements": 8}],
            "disc": [
                {"z_mm": z, "mass_kg": 5.0 / len(discs), "polar_kg_mm2": 8000.0, "diametral_kg_mm2": 5000.0}
                for z in discs
            ],
            "bearing": [{"z_mm": 0.0, **support}, {"z_mm": 400.0, **support}],
            "unbalance": [
                {"z_mm": z, "g_mm": abs(u), "angle_deg": float(np.degrees(np.angle(u)))}
                for z, u in zip(discs, unbalances, strict=True)
            ],
            "probe": [{"z_mm": z} for z in discs],
        }
    )
    return [each["points"] for each in found.report["response"]]


def _phasors(points: Sequence[dict[str, float]]) -> tuple[Array, Any]:
    speeds = np.array([point["speed_rpm"] for point in points])
    return speeds, np.array([p["x_um"] * np.exp(1j * np.radians(p["x_phase_deg"])) for p in points])


@pytest.fixture(scope="module")
def torque() -> dict[float, tuple[float, float]]:
    """Return what the engine's torque does at the sensor: 0.02 µm a N·m, all orders but the first."""
    rows = ab.cycle(ENGINE, 2000.0).report["torque"]["orders"]
    return {
        row["order"]: (0.02 * row["total_N_m"], np.radians(row["phase_deg"]))
        for row in rows
        if row["order"] != 1.0
    }


def test_unbalance_from_a_run_up(torque: dict[float, tuple[float, float]]) -> None:
    """Amplitude to 2 %, angle to 1°, through the critical speed."""
    (points,) = _rotor((600.0, 4800.0), [200.0], [UNBALANCE], 85)
    speeds, motion = _phasors(points)
    per_g_mm = CubicSpline(speeds, motion / UNBALANCE)
    t = instants(24.0, RATE)
    angle = ramp(t, 11.0, 79.0)
    rpm = 60.0 * (11.0 + (79.0 - 11.0) / 24.0 * t)
    unbalanced = (per_g_mm(rpm) * UNBALANCE * np.exp(1j * angle)).real
    noise = np.random.default_rng(1).standard_normal((2, len(t)))
    sensor = unbalanced + orders_of(angle, torque) + 0.05 * unbalanced.std() * noise[0]
    tacho = smooth_tacho(angle) + 0.02 * noise[1]
    found = pulses(Channel("tacho", "V", RATE, tacho), 1, 0.0)
    assert isinstance(found, TachoPulses)
    cut = order_cuts(Channel("x", "um", RATE, sensor), found.turning(), 12.0)[1]
    response = per_g_mm(cut.speeds_rpm)
    told = (response.conj() @ cut.amplitudes) / (response.conj() @ response)
    assert abs(told) == pytest.approx(50.0, rel=0.02)
    assert np.degrees(np.angle(told)) == pytest.approx(40.0, abs=1.0)
    exact = turning(t, angle)
    assert (
        np.abs(found.turning().speed_rad_s(t[5000:-5000]) / exact.speed_rad_s(t[5000:-5000]) - 1.0).max()
        < 5e-3
    )


def test_readings_go_straight_into_influence(torque: dict[float, tuple[float, float]]) -> None:
    """Two sensors, two planes, three runs with noise: the weights to add are the unbalances, reversed."""
    planes = [120.0, 300.0]
    unbalances = np.array([UNBALANCE, 30.0 * np.exp(-2.0j)])
    trials = np.array([20.0 + 0.0j, 20.0j])
    rng = np.random.default_rng(2)

    def readings(weights: Array) -> list[list[float]]:
        both = _rotor(1500.0, planes, list(weights))
        t = instants(8.0, 2000.0)
        angle = TURN * 25.0 * t - 1.0
        found = []
        for points in both:
            _, motion = _phasors(points)
            wave = (motion[0] * np.exp(1j * angle)).real + orders_of(angle, torque)
            columns = {"x_um": wave + 0.02 * rng.standard_normal(len(t)), "tacho_V": smooth_tacho(angle)}
            found.append(
                ab.orders(columns, channel="x", tacho="tacho", sample_rate=2000.0, peaks=0).reading()
            )
        return found

    result = ab.influence(
        {
            "initial": readings(unbalances),
            "trial": [
                {
                    "plane": n + 1,
                    "g_mm": abs(trials[n]),
                    "angle_deg": float(np.degrees(np.angle(trials[n]))),
                    "readings": readings(unbalances + np.where(np.arange(2) == n, trials, 0.0)),
                }
                for n in (0, 1)
            ],
        }
    )
    for row, unbalance in zip(result.report["corrections"], unbalances, strict=True):
        added = row["g_mm"] * np.exp(1j * np.radians(row["angle_deg"]))
        assert abs(added + unbalance) < 0.03 * abs(unbalance)


def test_the_engine_s_job_names_its_orders(tmp_path: Path) -> None:
    """Half orders are the four-stroke's combustion; orders 1 and 2 moving masses too."""
    t = instants(4.0, 2000.0)
    angle = TURN * 50.0 * t
    record = {"accel_g": orders_of(angle, {0.5: (0.1, 0.0), 1.0: (1.0, 0.0), 2.0: (0.4, 0.0)})}
    job = ab.Job.from_dict(ENGINE)
    found = ab.orders(record, sample_rate=2000.0, speed_rpm=3000.0, job=job, peaks=3)
    sources = {row["order"]: " | ".join(row["sources"]) for row in found.report["orders"]}
    assert "firing, harmonic 1 of 0.5 a turn" in sources[0.5]
    assert "torque of the cycle: gas" in sources[0.5]
    assert "moving masses: force" in sources[1.0]
    assert "rotating unbalance of crank and rods" in sources[1.0]
    assert "moving masses: force" in sources[2.0]
    force = ab.forces(job, speed_rpm=3000.0).report["states"][0]["force"]["orders"]
    second = next(row["greatest_force_n"] for row in force if row["order"] == 2.0)
    assert f"force {second:.4g} N" in sources[2.0]
    strongest = found.report["spectrum"]["peaks"][0]
    assert strongest["order"] == pytest.approx(1.0)
    assert "moving masses" in " ".join(strongest["sources"])
