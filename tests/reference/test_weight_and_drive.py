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
    assert total == pytest.approx(np.tile(mass * G * 1e-3 * down, (len(total), 1)), rel=1e-9, abs=1e-8)
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
    assert work == pytest.approx(fallen, abs=1e-9 * np.abs(fallen).max() + 1e-12)
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
    assert np.asarray(pins) * 1e-3 == pytest.approx(-found.torque_n_m, rel=1e-9, abs=1e-12)
    mass = sum(each.rotating_g + each.reciprocating_g for each in engine.cylinders)
    total = found.main_n.sum(axis=0)
    for cylinder, wall in zip(engine.cylinders, found.wall_n, strict=True):
        total = total + wall[:, None] * np.array([-math.sin(cylinder.bank_rad), math.cos(cylinder.bank_rad)])
    push = mass * 1e-6 * np.array([fall.real, fall.imag])
    assert total == pytest.approx(np.tile(push, (len(total), 1)), rel=1e-9)


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
    assert heavy.analysis.loads.main_n == pytest.approx(light.analysis.loads.main_n, rel=1e-9, abs=1e-8)
