"""Friction of pistons by their side force, against Newton and Euler with Coulomb's law by bisection."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

import autobalance as ab
from autobalance.engines.cycle.block_roll import roll_curves
from autobalance.engines.cycle.factors import FactorMainLoads, key_figures, with_inertia, with_reciprocating
from autobalance.engines.cycle.piston_friction import PistonFriction
from autobalance.errors import JobError
from autobalance.running_gear.loads import loads
from tests.near import near
from tests.reference.test_cycle_doubts import preset
from tests.reference.test_cycle_doubts import radial as radial_job
from tests.reference.test_weight_and_drive import chain, job_of

Array = NDArray[np.float64]


def cycle(piston: dict[str, Any] | None, **keys: Any) -> Any:
    own = {} if piston is None else {"piston": piston}
    return ab.cycle(job_of("single", **own, **keys), crank=preset("single"))


def test_wall_and_friction_balance_on_each_piston() -> None:
    """Hoem & Røsholm 2016, Secs 2.3 and 3.1.1: side force by the rod, friction against the motion."""
    piston = {"skirt_mu": 0.08, "ring_mu": 0.06, "ring_tension_N": 30.0, "ring_height_mm": 2.0}
    result = cycle(piston)
    analysis = result.analysis
    parts, grid, speed = analysis.firing.parts, analysis.grid, analysis.speed_rad_s
    (one,), now = analysis.firing.engine.cylinders, parts.pistons.at(speed)
    crank = one.slider_crank
    gas, bore = parts.gas_state.force_n[0], 80.0
    for place in range(0, grid.angle_rad.size, 97):
        at = float(grid.angle_rad[place]) + one.throw_angle_rad - one.bank_rad
        tilt = math.asin((crank.offset_mm - crank.crank_radius_mm * math.sin(at)) / crank.rod_length_mm)
        motion = crank.motion(np.array([at]))
        way = math.copysign(1.0, float(motion.dx_mm[0]))
        along = one.reciprocating_g * float(motion.ddx_mm[0]) * speed**2 * 1e-6 + float(gas[place])
        above = max(0.0, float(gas[place]) / (math.pi / 4.0 * bore**2))
        rings = 0.06 * (30.0 + math.pi * bore * 2.0 * above)

        def miss(wall: float) -> float:
            """Side force that the rod leaves less the one that friction was taken for."""
            return float(-math.tan(tilt) * (along + way * (0.08 * abs(wall) + rings)) - wall)  # noqa: B023

        wall = brentq(miss, -1e6, 1e6, xtol=1e-12, rtol=1e-14)
        assert float(now.wall_n[0, place]) == pytest.approx(-wall, rel=1e-9, abs=1e-7)
        assert float(now.skirt_n[0, place]) == pytest.approx(0.08 * abs(wall), rel=1e-9, abs=1e-7)
        assert float(now.rings_n[0, place]) == pytest.approx(rings, rel=1e-9)
    assert near(analysis.loads.wall_n, now.wall_n, rel=1e-9, within=1e-7)


def test_friction_takes_the_work_that_the_crankpin_lacks() -> None:
    """Torque of the crankpin's load about the axis: gas and inertia less friction, to 1e-9 at every angle."""
    rough = cycle({"skirt_mu": 0.1, "ring_mu": 0.05, "ring_tension_N": 50.0, "viscous_N_s_m": 3.0})
    smooth = cycle(None)
    analysis = rough.analysis
    angle = analysis.grid.angle_rad + analysis.firing.throws[0].angle_rad
    pins = analysis.crankpins_n[0] - smooth.analysis.crankpins_n[0]
    lever = analysis.firing.engine.cylinders[0].slider_crank.crank_radius_mm * 1e-3
    taken = -lever * (np.cos(angle) * pins[:, 1] - np.sin(angle) * pins[:, 0])
    now = analysis.firing.parts.pistons.at(analysis.speed_rad_s)
    assert near(taken, now.torque_n_m[0], rel=1e-9, within=1e-9 * taken.max())
    told, bare = rough.report["piston_friction"], smooth.report
    mean = float(analysis.grid.mean(now.torque_n_m[0]))
    assert told["mean_N_m"] == pytest.approx(mean, rel=1e-12)
    mains = rough.report["torque"]["friction_mean_N_m"] - mean
    assert mains == pytest.approx(bare["torque"]["friction_mean_N_m"], rel=0.05)
    assert rough.report["torque"]["mean_N_m"] == pytest.approx(
        analysis.firing.gas_mean_n_m - rough.report["torque"]["friction_mean_N_m"], rel=1e-9
    )
    (cylinder,) = told["cylinders"]
    bar = (cylinder["skirt_bar"] + cylinder["rings_bar"]) * 0.1 * bare["cylinder"]["swept_cm3"]
    assert bar / (4.0 * math.pi) == pytest.approx(mean, rel=1e-9)
    assert told["fluctuation"] != told["fluctuation_without"]
    assert "Friction of pistons: mean" in rough.text()


def test_limits_no_friction_no_change_and_stribeck_between_its_ends() -> None:
    bare, nothing = cycle(None), cycle({})
    assert near(nothing.analysis.loads.main_n, bare.analysis.loads.main_n, rel=1e-12, within=1e-9)
    assert nothing.report["torque"]["mean_N_m"] == pytest.approx(bare.report["torque"]["mean_N_m"], rel=1e-9)
    assert nothing.report["piston_friction"]["mean_N_m"] == 0.0
    low, high, between = (
        cycle(keys).report["piston_friction"]["mean_N_m"]
        for keys in (
            {"skirt_mu": 0.03},
            {"skirt_mu": 0.12},
            {"skirt_mu": 0.03, "boundary_mu": 0.12, "stribeck_speed_m_s": 2.0},
        )
    )
    assert low < between < high
    mixed = PistonFriction(0.03, 0.12, 2.0)
    assert mixed.skirt_mu_at(np.array([0.0, 2.0, -40.0])) == pytest.approx(
        [0.12, 0.03 + 0.09 / math.e, 0.03], rel=1e-6
    )


def test_friction_by_the_side_force_adds_to_the_inertia() -> None:
    """Guzzomi, Hesterman and Stone 2008: the torque that friction takes by 1 rad/s², by differences."""
    result = cycle({"skirt_mu": 0.1})
    firing, speed = result.analysis.firing, result.analysis.speed_rad_s
    parts = firing.parts.pistons
    added = parts.equivalent_inertia_g_mm2(firing.grid.angle_rad, speed)
    swung = loads(replace(firing.engine, crank=()), firing.mains_z_mm, 0.0, firing.grid.angle_rad, 1.0).wall_n
    step = 1e-3
    ahead, back = (
        replace(
            parts, walls=replace(parts.walls, steady_n=parts.walls.steady_n + sign * step * swung), known={}
        )
        .at(speed)
        .torque_n_m.sum(axis=0)
        for sign in (1.0, -1.0)
    )
    slope = (ahead - back) / (2.0 * step) * 1e9
    kept = np.abs(result.analysis.loads.wall_n[0]) > 1.0
    assert near(added[kept], slope[kept], rel=1e-4, within=1e-4 * np.abs(added).max())
    told = result.report["piston_friction"]
    mean = told["equivalent_inertia_mean_kg_mm2"] - told["inertia_mean_kg_mm2"]
    assert mean * 1e3 == pytest.approx(float(firing.grid.mean(added)), rel=1e-6)


def test_a_pin_beside_the_piston_tilts_it() -> None:
    """Both ends of the skirt press where the tilt is more than the side force."""
    flat, tilted = (
        cycle({"skirt_mu": 0.1, "pin_offset_mm": offset, "skirt_length_mm": 40.0}) for offset in (0.0, 3.0)
    )
    parts = tilted.analysis.firing.parts.pistons
    now = parts.at(tilted.analysis.speed_rad_s)
    ends = np.stack(
        [0.5 * now.wall_n + now.tilt_n_m * 1e3 / 40.0, 0.5 * now.wall_n - now.tilt_n_m * 1e3 / 40.0]
    )
    assert near(now.skirt_n, 0.1 * np.abs(ends).sum(axis=0), rel=1e-9, within=1e-7)
    assert tilted.report["piston_friction"]["mean_N_m"] > flat.report["piston_friction"]["mean_N_m"]
    (row,) = tilted.report["piston_friction"]["cylinders"]
    assert row["greatest_tilt_N_m"] == pytest.approx(float(np.abs(now.tilt_n_m).max()), rel=1e-12)


@pytest.mark.parametrize("turns", ["ccw", "cw"])
def test_a_pin_beside_the_piston_moves_the_roll_couple(turns: str) -> None:
    """Ruckle 2014, Sec. 3.1.2 has both offsets in one: walls, heads and pistons by their own levers."""
    side = -1.0 if turns == "cw" else 1.0
    offset, mass = 4.0 * side, 400.0
    job = job_of("single", piston={"skirt_mu": 0.1, "pin_offset_mm": offset})
    job["engine"]["turns"] = turns
    analysis = ab.cycle(job, crank=preset("single")).analysis
    assert analysis.firing.parts.pistons is not None
    now = analysis.firing.parts.pistons.at(analysis.speed_rad_s)
    (one,) = analysis.firing.engine.cylinders
    motion = one.slider_crank.motion(analysis.grid.angle_rad + one.throw_angle_rad - one.bank_rad)
    pushed = analysis.firing.parts.gas_state.force_n[0] + now.along_n[0]
    inertia = mass * motion.ddx_mm * analysis.speed_rad_s**2 * 1e-6
    block = motion.x_mm * now.wall_n[0] - one.slider_crank.offset_mm * pushed - 4.0 * inertia
    assert near(roll_curves(analysis).whole_n_m * 1e3, block, rel=1e-9, within=1e-6 * block.max())


def test_links_of_a_radial_lean_on_their_master() -> None:
    """Friction of a link's piston moves its master's wall force: work balances for all five together."""
    rough, smooth = (
        ab.cycle(radial_job(gamma=1.35, flywheel_kg_mm2=9e5, **own), crank=preset("single")).analysis
        for own in ({"piston": {"skirt_mu": 0.08, "ring_mu": 0.05, "ring_tension_N": 40.0}}, {})
    )
    pins = rough.crankpins_n[0] - smooth.crankpins_n[0]
    angle = rough.grid.angle_rad + rough.firing.throws[0].angle_rad
    lever = rough.firing.engine.cylinders[0].slider_crank.crank_radius_mm * 1e-3
    taken = -lever * (np.cos(angle) * pins[:, 1] - np.sin(angle) * pins[:, 0])
    assert rough.firing.parts.pistons is not None
    now = rough.firing.parts.pistons.at(rough.speed_rad_s)
    assert near(taken, now.torque_n_m.sum(axis=0), rel=1e-9, within=1e-9 * taken.max())
    assert near(rough.loads.wall_n, now.wall_n, rel=1e-9, within=1e-6)


ROUGH = {"skirt_mu": 0.08, "ring_mu": 0.05, "ring_tension_N": 40.0, "ring_height_mm": 2.0}
STRIBECK = {**ROUGH, "boundary_mu": 0.12, "stribeck_speed_m_s": 1.0, "viscous_N_s_m": 3.0}
TILTED = {**STRIBECK, "pin_offset_mm": 1.0, "skirt_length_mm": 40.0}


def radial_cycle(piston: dict[str, Any]) -> Any:
    own = {"drive": [chain()], "gravity": {"direction_deg": 170.0}, "piston": piston}
    return ab.cycle(radial_job(flywheel_kg_mm2=9e5, **own), crank=preset("single"))


@pytest.mark.parametrize("piston", [ROUGH, STRIBECK, TILTED], ids=["coulomb", "stribeck", "tilted"])
@pytest.mark.parametrize("engine", ["single", "radial"])
def test_key_figures_by_the_gauss_points_are_those_of_all_angles(engine: str, piston: dict[str, Any]) -> None:
    """Means from half of the angles, forces by one pass, other masses by shared parts: as each on its own."""
    keys = {"drive": [chain()], "gravity": {"direction_deg": 170.0}}
    result = radial_cycle(piston) if engine == "radial" else cycle(piston, **keys)
    firing, speed = result.analysis.firing, result.analysis.speed_rad_s
    mains = FactorMainLoads.of(firing)
    for factor, at in ((None, 0.3 * speed), (0.5, speed), (1.0, 4.0 * speed)):
        means = firing.grid.mean(mains.sizes_n(factor, at))
        bare = firing.gas_mean_n_m - mains.friction_mean_n_m(means, at)
        assert mains.surplus_n_m(factor, at) == pytest.approx(
            bare, rel=1e-11, abs=1e-11 * firing.gas_mean_n_m
        )
    lighter = with_reciprocating(firing, 0.9)
    shared = lighter.parts_beside(firing)
    first, second = (each.mains_n(speed, each.crank_n) for each in (shared, lighter.parts))
    assert near(first, second, rel=1e-11, within=1e-11 * float(np.abs(first).max()))
    table = result.report["key_figures"]
    alone = key_figures(lighter, speed)[0]
    assert table["reciprocating_mass"][0]["greatest_torque_N_m"] == pytest.approx(
        alone.greatest_torque_n_m, rel=1e-11
    )
    heavier = key_figures(with_inertia(firing, 1.1), speed)[0]
    assert table["inertia"][2]["acceleration_rad_s2"] == pytest.approx(heavier.acceleration_rad_s2, rel=1e-11)


@pytest.mark.parametrize(
    ("piston", "text"),
    [
        ({"skirt_mu": 1.0}, r"cycle\.piston\.skirt_mu is 1; must be below 1"),
        ({"boundary_mu": 0.1}, "boundary_mu is given without stribeck_speed_m_s"),
        ({"stribeck_speed_m_s": 0.1}, "stribeck_speed_m_s is given without boundary_mu"),
    ],
)
def test_impossible_friction_is_refused(piston: dict[str, Any], text: str) -> None:
    with pytest.raises(JobError, match=text):
        cycle(piston)
