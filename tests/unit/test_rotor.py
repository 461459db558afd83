"""What ``rotor`` tells: whirl, phases, orbits, sag, rigid-body motion, modal balancing; what it refuses."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import autobalance as ab
from autobalance.crank_dynamics.rotor.balancing import advice
from autobalance.crank_dynamics.rotor.beam_rotor import (
    BeamRotor,
    Disc,
    PointUnbalance,
    ShaftSection,
    spring_bearing,
)
from autobalance.crank_dynamics.rotor.critical_speeds import CriticalSpeed, critical_speeds, prepared
from autobalance.crank_dynamics.rotor.unbalance_response import unbalance_response
from autobalance.engines.bearings.film import JournalBearing, film_at_load
from autobalance.engines.bearings.reynolds import ocvirk
from autobalance.errors import JobError

Values = dict[str, Any]
SHAFT = {"length_mm": 1000, "outer_mm": 50}
DISC = {"z_mm": 300, "mass_kg": 30, "polar_kg_mm2": 3e5, "diametral_kg_mm2": 1.6e5}
SOFT = ({"z_mm": 0, "k_n_m": 1e7}, {"z_mm": 1000, "k_n_m": 1e7})
ORTHOTROPIC = tuple({"z_mm": z, "kxx_n_m": 1e7, "kyy_n_m": 2e7} for z in (0, 1000))


def solved(**file: Any) -> Values:
    return ab.rotor({"shaft": [SHAFT], "disc": [DISC], "bearing": list(SOFT), "max_modes": 4, **file}).report


# --- modes and critical speeds ------------------------------------------------------------------------------


def rigid_rotor(**file: Any) -> Values:
    """Return a stiff light shaft with a disc amid springs: two translations and two tilts."""
    return solved(
        shaft=[{"length_mm": 200, "outer_mm": 150, "density_kg_m3": 1e-3, "e_gpa": 1e4, "shear_factor": 1e3}],
        disc=[{"z_mm": 100, "mass_kg": 10, "polar_kg_mm2": 6e4, "diametral_kg_mm2": 4e4}],
        bearing=[{"z_mm": 0, "k_n_m": 1e5}, {"z_mm": 200, "k_n_m": 1e5}],
        **file,
    )


def test_a_rigid_rotor_on_springs_precesses_as_its_gyroscope() -> None:
    rpm = 6000.0
    report = rigid_rotor(speed_rpm=rpm)
    spin, tilt, polar, diametral = rpm * np.pi / 30.0, 2e5 * 0.1**2, 0.06, 0.04
    half = polar * spin / (2.0 * diametral)
    root = np.sqrt(half**2 + tilt / diametral)
    bounce = np.sqrt(2e5 / 10.0)
    expected = sorted([bounce, bounce, root - half, root + half])
    found = [2.0 * np.pi * mode["frequency_hz"] for mode in report["modes"]]
    assert found == pytest.approx(expected, rel=1e-6)
    by_frequency = {round(mode["frequency_hz"], 3): mode["whirl"] for mode in report["modes"]}
    assert by_frequency[round((root + half) / (2.0 * np.pi), 3)] == "forward"
    assert by_frequency[round((root - half) / (2.0 * np.pi), 3)] == "backward"
    # Ω² (Id ± Ip) = k: no forward critical speed of the tilt, as Ip > Id
    criticals = {(each["whirl"], round(each["speed_rpm"], 1)) for each in report["criticals"]}
    backward = np.sqrt(tilt / (diametral + polar))
    assert ("backward", round(backward * 30.0 / np.pi, 1)) in criticals
    assert not any(w == "forward" and abs(n - bounce * 30 / np.pi) > 1.0 for w, n in criticals)


def test_at_no_speed_pairs_are_two_modes_in_planes() -> None:
    report = solved(speed_rpm=0)
    first, second = report["modes"][:2]
    assert first["frequency_hz"] == pytest.approx(second["frequency_hz"], rel=1e-9)
    assert {mode["whirl"] for mode in report["modes"]} == {None}
    assert max(point["y"] for point in first["shape"]) == 0.0
    assert max(point["x"] for point in first["shape"]) == pytest.approx(1.0)
    assert report["critical_speeds_rpm"] == []


def test_a_damped_mode_has_the_decrement_of_its_spring_and_damper() -> None:
    file: Values = {"shaft": [{"length_mm": 100, "outer_mm": 100, "density_kg_m3": 1e-3, "e_gpa": 1e6}]}
    disc = {"z_mm": 50, "mass_kg": 10, "diametral_kg_mm2": 1e4}
    k, c, m = 4e5, 800.0, 10.0
    bearing = [{"z_mm": z, "k_n_m": k / 2, "c_n_s_m": c / 2} for z in (0, 100)]
    mode = solved(speed_rpm=100, **file, disc=[disc], bearing=bearing, max_modes=1)["modes"][0]
    ratio = c / (2.0 * np.sqrt(k * m))
    assert mode["frequency_hz"] == pytest.approx(np.sqrt(k / m * (1 - ratio**2)) / (2 * np.pi), rel=1e-5)
    assert mode["log_decrement"] == pytest.approx(2 * np.pi * ratio / np.sqrt(1 - ratio**2), rel=1e-5)
    heavy = [{"z_mm": z, "k_n_m": k / 2, "c_n_s_m": 1.1 * np.sqrt(k * m)} for z in (0, 100)]
    lowest = solved(speed_rpm=0, **file, disc=[disc], bearing=heavy, max_modes=1)["modes"]
    assert not lowest or lowest[0]["frequency_hz"] > 2.0 * mode["frequency_hz"]  # overdamped: left out


def test_cross_coupling_feeds_the_forward_mode() -> None:
    coupled = [{**each, "kxx_n_m": 1e7, "kyy_n_m": 1e7, "kxy_n_m": 1e6, "kyx_n_m": -1e6} for each in SOFT]
    for each in coupled:
        del each["k_n_m"]
    modes = solved(speed_rpm=1000, bearing=coupled)["modes"]
    decrement = {mode["whirl"]: mode["log_decrement"] for mode in modes[:2]}
    assert decrement["forward"] < 0.0 < decrement["backward"]


def test_direct_and_searched_critical_speeds_agree() -> None:
    """A vanishing damper sends the same rotor the other way."""
    direct = solved(speed_rpm=[0, 20000], points=2, bearing=list(ORTHOTROPIC))
    damped = [{**each, "c_n_s_m": 1e-3} for each in ORTHOTROPIC]
    searched = solved(speed_rpm=[0, 20000], points=2, bearing=damped)
    assert len(direct["criticals"]) >= 4
    assert searched["critical_speeds_rpm"] == pytest.approx(direct["critical_speeds_rpm"], rel=1e-7)
    for one, other in zip(direct["criticals"], searched["criticals"], strict=True):
        assert one["whirl"] == other["whirl"]
        assert 0.0 < other["log_decrement"] < 1e-4


def test_critical_speeds_lie_on_the_line_of_the_campbell_diagram() -> None:
    damped = [{**each, "c_n_s_m": 3e3} for each in ORTHOTROPIC]
    report = solved(speed_rpm=3000, bearing=damped)
    assert report["criticals"]
    for critical in report["criticals"]:
        rpm = [critical["speed_rpm"], 1.001 * critical["speed_rpm"]]
        there = solved(speed_rpm=rpm, points=2, bearing=damped, max_modes=10)["modes"]
        near = min(there, key=lambda mode: abs(60 * mode["frequency_hz"] - critical["speed_rpm"]))
        assert 60.0 * near["frequency_hz"] == pytest.approx(critical["speed_rpm"], rel=1e-6)
        assert near["log_decrement"] == pytest.approx(critical["log_decrement"], rel=1e-3)


def test_a_bearing_that_stiffens_with_speed_moves_its_critical_speed() -> None:
    """With k = a + b Ω of a rigid rotor Ω² m = k(Ω) is quadratic."""
    slope, rpm, base = 200.0, [0.0, 10000.0], 1e5
    top = rpm[1] * np.pi / 30.0
    stiffness = [base / 2, (base + slope * top) / 2]
    file: Values = {
        "shaft": [{"length_mm": 100, "outer_mm": 100, "density_kg_m3": 1e-3, "e_gpa": 1e6}],
        "disc": [{"z_mm": 50, "mass_kg": 10, "polar_kg_mm2": 0, "diametral_kg_mm2": 1e5}],
    }
    bearing = [{"z_mm": z, "speeds_rpm": rpm, "k_n_m": stiffness} for z in (0, 100)]
    report = solved(**file, bearing=bearing, speed_rpm=[0, 2500], points=2)
    exact = (slope + np.sqrt(slope**2 + 4.0 * 10.0 * base)) / 20.0
    assert any(n == pytest.approx(exact * 30.0 / np.pi, rel=1e-6) for n in report["critical_speeds_rpm"])


# --- rigid-body motion --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("bearing", "free"),
    [
        ([], 4),
        ([{"z_mm": 0, "kind": "pinned"}], 2),
        ([{"z_mm": 500, "k_n_m": 1e6}], 2),
        ([{"z_mm": 0, "kind": "clamped"}], 0),
        ([{"z_mm": 0, "kxx_n_m": 1e6, "kyy_n_m": 0}, {"z_mm": 900, "kxx_n_m": 1e6, "kyy_n_m": 0}], 2),
        (list(SOFT), 0),
    ],
)
def test_rigid_body_modes_are_counted_and_left_out(bearing: list[Values], free: int) -> None:
    report = solved(speed_rpm=0, bearing=bearing)
    assert report["rigid_body_modes"] == free
    assert report["modes"][0]["frequency_hz"] > 10.0
    if free == 4:
        assert "4 rigid-body modes" in ab.rotor({"shaft": [SHAFT]}).text()


def test_a_free_rotor_far_too_stiff_for_its_speed_has_no_critical_one() -> None:
    report = ab.rotor({"speed_rpm": 3000, "shaft": [{"length_mm": 200, "outer_mm": 20}]}).report
    assert report["critical_speeds_rpm"] == []
    assert report["rigid_body_modes"] == 4
    assert {mode["whirl"] for mode in report["modes"]} == {"forward", "backward"}


def test_a_free_rotor_has_no_sag_under_gravity() -> None:
    report = solved(bearing=[], gravity_m_s2=[0, -9.81])
    assert report["static"] == {"deflections": [], "reactions": []}


# --- response -----------------------------------------------------------------------------------------------


def test_between_two_planes_critical_speeds_the_orbit_runs_backward() -> None:
    report = solved(speed_rpm=0, bearing=list(ORTHOTROPIC), disc=[{"z_mm": 500, "mass_kg": 30}])
    first, second = (60.0 * report["modes"][n]["frequency_hz"] for n in (0, 1))
    heavy = [{"z_mm": 500, "g_mm": 100, "angle_deg": 40}]
    for rpm, sign in ((0.5 * first, 1.0), (0.5 * (first + second), -1.0), (1.2 * second, 1.0)):
        point = solved(
            speed_rpm=rpm, bearing=list(ORTHOTROPIC), disc=[{"z_mm": 500, "mass_kg": 30}], unbalance=heavy
        )["response"][0]["points"][0]
        assert np.sign(point["minor_um"]) == sign
        assert abs(point["minor_um"]) <= point["major_um"]
        axes = sorted([abs(point["minor_um"]), point["major_um"]])
        assert axes == pytest.approx(sorted([point["x_um"], point["y_um"]]), rel=1e-9)
    slow = solved(speed_rpm=10, unbalance=heavy)["response"][0]["points"][0]
    assert slow["x_phase_deg"] == pytest.approx(40.0, abs=1e-3)
    assert slow["y_phase_deg"] == pytest.approx(-50.0, abs=1e-3)


def test_at_zero_speed_nothing_moves_and_a_probe_may_stand_anywhere() -> None:
    report = solved(
        speed_rpm=[0, 100], points=2, unbalance=[{"z_mm": 123.4, "g_mm": 5}], probe=[{"z_mm": 777.7}]
    )
    assert [each["z_mm"] for each in report["response"]] == [777.7]
    assert report["response"][0]["points"][0]["major_um"] == 0.0
    assert json.loads(json.dumps(report, allow_nan=False))


def test_probes_default_to_every_disc_and_bearing() -> None:
    assert [each["z_mm"] for each in solved()["response"]] == [300.0, 0.0, 1000.0]


# --- sag ----------------------------------------------------------------------------------------------------


def test_sag_of_a_pinned_beam_and_its_bearings_forces() -> None:
    held = [{"z_mm": z, "kind": "pinned"} for z in (0, 1000)]
    report = solved(disc=[], bearing=held, gravity_m_s2=[0.0, -9.81], beam="euler")
    area, second = np.pi / 4 * 0.05**2, np.pi / 64 * 0.05**4
    line = 7850 * area * 9.81
    middle = [each for each in report["static"]["deflections"] if each["z_mm"] == pytest.approx(500.0)]
    assert middle[0]["y_um"] == pytest.approx(-1e6 * 5 * line / (384 * 210e9 * second), rel=1e-9)
    assert [each["y_N"] for each in report["static"]["reactions"]] == pytest.approx([line / 2, line / 2])


def test_bearings_inside_the_shaft_share_the_weight_by_levers() -> None:
    bearing = [{"z_mm": 200, "k_n_m": 1e8}, {"z_mm": 700, "k_n_m": 3e7}]
    report = solved(bearing=bearing, gravity_m_s2=[2.0, -9.81])
    weight, centre = report["mass_kg"], report["centre_of_mass_mm"]
    left = (700.0 - centre) / 500.0
    first, second = report["static"]["reactions"]
    assert first["y_N"] == pytest.approx(9.81 * weight * left, rel=1e-9)
    assert second["y_N"] == pytest.approx(9.81 * weight * (1.0 - left), rel=1e-9)
    assert first["x_N"] == pytest.approx(-2.0 * weight * left, rel=1e-9)


# --- balancing ----------------------------------------------------------------------------------------------


def flexible_rotor(added: tuple[PointUnbalance, ...] = ()) -> BeamRotor:
    stiff = np.diag([2e7, 3e7])
    heavy = (PointUnbalance(0.2, 3e-4, 0.4), PointUnbalance(0.55, 2e-4, -2.0), PointUnbalance(0.9, 4e-4, 2.5))
    return BeamRotor(
        (ShaftSection(1.2, 0.05, 0.05),),
        (Disc(0.4, 12.0, 0.1, 0.06), Disc(0.8, 15.0, 0.12, 0.07)),
        (spring_bearing(0.0, stiff), spring_bearing(1.2, stiff)),
        heavy + added,
    )


@pytest.mark.parametrize("rigid", [False, True])
def test_modal_correction_leaves_the_told_modes_without_excitation(rigid: bool) -> None:
    planes = [100, 300, 600, 1100] if rigid else [300, 1100]
    file: Values = {
        "shaft": [{"length_mm": 1200, "outer_mm": 50}],
        "disc": [
            {"z_mm": 400, "mass_kg": 12, "polar_kg_mm2": 1e5, "diametral_kg_mm2": 6e4},
            {"z_mm": 800, "mass_kg": 15, "polar_kg_mm2": 1.2e5, "diametral_kg_mm2": 7e4},
        ],
        "bearing": [{"z_mm": z, "k_n_m": 2e7} for z in (0, 1200)],
        "unbalance": [
            {"z_mm": 200, "g_mm": 300, "angle_deg": 23},
            {"z_mm": 550, "g_mm": 200, "angle_deg": -115},
            {"z_mm": 900, "g_mm": 400, "angle_deg": 143},
        ],
        "balancing": {"planes_mm": planes, "modes": 2, "rigid": rigid},
    }
    report = ab.rotor(file).report
    everything = [*file["unbalance"], *report["balancing"]]
    phasor = [each["g_mm"] * np.exp(1j * np.radians(each["angle_deg"])) for each in everything]
    bare = {key: value for key, value in file.items() if key != "balancing"}
    still = ab.rotor({**bare, "speed_rpm": 0}).report
    for mode in (still["modes"][0], still["modes"][2]):
        z = np.array([each["z_mm"] for each in mode["shape"]])
        axis = "x" if max(each["x"] for each in mode["shape"]) > 0.5 else "y"
        shape = np.array(
            [each[axis] * np.cos(np.radians(each[f"{axis}_phase_deg"])) for each in mode["shape"]]
        )
        at = CubicSpline(z, shape)([each["z_mm"] for each in everything])
        before = abs(np.dot(at[:3], phasor[:3]))
        assert abs(np.dot(at, phasor)) < 1e-4 * before  # the shape is told at points
    if rigid:
        lever = [each["z_mm"] for each in everything]
        assert abs(sum(phasor)) < 1e-6
        assert abs(np.dot(lever, phasor)) < 1e-3


def test_later_modes_keep_the_earlier_ones_balanced() -> None:
    """The response at the first critical speed stays small when the second mode is balanced too."""
    from autobalance.crank_dynamics.rotor.balancing import modal_correction

    rotor = flexible_rotor()
    ready = prepared(rotor, 600.0, 6, [0.3, 0.5, 1.1])
    there = [(each.z_m, each.phasor_kg_m) for each in rotor.unbalances]
    first = critical_speeds(ready, 600.0)[0].speed_rad_s * 1.001

    def peak(planes: list[float], modes: int) -> float:
        added = modal_correction(ready.reduced, planes, modes, False, there)
        whole = there + list(zip(planes, added, strict=True))
        return major(whole)

    def major(unbalances: list[tuple[float, complex]]) -> float:
        (probe,) = unbalance_response(ready.matrices, np.array([first]), [0.4], unbalances)
        assert probe.points[0].major_m is not None
        return probe.points[0].major_m

    bare = major(there)
    # four conditions: each shape in x and in y, as the bearings differ
    assert peak([0.3, 0.5], 2) < 0.02 * bare
    assert peak([0.3, 0.5, 0.8, 1.1], 4) < 0.02 * bare


@pytest.mark.parametrize(
    ("planes", "modes", "rigid", "words"),
    [
        ([300], 2, False, "1 planes given; 2 modes need 2"),
        ([300, 400], 1, True, "1 mode with resultant and moment need 3"),
        ([300, 300], 2, False, "cannot reach"),
    ],
)
def test_planes_that_cannot_do_it_are_refused(planes: list[int], modes: int, rigid: bool, words: str) -> None:
    with pytest.raises(JobError, match=words):
        solved(balancing={"planes_mm": planes, "modes": modes, "rigid": rigid})


def test_advice_follows_the_place_of_the_service_speed() -> None:
    criticals = [CriticalSpeed(50.0, "backward", 0.0), CriticalSpeed(100.0, "forward", 0.0)]
    criticals.append(CriticalSpeed(300.0, "forward", 0.0))
    assert advice(60.0, criticals).behaviour == "rigid"
    assert [each.letter for each in advice(60.0, criticals).procedures] == ["A", "B"]
    assert advice(90.0, criticals).planes == 3
    assert [each.letter for each in advice(400.0, criticals).procedures] == ["G"]
    assert advice(400.0, criticals).planes == 4


def test_the_stiffness_map_ends_where_bearings_are_rigid() -> None:
    asked = {"stiffness_map": {"k_n_m": [1e6, 1e12], "points": 3}, "speed_rpm": [0, 6000], "points": 2}
    rows = solved(**asked)["stiffness_map"]
    pinned = solved(speed_rpm=[0, 6000], points=2, bearing=[{"z_mm": z, "kind": "pinned"} for z in (0, 1000)])
    assert rows[0]["critical_speeds_rpm"][0] < rows[1]["critical_speeds_rpm"][0]
    assert rows[-1]["critical_speeds_rpm"] == pytest.approx(pinned["critical_speeds_rpm"], rel=1e-4)


# --- what is refused ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ({"shaft": []}, r"\[\[shaft\]\] is missing"),
        ({"shaft": [{**SHAFT, "length_mm": 0}]}, r"shaft\[1\].length_mm is 0; must be > 0"),
        ({"shaft": [{**SHAFT, "inner_mm": 60}]}, r"shaft\[1\].inner_mm is 60; must be less than the outer"),
        ({"shaft": [{**SHAFT, "inner_mm": 20, "outer_end_mm": 15}]}, "inner_end_mm is 20; must be less"),
        ({"shaft": [{**SHAFT, "nu": 0.3, "g_gpa": 80}]}, "nu and g_gpa are both given"),
        ({"shaft": [{**SHAFT, "g_gpa": 20}]}, "g_gpa is 20; .*Poisson's ratio"),
        ({"shaft": [{**SHAFT, "colour": 1}]}, "unknown key"),
        ({"bearing": [{"z_mm": 0}]}, r"bearing\[1\].k_n_m is missing"),
        ({"bearing": [{"z_mm": 0, "k_n_m": -5}]}, "k_n_m is -5; must be ≥ 0, or allow_negative"),
        ({"bearing": [{"z_mm": 0, "kxx_n_m": 5}]}, "kyy_n_m is missing"),
        ({"bearing": [{"z_mm": 0, "k_n_m": 5, "kxx_n_m": 5, "kyy_n_m": 5}]}, "both given"),
        ({"bearing": [{"z_mm": 0, "kind": "pinned", "k_n_m": 5}]}, "does not give"),
        ({"bearing": [{"z_mm": 0, "kind": "magnetic"}]}, "must be one of 'pinned', 'clamped'"),
        ({"bearing": [{"z_mm": 0, "k_n_m": [1, 2]}]}, "k_n_m is a list; it needs speeds_rpm"),
        ({"bearing": [{"z_mm": 0, "k_n_m": [1, 2], "speeds_rpm": [3, 1]}]}, "speeds that ascend"),
        ({"bearing": [{"z_mm": 0, "k_n_m": [1, 2], "speeds_rpm": [1, 2, 3]}]}, "has 2 entries; must be 3"),
        ({"disc": [{**DISC, "z_mm": 1001}]}, r"disc\[1\].z_mm is 1001; must lie on the shaft, 0 to 1000"),
        ({"speed_rpm": [100, 50]}, "the first must be the lower one"),
        ({"speed_rpm": -1}, "speed_rpm is -1; must be ≥ 0"),
        ({"speed_rpm": 3e6}, "speed_rpm is 3e\\+06; must be ≥ 0 and at most 1e6"),
        ({"shaft": [{**SHAFT, "outer_end_mm": 1}]}, r"shaft\[1\] tapers from 50 to 1 mm; .* by 20 at most"),
        ({"shaft": [SHAFT, {**SHAFT, "outer_mm": 0.2}]}, "diameters are from 0.2 to 50 mm; .* 200 times"),
        ({"shaft": [{**SHAFT, "length_mm": 2e8}]}, "2e\\+08 mm long and 50 mm thick; .* 2000 times"),
        (
            {
                "bearing": [
                    {"z_mm": 0, "k_n_m": 1e7},
                    {"z_mm": 1000, "k_n_m": -1e9, "allow_negative": True},
                ],
                "balancing": {"planes_mm": [300], "modes": 1},
            },
            "let the shaft fly off at rest",
        ),
        ({"speed_rpm": "fast"}, "speed_rpm is 'fast'"),
        ({"run_up": {"to_rpm": 100, "from_rpm": 100, "time_s": 1}}, "must be another"),
        ({"stiffness_map": {"k_n_m": [5, 5]}}, "the first must be the lower one"),
        (
            {"stiffness_map": {"k_n_m": [1, 5]}, "bearing": [{"z_mm": 0, "kind": "pinned"}]},
            "needs a .*bearing.* with a stiffness",
        ),
        ({"balancing": {"planes_mm": []}}, "planes_mm is an empty list"),
        ({"balancing": {"planes_mm": [-1]}}, "planes_mm is -1; must lie on the shaft"),
    ],
)
def test_bad_input_is_one_line(file: Values, words: str) -> None:
    with pytest.raises(JobError, match=words) as refused:
        solved(**file)
    assert "\n" not in str(refused.value)


def test_negative_stiffness_that_is_told_is_solved() -> None:
    bearing = [*SOFT, {"z_mm": 500, "k_n_m": -1e5, "allow_negative": True}]
    assert (
        solved(speed_rpm=0, bearing=bearing)["modes"][0]["frequency_hz"]
        < (solved(speed_rpm=0)["modes"][0]["frequency_hz"])
    )


def test_input_has_its_defaults_filled_in() -> None:
    given = solved()["input"]
    assert given["beam"] == "timoshenko"
    assert given["speed_rpm"] == 3000.0
    assert given["shaft"][0]["outer_end_mm"] == 50.0
    assert given["shaft"][0]["g_gpa"] == pytest.approx(210 / 2.6)


# --- oil films ----------------------------------------------------------------------------------------------

FILM = {
    "diameter_mm": 40,
    "length_mm": 20,
    "radial_clearance_mm": 0.04,
    "viscosity_Pa_s": 0.02,
    "solver": "ocvirk",
}


def on_films(mass_kg: float, weight: float, **film: Any) -> Values:
    bearing = [{"z_mm": z, "film": {**FILM, "load_N": [0.0, -weight], **film}} for z in (0, 100)]
    stiff = {"length_mm": 100, "outer_mm": 60, "density_kg_m3": 1.0, "e_gpa": 1e5}
    disc = {"z_mm": 50, "mass_kg": mass_kg, "diametral_kg_mm2": 1e5}
    return solved(shaft=[stiff], disc=[disc], bearing=bearing, speed_rpm=[5999, 6000], points=2)


def test_a_rotor_on_oil_films_whirls_from_its_threshold_on() -> None:
    load, speed = 300.0, 5999.0 * np.pi / 30.0
    journal = JournalBearing(0.04, 0.02, 4e-5)
    film = film_at_load(journal, ocvirk(0.5), 0.02, speed, load)
    assert film is not None
    assert film.whirl.critical_mass_kg is not None
    for share, sign in ((0.97, 1.0), (1.03, -1.0)):
        report = on_films(2.0 * share * film.whirl.critical_mass_kg, load)
        least = min(report["modes"], key=lambda mode: float(mode["log_decrement"]))
        assert np.sign(least["log_decrement"]) == sign
        assert least["whirl"] == "forward"
        assert least["frequency_hz"] * 2 * np.pi / speed == pytest.approx(film.whirl.whirl_ratio, rel=0.05)


@pytest.mark.parametrize(
    ("film", "words"),
    [
        ({"load_N": [0.0, 0.0]}, "a film without load has no direction"),
        ({"load_N": [0.0, -1e8]}, "the journal touches the bearing"),
        ({"clearance": 1}, "unknown key"),
    ],
)
def test_films_that_cannot_be_are_refused(film: Values, words: str) -> None:
    with pytest.raises(JobError, match=words):
        on_films(1.0, 100.0, **film)
