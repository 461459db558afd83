"""Weight of crank, rods and pistons, and the pull of a drive, in the loads of a cycle."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.running_gear.loads import loads
from autobalance.running_gear.whole_engine import Engine
from autobalance.toml_files.document import toml_text
from tests.near import near
from tests.reference.test_articulated import radial
from tests.reference.test_cycle_doubts import preset

Values = dict[str, Any]
G = 9.80665


@lru_cache(maxsize=4)
def crank(name: str) -> ab.Crank:
    return preset(name)


def job_of(name: str, **cycle: Any) -> Values:
    orders = {"single": [1], "inline-4": [1, 3, 4, 2], "v-twin-45": [1, 2]}
    banks = {"single": 20.0, "inline-4": [0.0], "v-twin-45": [0.0, 45.0]}
    return {
        "engine": {
            "rod_length_mm": 140.0,
            "layout": {"bank_deg": banks[name], "offset_mm": 6.0},
            "rotating_g": {"big_end": 300.0},
            "reciprocating_g": {"piston": 400.0},
        },
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 3000},
        "correction": {"method": "drill"},
        "cycle": {
            "bore_mm": 80.0,
            "compression_ratio": 10.0,
            "heat_J": 700.0,
            "gamma": 1.35,
            "flywheel_kg_mm2": 60000.0,
            "firing_order": orders[name],
            "friction": {"main_mu": 0.01},
            **cycle,
        },
    }


@pytest.mark.parametrize("turns", ["ccw", "cw"])
@pytest.mark.parametrize("name", ["single", "inline-4"])
@pytest.mark.parametrize("direction", [180.0, -65.0])
def test_all_that_has_weight_hangs_on_mains_walls_and_nothing_else(
    name: str, direction: float, turns: str
) -> None:
    """Hoem & Røsholm 2016, Sec. 4.2.1, load 1: forces balance; the work of weights is potential energy."""
    part = {"name": "flywheel", "mass_kg": 5.0, "z_mm": -60.0}
    job = job_of(name, gravity={"direction_deg": direction, "part": [part]})
    plain = job_of(name)
    for each in (job, plain):
        each["engine"]["turns"] = turns
    heavy, light = (ab.cycle(each, crank=crank(name)) for each in (job, plain))
    side = -1.0 if turns == "cw" else 1.0
    down = np.array([math.cos(math.radians(direction)), side * math.sin(math.radians(direction))])
    engine = heavy.analysis.firing.engine
    mass = crank(name).mass_g + 5000.0 + len(engine.cylinders) * 700.0
    # every load that bears on the block, of the cycle with weight less that of the same without
    total = (heavy.analysis.loads.main_n - light.analysis.loads.main_n).sum(axis=0)
    walls = heavy.analysis.loads.wall_n - light.analysis.loads.wall_n
    for cylinder, wall in zip(engine.cylinders, walls, strict=True):
        total = total + wall[:, None] * np.array([-math.sin(cylinder.bank_rad), math.cos(cylinder.bank_rad)])
    assert near(total, np.tile(mass * G * 1e-3 * down, (len(total), 1)), rel=1e-9, within=1e-8)
    # the torque's work is what the masses fall
    torque, grid = heavy.analysis.weight_n_m, heavy.analysis.grid
    assert torque is not None
    angle = np.append(grid.even_rad, grid.span_rad)

    def height(at: np.ndarray) -> np.ndarray:
        places = np.zeros((at.size, 2))
        for each in engine.cylinders:
            motion = each.slider_crank.motion(at + each.throw_angle_rad - each.bank_rad)
            pin = each.slider_crank.crank_radius_mm * np.exp(1j * (at + each.throw_angle_rad))
            wrist = (motion.x_mm + 1j * each.slider_crank.offset_mm) * np.exp(1j * each.bank_rad)
            place = each.rotating_g * pin + each.reciprocating_g * wrist
            places += np.stack([place.real, place.imag], axis=-1)
        for piece in engine.crank:
            turned = complex(*piece.unbalance_g_mm) * np.exp(1j * at)
            places += np.stack([turned.real, turned.imag], axis=-1)
        return np.asarray(places @ down * G * 1e-6)

    work = grid.work_to_even(torque)
    fallen = height(angle) - height(angle[:1])
    assert near(work, fallen, within=1e-9 * np.abs(fallen).max() + 1e-12)
    told = heavy.report["weight"]
    assert told["crank_N"] + told["rods_and_pistons_N"] == pytest.approx(mass * G * 1e-3, rel=1e-9)
    assert sum(each["crank_N"] for each in told["main_journals"]) == pytest.approx(told["crank_N"], rel=1e-9)
    assert told["friction_without_N_m"] == pytest.approx(light.analysis.friction_mean_n_m, rel=1e-9)
    assert told["friction_mean_N_m"] == heavy.report["torque"]["friction_mean_N_m"]
    for one, other in zip(told["main_journals"], light.report["loads"]["main_journals"], strict=True):
        assert one["greatest_without_N"] == pytest.approx(other["greatest_N"], rel=1e-9)
    assert "Weight on the mains" in heavy.text()
    assert "weight" not in light.report


def test_weights_of_a_radial_load_its_crankpin_through_the_master_rod() -> None:
    """Free fall is a frame that accelerates: virtual work of all weights against the loads' own torque."""
    engine, fall = radial(5, 4.0, 0.03), complex(-7.0e3, 4.0e3)
    angle = np.linspace(0.0, 2.0 * math.pi, 400, endpoint=False)
    found = loads(Engine(engine.cylinders), (0.0, 10.0), 0.0, angle, gravity_mm_s2=fall)
    pins = sum(
        each.slider_crank.crank_radius_mm
        * (
            np.cos(angle + each.throw_angle_rad) * pin[:, 1]
            - np.sin(angle + each.throw_angle_rad) * pin[:, 0]
        )
        for each, pin in zip(engine.cylinders, found.crankpin_n, strict=True)
    )
    assert near(np.asarray(pins) * 1e-3, -found.torque_n_m, rel=1e-9, within=1e-12)
    mass = sum(each.rotating_g + each.reciprocating_g for each in engine.cylinders)
    total = found.main_n.sum(axis=0)
    for cylinder, wall in zip(engine.cylinders, found.wall_n, strict=True):
        total = total + wall[:, None] * np.array([-math.sin(cylinder.bank_rad), math.cos(cylinder.bank_rad)])
    push = mass * 1e-6 * np.array([fall.real, fall.imag])
    assert near(total, np.tile(push, (len(total), 1)), rel=1e-9)


def test_a_crank_that_bends_has_its_weight_too() -> None:
    """Two mains: statics alone decides, at any stiffness, what weight does."""
    part = {"mass_kg": 5.0, "z_mm": -60.0}
    job = job_of("single", gravity={"direction_deg": 200.0, "part": [part]})
    job["bearings"] = {"k_N_mm": 1e6}
    flexible = ab.cycle(job, crank=crank("single"), flexible=True).report["flexible"]
    assert flexible["rigid_difference"] < 1e-6


def test_films_tell_what_weight_takes_from_them() -> None:
    film = {"main_clearance_mm": 0.03, "viscosity_Pa_s": 0.02}
    down = {"direction_deg": 180.0, "part": [{"mass_kg": 40.0, "z_mm": -60.0}]}
    heavy = ab.cycle(job_of("single", gravity=down, film=film), crank=crank("single")).report
    light = ab.cycle(job_of("single", film=film), crank=crank("single")).report
    for told, now, bare in zip(
        heavy["weight"]["main_journals"],
        heavy["films"]["main_journals"],
        light["films"]["main_journals"],
        strict=True,
    ):
        assert told["least_film_without_mm"] == pytest.approx(bare["least_film_mm"], rel=1e-4)
        assert abs(now["least_film_mm"] - bare["least_film_mm"]) > 1e-6


def test_no_gravity_changes_nothing() -> None:
    heavy = ab.cycle(job_of("single", gravity={"direction_deg": 0.0, "m_s2": 1e-9}), crank=crank("single"))
    light = ab.cycle(job_of("single"), crank=crank("single"))
    assert near(heavy.analysis.loads.main_n, light.analysis.loads.main_n, rel=1e-9, within=1e-8)


# --- the drive's pull ---------------------------------------------------------------------------------------


def chain(**keys: Any) -> Values:
    drive = {
        "kind": "chain",
        "z_mm": -70.0,
        "pitch_radius_mm": 40.0,
        "direction_deg": 30.0,
        "teeth": 16,
        **keys,
    }
    return {key: value for key, value in drive.items() if value is not None}


def main_z(name: str) -> list[float]:
    return sorted(float(pin.centre_mm[2]) for pin in crank(name).main_journals)


@pytest.mark.parametrize("turns", ["ccw", "cw"])
def test_a_chain_pulls_with_what_the_engine_gives(turns: str) -> None:
    """Ruckle 2014, Sec. 1.3.6: the torque ends as a pull; power at the chain's own speed is the engine's."""
    with_chain, without = job_of("single", drive=[chain()]), job_of("single")
    for each in (with_chain, without):
        each["engine"]["turns"] = turns
    pulled, plain = (ab.cycle(each, crank=crank("single")) for each in (with_chain, without))
    parts, grid = pulled.analysis.firing.parts, pulled.analysis.grid
    assert parts.pulls is not None
    (pull,), (torque,) = parts.pulls.pull_n, parts.pulls.torque_n_m
    # the strand leaves from a polygon's corner: its speed is Ω R cos α
    corner = 2.0 * math.pi / 16
    alpha = np.mod(grid.angle_rad + 0.5 * corner, corner) - 0.5 * corner
    speed = pulled.analysis.speed_rad_s
    power = np.abs(pull) * speed * 0.040 * np.cos(alpha)
    assert near(power, torque * speed, rel=1e-9)
    assert near(torque, np.full(torque.shape, pulled.report["torque"]["mean_N_m"]), rel=1e-9)
    side = -1.0 if turns == "cw" else 1.0
    assert near(np.angle(pull), np.full(pull.shape, side * math.radians(30.0)), within=1e-12)
    # mains take it by levers, all of it
    low, high = main_z("single")
    change = pulled.analysis.loads.main_n - plain.analysis.loads.main_n
    added = change[..., 0] + 1j * change[..., 1]
    assert near(added[0], pull * (high + 70.0) / (high - low), rel=1e-9, within=1e-8)
    assert near(added.sum(axis=0), pull, rel=1e-9, within=1e-8)
    told = pulled.report["drives"]
    assert told["friction_without_N_m"] == pytest.approx(plain.analysis.friction_mean_n_m, rel=1e-9)
    assert told["friction_mean_N_m"] > told["friction_without_N_m"]
    for main, bare in zip(told["main_journals"], plain.report["loads"]["main_journals"], strict=True):
        assert main["greatest_without_N"] == pytest.approx(bare["greatest_N"], rel=1e-9)
    (row,) = told["drives"]
    # the polygon by its series: the mean of 1/cos α, and its first harmonic
    half, points = math.pi / 16, np.linspace(-1.0, 1.0, 200001)
    sec = 1.0 / np.cos(half * points)
    mean_pull = row["mean_torque_N_m"] / 0.040
    assert row["mean_pull_N"] == pytest.approx(mean_pull * np.trapezoid(sec, points) / 2.0, rel=3e-6)
    tooth = abs(np.trapezoid(sec * np.exp(-1j * math.pi * points), points))
    assert row["tooth_pull_N"] == pytest.approx(mean_pull * tooth, rel=1e-3)
    assert row["tooth_order"] == 16.0
    assert "Pull on the mains" in pulled.text()


def test_limits_of_a_chain_are_a_belt_of_many_teeth_and_no_slack() -> None:
    """Teeth → ∞ and slack → 0: M/R, constant."""
    many, smooth, slack = (
        ab.cycle(job_of("single", drive=[each]), crank=crank("single")).report["drives"]["drives"][0]
        for each in (chain(teeth=4000), chain(kind="belt", teeth=None), chain(kind="belt", slack_share=0.25))
    )
    assert many["mean_pull_N"] == pytest.approx(smooth["mean_pull_N"], rel=1e-6)
    assert many["tooth_pull_N"] < 1e-5 * many["mean_pull_N"]
    assert smooth["mean_pull_N"] == pytest.approx(smooth["mean_torque_N_m"] / 0.040, rel=1e-9)
    assert smooth["greatest_pull_N"] == pytest.approx(smooth["least_pull_N"], rel=1e-9)
    pulled = slack["mean_torque_N_m"] / 0.040 * 1.25 / 0.75
    assert slack["mean_pull_N"] == pytest.approx(pulled, rel=1e-9)


def test_gears_press_against_the_rotation_and_apart() -> None:
    gear = chain(kind="gear", teeth=30, tooth_share=0.1, pressure_angle_deg=20.0, direction_deg=0.0)
    result = ab.cycle(job_of("single", drive=[gear]), crank=crank("single"))
    pulls, torque = result.analysis.firing.parts.pulls, result.report["torque"]["mean_N_m"]
    assert pulls is not None
    (pull,) = pulls.pull_n
    # mate on x, crank counter-clockwise: its mesh moves along +y, so the mate holds it along −y, and off it
    wave = 1.0 + 0.1 * np.cos(30.0 * result.analysis.grid.angle_rad)
    assert near(pull.imag, -torque / 0.040 * wave, rel=1e-9)
    assert near(pull.real, pull.imag * math.tan(math.radians(20.0)), rel=1e-9)


def test_inertia_behind_a_chain_makes_its_pull_pulsate() -> None:
    """M = T̄ + J θ̈: its work over the cycle is the engine's; its sum the change of kinetic energy."""
    inertia = 9e4
    job = job_of("single", drive=[chain(driven_inertia_kg_mm2=inertia, teeth=None)], flywheel_kg_mm2=3e4)
    result = ab.cycle(job, crank=crank("single"))
    analysis = result.analysis
    grid, pulls = analysis.grid, analysis.firing.parts.pulls
    uneven, mean = analysis.uneven_speed, result.report["torque"]["mean_N_m"]
    assert pulls is not None
    assert uneven is not None
    assert float(grid.mean(pulls.torque_n_m[0])) == pytest.approx(mean, rel=1e-7)
    speed = uneven.speed_rad_s
    kinetic = 0.5 * inertia * 1e-6 * (speed**2 - speed[0] ** 2)
    work = grid.work_to_even(pulls.torque_n_m[0] - float(grid.mean(pulls.torque_n_m[0])))[:-1]
    assert near(work, kinetic, within=2e-6 * np.abs(kinetic).max())
    # as heavy as that, the flywheel alone has the same speed
    alone = ab.cycle(job_of("single", flywheel_kg_mm2=3e4 + inertia), crank=crank("single"))
    assert alone.analysis.uneven_speed is not None
    assert near(alone.analysis.uneven_speed.speed_rad_s, speed, rel=1e-12)
    (warned,) = [text for text in result.report["warnings"] if "driven backwards" in text]
    assert "chain 1" in warned


def test_a_crank_that_bends_is_pulled_too() -> None:
    job = job_of("single", drive=[chain()])
    job["bearings"] = {"k_N_mm": 1e6}
    assert ab.cycle(job, crank=crank("single"), flexible=True).report["flexible"]["rigid_difference"] < 1e-6


def test_drives_share_the_torque_or_are_refused() -> None:
    from autobalance.errors import JobError

    two = [chain(torque_share=0.7), chain(z_mm=70.0, torque_N_m=2.0, name="cams")]
    rows = ab.cycle(job_of("single", drive=two), crank=crank("single")).report["drives"]["drives"]
    assert rows[1]["mean_torque_N_m"] == pytest.approx(2.0)
    assert rows[1]["name"] == "cams"
    for bad, text in (
        ([chain(), chain()], "torque_share of all drives is 2"),
        ([chain(teeth=2)], r"drive\[1\].teeth is 2"),
        ([chain(tooth_share=0.1)], "polygon"),
        ([chain(kind="gear", teeth=None, tooth_share=0.1)], "needs teeth"),
    ):
        with pytest.raises(JobError, match=text):
            ab.cycle(job_of("single", drive=bad), crank=crank("single"))


def test_orders_names_the_teeth_of_a_drive(tmp_path: Any) -> None:
    time = np.arange(8000) / 4000.0
    record = tmp_path / "record.csv"
    rows = np.stack([time, 0.5 * np.cos(2.0 * np.pi * 160.0 * time)], axis=1)
    np.savetxt(record, rows, delimiter=",", header="time_s,accel_g", comments="")
    job = job_of("single", drive=[chain(name="final drive")])
    job["balance"]["speed_rpm"] = 600
    job["engine"]["layout"] = {"bank_deg": 20.0}
    ab.generate("single", file=tmp_path / "crank.stl", segments=24).write(tmp_path)
    job["crankshaft"] = {"file": "crank.stl", "unit": "mm", "density_kg_m3": 7850.0}
    job["cycle"].pop("friction")
    (tmp_path / "job.toml").write_text(toml_text(job), encoding="utf-8")
    found = ab.orders(record, speed_rpm=600.0, job=tmp_path / "job.toml", max_order=20.0).report
    (row,) = [each for each in found["orders"] if each["order"] == 16.0]
    assert any("chain drive 'final drive': its teeth come in" in text for text in row["sources"])


def test_a_chain_shakes_the_mounts_unless_its_shaft_is_inside() -> None:
    """Far above its mounts the block moves as a free body: force of the tooth order over its mass."""
    mounts = {
        "mass_kg": 80.0,
        "centre_mm": [0.0, 0.0, 0.0],
        "inertia_kg_mm2": [[4e6, 0, 0], [0, 4e6, 0], [0, 0, 4e6]],
        "speed_rpm": [2990.0, 3000.0],
        "points": 2,
        "mount": [{"at_mm": [0.0, 0.0, z], "k_N_mm": [1.0, 1.0, 1.0]} for z in (-90.0, 90.0)],
    }

    def shaken(**cycle: Any) -> float:
        job = {**job_of("single", **cycle), "mounts": mounts}
        job["cycle"].pop("friction")
        places = ab.forces(job, crank("single"), mounts=True, factors=[0.5]).report["mounts"]["responses"]
        return float(places[0]["places"][0]["velocity_rms_mm_s"][1])

    drive = chain(z_mm=0.0, teeth=5)
    bare, inside = shaken(), shaken(drive=[{**drive, "inside": True}])
    assert inside == bare
    one = job_of("single", drive=[drive])
    one["cycle"].pop("friction")
    (row,) = ab.cycle(one, crank=crank("single")).report["drives"]["drives"]
    assert row["tooth_order"] == 5.0
    # the engine's own motion of order 5 by the same body, and the chain's beside it: which phase is not told
    tooth = row["tooth_pull_N"] / 80.0 / (5.0 * 100.0 * math.pi) * 1e3
    assert bare**2 < shaken(drive=[drive]) ** 2
    both = math.sqrt(2.0 * (shaken(drive=[drive]) ** 2 - bare**2))
    assert both == pytest.approx(tooth, rel=0.2)
