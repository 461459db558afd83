"""Speed control of a rotor with friction, and what a bench file refuses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from autobalance.engines.bearings.film import JournalBearing
from autobalance.engines.bearings.verb import bearing
from autobalance.errors import JobError
from autobalance.test_stands.bench.keys import BENCH_KEYS
from autobalance.test_stands.bench.rotor import (
    DryBearings,
    PlainBearings,
    bench_friction,
    missing_unbalance_g_mm,
)
from autobalance.test_stands.bench.speed_control import SpeedControl, SpeedTrace, loop_margin, ramp_and_hold
from autobalance.test_stands.bench.verb import bench
from autobalance.toml_files.keys import json_schema

J = 0.002847335
DEFAULTS = SpeedControl(0.05, 0.5, 5.0)

FILE: dict[str, Any] = {
    "rotor": {"inertia_kg_mm2": 2847.335, "mass_kg": 2.5},
    "bearing": {"kind": "dry", "diameter_mm": 20.0, "mu": 0.3},
    "schedule": {"speeds_rpm": [3000.0]},
}


def rpm(speed: float) -> float:
    return speed * math.pi / 30.0


def run(friction: float, control: SpeedControl, speed_rpm: float = 3000.0) -> SpeedTrace:
    return ramp_and_hold(J, lambda _: friction, control, rpm(speed_rpm), 2.0, 1.5)


def test_ramp_follows_the_closed_form() -> None:
    # Without friction the error obeys J ë + kp ė + ki e = 0 with e(0) = 0, ė(0) = the ramp's slope.
    trace = run(0.0, DEFAULTS)
    slope = rpm(3000.0) / 2.0
    a = DEFAULTS.kp_N_m_s / (2.0 * J)
    w = np.emath.sqrt(DEFAULTS.ki_N_m / J - a**2)
    inside = trace.time_s <= 2.0
    t = trace.time_s[inside]
    expected = (slope * np.exp(-a * t) * np.sin(w * t) / w).real
    assert np.allclose((trace.wanted - trace.speed)[inside], expected, atol=1e-7 * slope)


def test_a_control_that_is_too_fast_to_follow_is_refused() -> None:
    """A rotor of 1 kg·mm² took minutes."""
    with pytest.raises(ValueError, match=r"3\.5 s take .* steps; expected 200000 at most: lower its gains"):
        ramp_and_hold(1e-9, lambda _: 0.0, DEFAULTS, rpm(3000.0), 2.0, 1.5)


def test_energy_and_momentum_are_kept() -> None:
    trace = run(0.2, DEFAULTS, 6000.0)
    moving = np.diff(trace.time_s) * 0.5 * (trace.friction_N_m[1:] + trace.friction_N_m[:-1])
    gained = trace.impulse_N_m_s - np.concatenate([[0.0], np.cumsum(moving)])
    # While the rotor stands, friction is what the torque is.
    assert np.allclose(gained, J * trace.speed, atol=1e-6)


def test_rotor_stands_until_the_torque_is_over_friction() -> None:
    trace = run(0.2, DEFAULTS)
    standing = trace.speed == 0.0
    assert (trace.torque_N_m[standing] <= 0.2 + 1e-9).all()
    assert np.allclose(trace.friction_N_m[standing], trace.torque_N_m[standing])
    start = trace.time_s[standing][-1]
    slope = rpm(3000.0) / 2.0  # kp slope t + ki slope t²/2 = 0.2
    expected = (-0.05 + math.sqrt(0.05**2 + 2.0 * 0.5 * 0.2 / slope)) / 0.5
    assert start == pytest.approx(expected, rel=1e-9)


def test_torque_is_cut_and_does_not_wind_up() -> None:
    limited = run(0.3681, SpeedControl(0.05, 0.5, 1.5), 9000.0)
    assert limited.torque_N_m.max() == pytest.approx(1.5)
    cut = limited.torque_N_m >= 1.5 - 1e-9
    times = limited.time_s[cut]
    # While it is cut from the first moment on, the speed rises with all the torque there is.
    span = slice(np.flatnonzero(cut)[0] + 1, np.flatnonzero(cut)[200])
    rate = np.diff(limited.speed[span]) / np.diff(limited.time_s[span])
    assert np.allclose(rate, (1.5 - 0.3681) / J, rtol=1e-6)
    assert times[-1] > 2.0  # it catches up after the ramp
    assert (limited.speed.max() - rpm(9000.0)) < 0.02 * rpm(9000.0)


def stepped(
    control: SpeedControl, friction: float, speed_rpm: float, STEP_S: float = 2e-5
) -> tuple[float, float]:
    """Return the last speed and the mean torque held, by small explicit steps of the law as it is written."""
    speed = integral = impulse = at_ramp = 0.0
    late = round(control.delay_s / STEP_S)
    given: list[float] = []
    for number in range(round(3.5 / STEP_S)):
        t = number * STEP_S
        at_ramp = impulse if t <= 2.0 else at_ramp
        error = rpm(speed_rpm) * min(t / 2.0, 1.0) - speed
        asked = control.kp_N_m_s * error + control.ki_N_m * integral
        torque = max(-control.torque_limit_N_m, min(control.torque_limit_N_m, asked))
        if torque == asked or error * torque <= 0.0:
            integral += STEP_S * error
        given.append(torque)
        torque = given[number - late] if number >= late else 0.0
        impulse += STEP_S * torque
        if speed > 0.0 or torque > friction:
            speed = max(0.0, speed + STEP_S * (torque - friction) / J)
    return speed, (impulse - at_ramp) / 1.5


@pytest.mark.parametrize(
    "control",
    [
        SpeedControl(0.02, 3.0, 1.2),  # slides along its limit
        SpeedControl(0.05, 0.5, 1.0, 0.02),
        SpeedControl(0.05, 0.5, 5.0, 0.01),
        SpeedControl(0.05, 0.5, 0.3),  # too weak to start
    ],
)
def test_limits_and_delays_against_small_steps(control: SpeedControl) -> None:
    trace = run(0.3681, control, 9000.0)
    speed, mean = stepped(control, 0.3681, 9000.0)
    assert trace.speed[-1] == pytest.approx(speed, rel=2e-5)
    assert trace.mean_torque_N_m(2.0, 3.5) == pytest.approx(mean, rel=1e-4)


@pytest.mark.parametrize("delay_s", [0.0, 0.004, 0.02])
def test_phase_margin_is_that_of_the_loop(delay_s: float) -> None:
    control = SpeedControl(0.05, 0.5, 5.0, delay_s)
    found = loop_margin(control, J)
    s = 1j * found.crossover_rad_s
    loop = (0.05 + 0.5 / s) * np.exp(-s * delay_s) / (J * s)
    assert abs(loop) == pytest.approx(1.0)
    assert np.angle(-loop) == pytest.approx(found.phase_margin_rad)


def test_means_of_a_turning_load_and_holes_that_cancel() -> None:
    result = bench(
        {
            **FILE,
            "hole": [
                {"diameter_mm": 8.0, "depth_mm": 37.0, "radius_mm": 29.0, "angle_deg": angle}
                for angle in (10.0, 190.0)
            ],
        }
    )
    rotor = result.report["rotor"]
    assert rotor["unbalance_g_mm"] == pytest.approx(0.0, abs=1e-9)
    assert len(rotor["holes"]) == 2
    assert missing_unbalance_g_mm((), 1.0) == 0.0
    friction = bench_friction(DryBearings(20.0, ((0.0, 0.4),), True), 25.0, 3000.0)
    turn = np.linspace(0.0, 2.0 * np.pi, 4000, endpoint=False)
    force = np.abs(25.0 + 3000e-6 * 200.0**2 * np.exp(1j * turn))
    assert friction(200.0) == pytest.approx(0.4 * 0.010 * force.mean(), rel=1e-9)


def test_exact_friction_is_below_the_small_angle() -> None:
    exact = bench(FILE).report["runs"][0]["friction_N_m"]
    small = bench({**FILE, "bearing": {**FILE["bearing"], "small_angle": True}}).report["runs"][0][
        "friction_N_m"
    ]
    assert exact == pytest.approx(small / math.sqrt(1.09))
    assert small == pytest.approx(2.5 * 9.80665 * 0.3 * 0.010)


def test_rolling_bearings_share_the_load() -> None:
    bearing = {"kind": "rolling", "mean_diameter_mm": 33.5, "f0": 2.0, "f1": 0.001, "count": 2}
    rolling = {**bearing, "kinematic_viscosity_mm2_s": 100.0}
    found = bench({**FILE, "bearing": rolling}).report["runs"][0]
    free = 2.0 * 1e-7 * 2.0 * (100.0 * 3000.0) ** (2.0 / 3.0) * 33.5**3 * 1e-3
    assert found["friction_N_m"] == pytest.approx(free + 0.001 * 2.5 * 9.80665 * 33.5 * 1e-3)
    oiled = {**bearing, "oil": {"viscosity_mm2_s": [[40.0, 100.0], [100.0, 11.0]], "temperature_C": 40.0}}
    again = bench({**FILE, "bearing": oiled}).report["runs"][0]
    assert again["friction_N_m"] == pytest.approx(found["friction_N_m"], rel=1e-9)


def test_coefficient_by_speed_is_taken_between_points() -> None:
    bearings = DryBearings(20.0, ((1000.0, 0.4), (2000.0, 0.2)), False)
    assert [bearings.mu_at(speed) for speed in (0.0, 1500.0, 9000.0)] == pytest.approx([0.4, 0.3, 0.2])


def test_runs_are_told_by_speed_and_then_repeat() -> None:
    schedule = {"speeds_rpm": [1000.0, 2000.0], "repeats": 2}
    result = bench({**FILE, "schedule": schedule})
    assert [(run["speed_rpm"], run["repeat"]) for run in result.report["runs"]] == [
        (1000.0, 1),
        (1000.0, 2),
        (2000.0, 1),
        (2000.0, 2),
    ]
    rows = result.series().decode().splitlines()
    assert rows[0] == "time_s,speed_rpm,wanted_rpm,torque_N_m,friction_N_m"
    times = np.array([float(row.split(",")[0]) for row in rows[1:]])
    assert (np.diff(times) >= 0.0).all()
    assert times[-1] == pytest.approx(4 * 3.5)


def test_reading_without_a_run_is_not_compared() -> None:
    found = bench(
        {
            **FILE,
            "reading": [
                {"case": 1, "speed_rpm": 500.0, "torque_N_m": 0.1},
                {"case": 1, "speed_rpm": 3000.0, "torque_N_m": 0.1},
            ],
        }
    ).report
    none, one = found["comparison"]
    assert none["simulated_N_m"] is None
    assert none["difference_percent"] is None
    held = found["runs"][0]["mean_torque_N_m"]
    assert one["difference_percent"] == pytest.approx(100.0 * abs(0.1 - held) / min(0.1, held))


def shaped(**more: Any) -> dict[str, Any]:
    return {
        "rotor": {"disc_mm": 98.0, "shaft_mm": 20.0, "length_mm": 188.0, "inertia_kg_mm2": 2800.0, **more}
    }


def reading(**keys: Any) -> dict[str, Any]:
    return {"reading": [{"case": "1", "speed_rpm": 3000.0, **keys}]}


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"control": {"delay_s": 0.1}}, "control: the speed loop is unstable, its phase margin is -"),
        ({"control": {"kp_N_m_s": 0.0}}, "its phase margin is 0.0°"),
        ({"control": {"kp_N_m_s": 0.0, "ki_N_m": 0.0}}, "control.kp_N_m_s and control.ki_N_m are both 0"),
        ({"rotor": {"mass_kg": 1.0}}, "rotor.inertia_kg_mm2 is missing"),
        ({"rotor": {"inertia_kg_mm2": 1.0}}, "rotor.mass_kg is missing; or weight_N"),
        (
            {"rotor": {"inertia_kg_mm2": 1.0, "mass_kg": 1.0, "shaft_mm": 3.0}},
            "rotor.shaft_mm is given without",
        ),
        (shaped(shaft_mm=99.0), "rotor.disc_mm is 98; must be over shaft_mm"),
        (shaped(inertia_kg_mm2=10.0), "rotor.inertia_kg_mm2 is 10: a disc of 98 mm would have to be"),
        (
            {**shaped(), "hole": [{"diameter_mm": 8.0, "depth_mm": 5.0, "radius_mm": 50.0}]},
            "hole[1].radius_mm is 50; must lie in the disc, 0 to 49",
        ),
        (shaped(thickness_mm=200.0), "rotor.thickness_mm is 200; must be at most length_mm"),
        ({"bearing": {"kind": "dry", "mu": 0.1}}, "bearing.diameter_mm is missing"),
        ({"bearing": {"kind": "dry", "diameter_mm": 2.0}}, "bearing.mu is missing"),
        (
            {"bearing": {"kind": "dry", "diameter_mm": 2.0, "mu_by_speed": [[2.0, 0.1], [1.0, 0.1]]}},
            "the speeds rising",
        ),
        ({"bearing": {"kind": "dry", "diameter_mm": 2.0, "mu": 0.1, "f0": 1.0}}, 'it is a key of "rolling"'),
        ({"bearing": {"kind": "rolling", "f0": 1.0}}, "bearing.mean_diameter_mm is missing"),
        ({"bearing": {"kind": "rolling", "mu": 1.0}}, 'it is a key of "dry"'),
        ({"schedule": {"speeds_rpm": []}}, "schedule.speeds_rpm is an empty list"),
        ({"reduction": {"zero_V": 0.2, "zero": "rest"}}, "reduction.zero_V is given with zero"),
        (reading(), "reading[1].volts is missing"),
        (reading(volts=[0.1], drop=[2]), "reading[1].drop names run 2; there are 1"),
        (reading(volts=[0.1], drop=[1]), "reading[1].drop leaves no run"),
        ({"reduction": {"zero": "rest"}, **reading(volts=[0.1])}, "has no volts at speed_rpm = 0"),
    ],
)
def test_bad_benches_are_named(more: dict[str, Any], message: str) -> None:
    with pytest.raises(JobError) as refused:
        bench({**FILE, **more})
    assert message in str(refused.value)


def test_schema_allows_what_is_read() -> None:
    import jsonschema

    schema = json_schema("bench", BENCH_KEYS)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(FILE, schema)


PLAIN = {
    "kind": "hydrodynamic", "diameter_mm": 20.0, "length_mm": 10.0, "radial_clearance_mm": 0.02,
    "viscosity_Pa_s": 0.02, "mu": 0.15,
}  # fmt: skip


def test_plain_bearings_have_the_friction_of_their_film() -> None:
    (found,) = bench({**FILE, "bearing": PLAIN}).report["runs"]
    each = {key: PLAIN[key] for key in ("diameter_mm", "length_mm", "radial_clearance_mm", "viscosity_Pa_s")}
    film = {
        **each,
        "kind": "hydrodynamic",
        "solver": "ocvirk",
        "speed_rpm": 3000.0,
        "load_N": 2.5 * 9.80665 / 2.0,
    }
    alone = bearing(film).report["friction"]["moment_N_m"]
    assert found["friction_N_m"] == pytest.approx(2.0 * alone, rel=1e-5)
    assert found["mean_torque_N_m"] == pytest.approx(2.0 * alone, rel=0.02)
    # at rest they touch
    still = PlainBearings(JournalBearing(0.02, 0.01, 2e-5), 2, 0.02, 0.15)
    assert still.moment_N_m(100.0, 0.0) == pytest.approx(100.0 * 0.01 * 0.15 / math.hypot(1.0, 0.15))
    petroff = 2.0 * math.pi * 0.02 * rpm(3000.0) * 0.01**3 * 0.01 / 2e-5
    assert still.moment_N_m(0.0, 3000.0) == pytest.approx(2.0 * petroff, rel=1e-12)


def test_a_reading_says_how_sure_it_is() -> None:
    readings = [
        {"case": 1, "speed_rpm": 0.0, "volts": [0.14, 0.16]},
        {"case": 1, "speed_rpm": 3000.0, "volts": [0.40, 0.42, 0.38], "simulated_N_m": 0.25},
    ]
    reduction = {"zero": "rest", "N_m_per_V": 1.0, "zero_pm_V": 0.03, "N_m_per_V_pm": 0.02}
    report = bench({**FILE, "reading": readings, "reduction": reduction}).report
    found = report["readings"][1]
    scatter, rest = 0.02 / math.sqrt(3.0), 0.02 / math.sqrt(2.0) / math.sqrt(2.0)
    parts = (scatter, rest, 0.03 / math.sqrt(3.0), 0.25 * 0.02 / math.sqrt(3.0))
    assert found["torque_N_m"] == pytest.approx(0.25)
    assert found["scatter_N_m"] == pytest.approx(0.02)
    assert found["uncertainty_N_m"] == pytest.approx(2.0 * math.hypot(*parts), rel=1e-12)
    (compared,) = report["comparison"]
    assert compared["uncertainty_N_m"] == found["uncertainty_N_m"]
    assert compared["within_uncertainty"] is True


def test_runs_whose_temperature_was_not_held_do_not_count() -> None:
    readings = [{"case": 1, "speed_rpm": 3e3, "volts": [0.9, 0.4, 0.42], "temperature_C": [35.0, 59.0, 61.0]}]
    result = bench({**FILE, "reading": readings, "reduction": {"temperature_C": [58.0, 62.0]}})
    (found,) = result.report["readings"]
    assert (found["dropped"], found["dropped_for_temperature"]) == ([1], [1])
    assert found["mean_V"] == pytest.approx(0.41)
    assert "1 (temperature)" in result.text()
    (kept,) = bench({**FILE, "reading": readings}).report["readings"]
    assert kept["dropped"] == []


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"bearing": {**PLAIN, "mu": None}}, "bearing.mu"),
        (
            {"bearing": {key: value for key, value in PLAIN.items() if key != "length_mm"}},
            "bearing.length_mm is",
        ),
        ({"bearing": {**FILE["bearing"], "length_mm": 5.0}}, 'a key of "hydrodynamic"'),
        ({"bearing": {**PLAIN, "f0": 5.0}}, 'a key of "rolling"'),
        ({"reduction": {"temperature_C": [60.0, 50.0]}}, "the first must be the lower"),
        (
            {"reading": [{"case": 1, "speed_rpm": 1.0, "volts": [1.0], "temperature_C": [20.0, 30.0]}]},
            "2 values for 1 volts",
        ),
        (
            {
                "reading": [{"case": 1, "speed_rpm": 1.0, "volts": [1.0], "temperature_C": [20.0]}],
                "reduction": {"temperature_C": [50.0, 60.0]},
            },
            "temperature_C leaves no run",
        ),
    ],
)
def test_films_and_holds_that_cannot_be_are_named(more: dict[str, Any], message: str) -> None:
    with pytest.raises(JobError, match=message):
        bench({**FILE, **more})


def test_readings_are_reduced_and_compared_without_a_bearing() -> None:
    """Nothing is run, and the rest is as with one."""
    reading = {"case": "3", "speed_rpm": 3000.0, "volts": [0.41, 0.39, 0.40], "simulated_N_m": 0.1988}
    hole = {"diameter_mm": 16.0, "depth_mm": 37.0, "radius_mm": 29.3}
    tables = {"rotor": FILE["rotor"], "hole": [hole], "reading": [reading]}
    alone, run = bench(tables), bench({**tables, "bearing": FILE["bearing"]})
    for key in ("rotor", "loop", "readings", "comparison"):
        assert alone.report[key] == run.report[key]
    assert alone.report["comparison"][0]["difference_percent"] is not None
    assert alone.report["runs"] == []
    assert alone.plots() == {}
    assert alone.files() == {}
    assert "Nothing was run: there is no [bearing]" in alone.text()
    with pytest.raises(JobError, match=r"\[bearing\] is missing; the runs of \[schedule\] need its friction"):
        bench({**tables, "schedule": {"speeds_rpm": [3000.0]}})
