"""Balancing machines on rotors of known unbalance."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from autobalance.errors import JobError
from autobalance.job.reading import Convention
from autobalance.test_stands.bench.spun_rotor import (
    PlanarUnbalance,
    PointMass,
    RigidBody,
    axisymmetric,
    spun_rotor,
)
from autobalance.test_stands.machine.balancing_machine import (
    DrillPlace,
    HoleDirection,
    free_displacement,
    node_mm,
    roll_time_s,
    sprung_displacements,
    static_stand,
)
from autobalance.test_stands.machine.input import MACHINE_KEYS
from autobalance.test_stands.machine.verb import machine
from autobalance.test_stands.machine.watch import reading_toml
from autobalance.toml_files.keys import json_schema

OMEGA_600 = 600.0 * 2.0 * math.pi / 60.0

FILE: dict[str, Any] = {
    "kind": "hard",
    "speed_rpm": 600.0,
    "planes_mm": [-40.0, 40.0],
    "bearings_mm": [-60.0, 70.0],
    "rotor": {"mass_g": 2546.4, "z_mm": 5.0, "transverse_kg_mm2": 2913.3, "polar_kg_mm2": 2943.8},
    "unbalance": [
        {"z_mm": -33.0, "g_mm": 120.0, "angle_deg": 200.0},
        {"z_mm": 51.0, "g_mm": 80.0, "angle_deg": 75.0},
    ],
    "static": {"journal_radius_mm": 10.0, "friction_lever_mm": 0.01},
}
TRUE = {-33.0: cmath.rect(120.0, math.radians(200.0)), 51.0: cmath.rect(80.0, math.radians(75.0))}


def report(**more: Any) -> dict[str, Any]:
    return machine({**FILE, **more}).report


def vector(values: dict[str, Any], key: str = "g_mm") -> complex:
    return cmath.rect(values[key], math.radians(values["angle_deg"]))


def lever_rule(z_A: float, z_B: float) -> tuple[complex, complex]:
    """Return the two-plane equivalent of the known unbalances, each shared by its levers (SYN-03)."""
    in_A = sum(u * (z_B - z) / (z_B - z_A) for z, u in TRUE.items())
    return in_A, sum(TRUE.values()) - in_A


@pytest.mark.parametrize("kind", ["hard", "soft", "cradle", "nodal"])
def test_reading_without_noise_is_the_rotor(kind: str) -> None:
    found = report(kind=kind)
    read = [vector(plane) for plane in found["runs"][0]["planes"]]
    assert np.allclose(read, lever_rule(-40.0, 40.0), rtol=1e-12)
    assert found["runs"][0]["left"]["magnitude_g_mm"] == pytest.approx(0.0, abs=1e-12)
    assert [plane["name"] for plane in found["rotor"]["planes"]] == ["A", "B"]


def test_forces_of_hard_bearings_hold_the_rotor() -> None:
    sensors = report()["sensors"]
    forces = [vector(each, "force_N") for each in sensors]
    square = OMEGA_600**2 * 1e-6
    assert np.allclose(forces, [square * each for each in lever_rule(-60.0, 70.0)], rtol=1e-12)
    assert [each["displacement_um"] for each in sensors] == [None, None]


def test_soft_bearings_let_the_rotor_turn_about_its_principal_axis() -> None:
    found = report(kind="soft")
    total, moment = sum(TRUE.values()), sum(z * u for z, u in TRUE.items())
    couple = moment - 5.0 * total
    for sensor in found["sensors"]:
        expected = -total / 2546.4 - (sensor["z_mm"] - 5.0) * couple / 2913.3e3
        assert vector(sensor, "displacement_um") == pytest.approx(1e3 * expected)


def test_springs_stand_between_soft_and_hard() -> None:
    rotor = spun_rotor(axisymmetric(2546.4, 5.0, 2913.3e3, None), [PlanarUnbalance(20.0, 300j)], [])
    bearings = (-60.0, 70.0)
    free = sprung_displacements(rotor, bearings, 1e-3, OMEGA_600)
    assert free == pytest.approx([free_displacement(rotor, z) for z in bearings])
    stiff = 1e15
    forces = [stiff * x for x in sprung_displacements(rotor, bearings, stiff, OMEGA_600)]
    assert forces == pytest.approx([OMEGA_600**2 * each for each in rotor.in_planes(*bearings)], rel=1e-4)


def test_natural_frequency_on_the_supports_is_refused() -> None:
    # Supports alike on both sides of the centre: the rotor bounces at √(2 k/m).
    stiffness = 0.5 * 2546.4 * OMEGA_600**2 * 1e-6
    with pytest.raises(JobError, match="speed_rpm is 600: the speed is a natural frequency"):
        report(kind="soft", bearings_mm=[-55.0, 65.0], stiffness_n_mm=stiffness)


def test_cradle_does_not_read_the_plane_of_its_pivot() -> None:
    # SYN-02: 400 g·mm at a lever of 80 mm, 600 rpm.
    inside = [
        {"z_mm": -40.0, "g_mm": 999.0, "angle_deg": 10.0},
        {"z_mm": 40.0, "g_mm": 400.0, "angle_deg": 90.0},
    ]
    first, second = report(kind="cradle", unbalance=inside)["sensors"]
    assert first["moment_N_m"] == pytest.approx(0.126330936, rel=1e-8)
    assert first["angle_deg"] == pytest.approx(90.0)
    assert first["z_mm"] == -40.0
    assert second["moment_N_m"] == pytest.approx(999.0 * 80.0 * OMEGA_600**2 * 1e-9)
    assert second["angle_deg"] == pytest.approx(190.0)  # the lever to plane A is negative


def test_node_of_a_plane_does_not_move() -> None:
    # SYN-01: a shaft of 20 x 188 mm with a disc of 98 x 36.704 mm; planes 50 mm from its middle.
    rotor = {"mass_g": 2546.44572, "z_mm": 94.0, "transverse_kg_mm2": 2913.25805}
    in_B = [{"z_mm": 144.0, "g_mm": 500.0, "angle_deg": 30.0}]
    found = report(kind="nodal", rotor=rotor, planes_mm=[44.0, 144.0], unbalance=in_B)
    assert found["nodes"][1] == {"plane": "B", "z_mm": pytest.approx(94.0 - 22.880975, abs=1e-6)}
    assert found["nodes"][0] == {"plane": "A", "z_mm": pytest.approx(94.0 + 22.880975, abs=1e-6)}
    reads_A, reads_B = found["sensors"]
    assert reads_A["z_mm"] == found["nodes"][1]["z_mm"]
    assert reads_A["displacement_um"] == pytest.approx(0.0, abs=1e-12)
    assert reads_B["displacement_um"] > 100.0


@pytest.mark.parametrize(
    ("parts", "kind"),
    [
        ([], "balanced"),
        ([(5.0, 10.0)], "static"),
        ([(-20.0, 10.0), (30.0, 10.0)], "static"),
        ([(-20.0, 10.0), (20.0, -10.0)], "couple"),
        ([(30.0, 10.0)], "quasi_static"),
        ([(30.0, 10.0), (-20.0, 10.0j)], "dynamic"),
    ],
)
def test_kinds_of_unbalance(parts: list[tuple[float, complex]], kind: str) -> None:
    rotor = spun_rotor(RigidBody(1000.0, 5.0), [PlanarUnbalance(z, u) for z, u in parts], [])
    assert rotor.kind == kind


def test_principal_axis_of_point_masses() -> None:
    # Two masses alone: the axis of least inertia goes through both.
    masses = [PointMass(3.0, 4.0 + 3.0j, 12.0), PointMass(3.0, -4.0 - 3.0j, -12.0)]
    rotor = spun_rotor(axisymmetric(0.0, 0.0, 0.0, 0.0), [], masses)
    assert rotor.principal_axis_rad == pytest.approx(math.atan2(5.0, 12.0))
    assert rotor.kind == "couple"
    assert rotor.transverse_g_mm2 == pytest.approx(6.0 * (144.0 + 12.5))


def test_tilt_of_the_principal_axis_is_half_the_angle_of_couple_over_inertias() -> None:
    rotor = spun_rotor(axisymmetric(1000.0, 0.0, 9e5, 4e5), [PlanarUnbalance(50.0, 300.0)], [])
    assert rotor.principal_axis_rad == pytest.approx(
        0.5 * math.atan2(2.0 * 50.0 * 300.0, 9e5 - 4e5), rel=1e-3
    )
    assert spun_rotor(RigidBody(1.0, 0.0), [], []).principal_axis_rad is None


def test_rotor_with_masses_does_not_depend_on_the_datum() -> None:
    body, masses = axisymmetric(900.0, 10.0, 8e5, 5e5), [PointMass(20.0, 30.0 + 4j, -15.0)]
    rotor = spun_rotor(body, [PlanarUnbalance(7.0, 50j)], masses)
    moved = spun_rotor(
        axisymmetric(900.0, 110.0, 8e5, 5e5),
        [PlanarUnbalance(107.0, 50j)],
        [PointMass(20.0, 30.0 + 4j, 85.0)],
    )
    assert moved.z_mm == pytest.approx(rotor.z_mm + 100.0)
    assert moved.couple_g_mm2 == pytest.approx(rotor.couple_g_mm2)
    assert moved.principal_axis_rad == pytest.approx(rotor.principal_axis_rad)
    assert moved.in_planes(60.0, 140.0) == pytest.approx(rotor.in_planes(-40.0, 40.0))


def test_roll_of_the_static_stand_against_the_equation_of_motion() -> None:
    unbalance, least, inertia, start = 200.0, 25.0, 3e6, math.radians(110.0)

    def motion(_: float, state: Any) -> list[float]:
        return [state[1], 9806.65 * (least - unbalance * math.sin(state[0])) / inertia]

    def down(_: float, state: Any) -> float:
        return float(state[0])

    down.terminal = True  # type: ignore[attr-defined]
    path: Any = solve_ivp(motion, (0.0, 60.0), [start, 0.0], events=down, rtol=1e-11, atol=1e-12)
    assert roll_time_s(unbalance, least, inertia, start) == pytest.approx(path.t_events[0][0], rel=1e-8)


def test_small_swing_of_the_static_stand_takes_a_quarter_period() -> None:
    time_s = roll_time_s(200.0, 0.0, 3e6, 1e-3)
    assert time_s == pytest.approx(0.5 * math.pi * math.sqrt(3e6 / (200.0 * 9806.65)), rel=1e-6)


def test_static_stand_of_a_file() -> None:
    found = report(kind="static")
    total = abs(sum(TRUE.values()))
    static = found["static"]
    assert static["least_g_mm"] == pytest.approx(25.464)
    assert static["rest_within_deg"] == pytest.approx(math.degrees(math.asin(25.464 / total)))
    inertia = 2943.8e3 + 2546.4 * 10.0**2
    assert static["roll_time_s"] == pytest.approx(
        roll_time_s(total, 25.464, inertia, 0.5 * math.pi), rel=1e-9
    )
    (plane,) = found["runs"][0]["planes"]
    assert vector(plane) == pytest.approx(sum(TRUE.values()))
    assert found["sensors"] is None
    assert found["nodes"] is None


def test_static_stand_stops_where_friction_holds() -> None:
    assert not static_stand(25.0, 2500.0, 0.01, 10.0, 1.0, 1e6).rolls
    held = static_stand(100.0, 2500.0, 0.01, 10.0, math.radians(10.0), 1e6)  # sin 10° < 1/4
    assert held.rolls
    assert held.roll_time_s is None
    part_way = static_stand(100.0, 2500.0, 0.01, 10.0, math.radians(20.0), 1e6)  # 1 − cos 20° < 0.35/4
    assert part_way.roll_time_s is None
    assert "does not roll" in report(kind="static", unbalance=[])["warnings"][0]


def test_noise_has_the_spread_it_is_asked_for() -> None:
    found = report(runs=8000, seed=7, noise={"g_mm": 2.0, "gain_percent": 5.0, "angle_deg": 3.0})
    true = np.array(lever_rule(-40.0, 40.0))
    read = np.array([[vector(plane) for plane in run["planes"]] for run in found["runs"]])
    off = (read - true) / true
    spread = np.sqrt((2.0 / np.abs(true)) ** 2)
    assert np.allclose(off.real.std(axis=0), np.hypot(spread, 0.05), rtol=0.03)
    assert np.allclose(off.imag.std(axis=0), np.hypot(spread, math.radians(3.0)), rtol=0.03)
    for plane, sizes in zip(found["noise"]["g_mm"], np.abs(read).T, strict=True):
        assert plane["mean"] == pytest.approx(sizes.mean())
        assert plane["standard_deviation"] == pytest.approx(sizes.std(ddof=1))


def test_same_seed_gives_the_same_bytes() -> None:
    noise = {"g_mm": 2.0}
    one, other = (machine({**FILE, "noise": noise, "seed": 5}) for _ in range(2))
    assert one.json() == other.json()
    assert one.files() == other.files()
    assert machine({**FILE, "noise": noise, "seed": 6}).json() != one.json()


@pytest.mark.parametrize("direction", ["radial", "axial"])
def test_depth_of_a_hole_takes_off_what_was_read(direction: HoleDirection) -> None:
    drill = {"diameter_mm": 8.0, "radius_mm": 45.0, "direction": direction}
    found = report(drill=drill)
    for plane in found["corrections"]:
        depth, point, area = plane["depth_mm"], 4.0 / math.tan(math.radians(59.0)), math.pi * 16.0
        r_full, r_point = (
            (45.0 - depth / 2, 45.0 - depth - point / 4) if direction == "radial" else (45.0, 45.0)
        )
        off = 7850e-6 * area * (depth * r_full + point / 3.0 * r_point)
        assert off == pytest.approx(plane["g_mm"])


def test_depth_that_no_hole_has_is_null_and_warned_of() -> None:
    found = report(drill={"diameter_mm": 3.0, "radius_mm": 10.0})
    assert [plane["depth_mm"] for plane in found["corrections"]] == [None, None]
    assert "no hole is deep enough" in found["warnings"][0]
    wide = DrillPlace(20.0, 45.0, math.radians(118.0), 7850e-6, "axial")
    assert wide.depth_mm(1.0) is None


@pytest.mark.parametrize("rotation", ["ccw", "cw"])
@pytest.mark.parametrize("reads", ["heavy", "light"])
def test_reading_counts_as_the_machine_does(rotation: Any, reads: Any) -> None:
    convention = Convention(rotation, 33.0, reads)
    assert convention.rotor_deg(convention.machine_deg(123.4)) == pytest.approx(123.4)
    turned = 10.0 if rotation == "ccw" else -10.0
    assert convention.rotor_deg(10.0) == pytest.approx(
        (33.0 + turned + (180.0 if reads == "light" else 0.0)) % 360.0
    )


def test_reading_file_says_what_was_read() -> None:
    import tomllib

    asked = {"rotation": "cw", "zero_deg": 20.0, "reads": "light", "urr_percent": 95.0, "umar_g_mm": 2.0}
    found = machine({**FILE, "reading": asked})
    written = tomllib.loads(reading_toml(found.content))
    convention = Convention("cw", 20.0, "light")
    for plane, read in zip(written["plane"], found.content.runs[0].planes, strict=True):
        assert convention.rotor_deg(plane["angle_deg"]) == pytest.approx(read.angle_deg)
        assert plane["g_mm"] == read.g_mm
    assert {key: written[key] for key in asked} == asked


def test_node_needs_a_lever() -> None:
    rotor = spun_rotor(axisymmetric(1.0, 5.0, 1.0, None), [], [])
    with pytest.raises(ValueError, match="no node"):
        node_mm(rotor, 5.0)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"kind": "harder"}, "kind"),
        ({"speed_rpm": None}, "speed_rpm is missing"),
        ({"planes_mm": None}, "planes_mm is missing"),
        ({"planes_mm": [1.0, 1.0]}, "planes_mm is [1, 1]; expected two different places"),
        ({"rotor": {}}, "rotor.mass_g is missing; or rotor.report"),
        ({"rotor": {"mass_g": 1.0}}, "rotor.z_mm is missing"),
        ({"rotor": {"mass_g": 0.0}}, "rotor.mass_g is 0 and there is no [[mass]]"),
        ({"rotor": {"report": "r.json", "mass_g": 1.0}}, "rotor.mass_g is given with rotor.report"),
        ({"kind": "nodal", "rotor": {"mass_g": 1.0, "z_mm": 0.0}}, "rotor.transverse_kg_mm2 is missing"),
        (
            {"rotor": {"mass_g": 1.0, "z_mm": 0.0, "transverse_kg_mm2": 1.0, "polar_kg_mm2": 3.0}},
            "over twice transverse_kg_mm2",
        ),
        ({"kind": "nodal", "planes_mm": [-40.0, 5.0]}, "no node"),
        ({"kind": "static", "static": None}, "[static] is missing"),
        ({"runs": 0}, "runs is 0; must be 1 to"),
        ({"reading": {"urr_percent": 120.0}}, "reading.urr_percent is 120; must be > 0 and"),
    ],
)
def test_bad_machines_are_named(more: dict[str, Any], message: str) -> None:
    task = {key: value for key, value in {**FILE, **more}.items() if value is not None}
    with pytest.raises(JobError) as refused:
        machine(task)
    assert message in str(refused.value)


def test_schema_allows_what_is_read() -> None:
    import jsonschema

    schema = json_schema("machine", MACHINE_KEYS)
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(FILE, schema)
