"""Loads and torque with gas: equilibrium, energy, orders, levers, and a multibody model that runs free."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from autobalance.engines.cycle.analysis import CycleAnalysis
from autobalance.engines.cycle.closed_part import Chamber, Charge, Wiebe
from autobalance.engines.cycle.cylinder import CylinderCycle, GasExchange, Strokes
from autobalance.engines.cycle.factors import factor_rows, ideal_counterweights
from autobalance.engines.cycle.firing import dead_centres_rad, firing_in_order
from autobalance.engines.cycle.firing_engine import FiringEngine, LoadParts, ThrowPlace
from autobalance.engines.cycle.model import Friction
from autobalance.engines.cycle.speed import periodic_speed
from autobalance.running_gear.conrod import ConnectingRod
from autobalance.running_gear.loads import lever_shares, loads
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import CrankUnbalance, Cylinder, Engine
from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2, N_PER_G_MM_S2

BAR = 0.1


def burning(
    crank: SliderCrank,
    strokes: Strokes,
    bore_mm: float = 80.0,
    heat_j: float = 700.0,
    opens_deg: float = 135.0,
) -> CylinderCycle:
    return CylinderCycle.modelled(
        Chamber(crank, bore_mm, 10.5),
        GasExchange(strokes, BAR, 1.2 * BAR, BAR, math.radians(-140.0), math.radians(135.0)),
        Charge(BAR, 330.0, 1.35),
        Wiebe(math.radians(-14.0), math.radians(48.0), 5.0, 3.0, heat_j * 1e3),
        None,
    )


def any_engine(seed: int) -> FiringEngine:
    """Throws at any angle, one or two rods each at any bank, some overhung, all parts unlike each other."""
    draw = np.random.default_rng(seed)
    strokes: Strokes = 4 if seed % 2 else 2
    mains = np.cumsum(draw.uniform(60.0, 90.0, draw.integers(2, 5)))
    places = np.sort(draw.uniform(mains[0] - 40.0, mains[-1] + 40.0, draw.integers(1, 5)))
    cylinders: list[Cylinder] = []
    throws: list[ThrowPlace] = []
    pieces: list[CrankUnbalance] = []
    for z in places:
        angle, radius = float(draw.uniform(-3.0, 3.0)), float(draw.uniform(25.0, 45.0))
        first = len(cylinders)
        for rod in range(int(draw.integers(1, 3))):
            crank = SliderCrank(radius, radius * draw.uniform(3.0, 4.5), draw.uniform(-8.0, 8.0))
            masses = draw.uniform(200.0, 500.0, 2)
            cylinders.append(
                Cylinder(
                    crank,
                    float(masses[0]),
                    float(masses[1]),
                    throw_angle_rad=angle,
                    bank_rad=float(draw.uniform(-2.0, 2.0)),
                    z_mm=float(z) + 10.0 * rod,
                    small_end_g=0.3 * float(masses[1]),
                    couple_inertia_g_mm2=float(draw.uniform(-1e5, 4e5)),
                )
            )
        throws.append(ThrowPlace(angle, float(z), tuple(range(first, len(cylinders)))))
        pieces.append(CrankUnbalance(draw.uniform(-9e3, 9e3, 2), float(z) + 3.0))
    cycles = tuple(
        burning(each.slider_crank, strokes, draw.uniform(60.0, 90.0), draw.uniform(200.0, 900.0))
        for each in cylinders
    )
    firing = [top + 2.0 * math.pi * draw.integers(0, strokes // 2) for top in dead_centres_rad(cylinders)]
    engine = Engine(tuple(cylinders), tuple(pieces), 5e6)
    friction = Friction(0.02, (0.4, 0.005, 0.05, 0.001))
    diameters = tuple(draw.uniform(40.0, 60.0, mains.size))
    return FiringEngine(engine, tuple(throws), tuple(mains), diameters, cycles, tuple(firing), 2e6, friction)


@pytest.mark.parametrize("seed", range(8))
def test_mains_walls_and_heads_carry_the_change_of_momentum(seed: int) -> None:
    firing, speed = any_engine(seed), 540.0
    angle = firing.grid.angle_rad
    found = firing.parts.at_speed(speed)
    total = found.main_n.sum(axis=0)
    for cylinder, wall, gas in zip(
        firing.engine.cylinders, found.wall_n, firing.parts.gas_state.force_n, strict=True
    ):
        along = cylinder.direction
        across = np.array([-along[1], along[0]])
        total = total + wall[:, None] * across + gas[:, None] * along
    size = np.abs(found.main_n).max()
    np.testing.assert_allclose(total, firing.engine.force_n(angle, speed), rtol=0.0, atol=1e-9 * size)


@pytest.mark.parametrize("seed", range(8))
def test_torque_is_the_moment_of_the_crankpin_loads_and_energy_closes(seed: int) -> None:
    firing, speed = any_engine(seed), 540.0
    angle = firing.grid.angle_rad
    found = firing.parts.at_speed(speed)
    moment = np.zeros(angle.size)
    for cylinder, load in zip(firing.engine.cylinders, found.crankpin_n, strict=True):
        radius, turned = cylinder.slider_crank.crank_radius_mm, angle + cylinder.throw_angle_rad
        moment += radius * (np.cos(turned) * load[:, 1] - np.sin(turned) * load[:, 0]) * 1e-3
    given = found.gas_torque_n_m - found.torque_n_m
    np.testing.assert_allclose(moment, given, rtol=0.0, atol=1e-9 * np.abs(given).max())
    assert firing.energy_error is not None
    assert firing.energy_error < 1e-8
    analysis = CycleAnalysis(firing, speed)
    mean = firing.work_n_mm * 1e-3 / (math.pi * firing.strokes)
    assert firing.gas_mean_n_m == pytest.approx(mean, rel=1e-8)
    assert firing.grid.mean(analysis.gas_n_m) == pytest.approx(mean, rel=1e-8)
    assert analysis.inertia_mean_n_m == pytest.approx(0.0, abs=1e-9 * np.abs(analysis.inertia_n_m).max())
    assert analysis.mean_n_m == pytest.approx(
        firing.gas_mean_n_m - analysis.friction_mean_n_m, rel=1e-9, abs=1e-9
    )


def test_gas_makes_half_orders_and_inertia_does_not() -> None:
    four = CycleAnalysis(any_engine(1), 400.0)
    assert [each.order for each in four.orders] == [0.5 * k for k in range(1, 25)]
    assert all(each.inertia_n_m < 1e-9 for each in four.orders if each.order % 1.0)
    assert four.orders[0].gas_n_m > 1.0
    two = CycleAnalysis(any_engine(2), 400.0)
    assert [each.order for each in two.orders] == list(range(1, 13))
    # The orders are the torque's own Fourier series: what they leave out is above them.
    summed = np.full(two.grid.even_rad.size, float(two.grid.mean(two.total_n_m)))
    for each in two.orders:
        summed += each.total_n_m * np.cos(each.order * two.grid.even_rad + each.phase_rad)
    left = np.fft.rfft(two.grid.even(two.total_n_m) - summed)[:13] / summed.size
    assert np.abs(left).max() < 1e-2 * two.orders[0].total_n_m


def test_a_factor_row_is_an_engine_with_that_crank() -> None:
    firing, speed = any_engine(5), 700.0
    for row in factor_rows(firing, (0.0, 0.5, 1.0), speed):
        ideal = Engine(firing.engine.cylinders, ideal_counterweights(firing, row.factor))
        gas = firing.gas(firing.grid.angle_rad).force_n
        main = loads(ideal, firing.mains_z_mm, speed, firing.grid.angle_rad, gas_n=gas).main_n
        size = np.hypot(main[..., 0], main[..., 1])
        assert row.greatest_mains_n == pytest.approx(size.max(axis=1), rel=1e-12)
        assert row.mean_main_n == pytest.approx(firing.grid.mean(size).mean(), rel=1e-12)
        lever = 0.5 * np.array(firing.main_diameters_mm) * 0.02 / math.hypot(1.0, 0.02) * 1e-3
        own = firing.piston_friction_n_m(speed)
        assert row.friction_mean_n_m == pytest.approx(lever @ firing.grid.mean(size) + own, rel=1e-12)


def test_an_overhung_throw_lifts_the_far_main() -> None:
    crank = SliderCrank(30.0, 110.0)
    cylinder = Cylinder(crank, 200.0, 300.0, z_mm=100.0)
    throws = (ThrowPlace(0.0, 100.0, (0,)),)
    firing = FiringEngine(
        Engine((cylinder,)), throws, (0.0, 40.0), (30.0, 30.0), (burning(crank, 4),), (0.0,)
    )
    found = firing.parts.at_speed(300.0)
    np.testing.assert_allclose(found.main_n[0], -1.5 * found.crankpin_n[0], rtol=1e-12)
    np.testing.assert_allclose(found.main_n[1], 2.5 * found.crankpin_n[0], rtol=1e-12)
    assert lever_shares(100.0, [0.0, 40.0]).tolist() == [-1.5, 2.5]


def test_gas_pushes_as_the_definitions_say() -> None:
    """At 90° after top dead centre the piston leans on the wall that the rod points away from."""
    crank = SliderCrank(30.0, 110.0)
    gas = np.array([[1000.0]])
    engine = Engine((Cylinder(crank, 0.0, 0.0),))
    found = loads(engine, [-10.0, 10.0], 0.0, np.array([0.5 * math.pi]), gas_n=gas)
    lean = 30.0 / math.sqrt(110.0**2 - 30.0**2)
    assert found.wrist_pin_n[0, 0] == pytest.approx([-1000.0, 1000.0 * lean])
    assert found.wall_n[0, 0] == pytest.approx(-1000.0 * lean)
    assert found.crankpin_n[0, 0] == pytest.approx([-1000.0, 1000.0 * lean])
    assert found.gas_torque_n_m[0] == pytest.approx(1000.0 * 0.030)


def test_pulses_of_a_four_cylinder_come_twice_a_turn() -> None:
    crank = SliderCrank(40.0, 140.0)
    cylinders = tuple(
        Cylinder(crank, 300.0, 400.0, throw_angle_rad=angle, z_mm=90.0 * number)
        for number, angle in enumerate([0.0, math.pi, math.pi, 0.0])
    )
    order = firing_in_order(dead_centres_rad(cylinders), [1, 3, 4, 2], 4.0 * math.pi)
    throws = tuple(ThrowPlace(each.throw_angle_rad, each.z_mm, (n,)) for n, each in enumerate(cylinders))
    mains = tuple(90.0 * number - 45.0 for number in range(5))
    one = burning(crank, 4)
    firing = FiringEngine(Engine(cylinders), throws, mains, (50.0,) * 5, (one,) * 4, tuple(order))
    for each in CycleAnalysis(firing, 500.0).orders:
        if each.order % 2.0:
            assert each.gas_n_m < 1e-9
        elif each.order < 9.0:
            assert each.gas_n_m > 0.1


# --- a multibody model --------------------------------------------------------------------------------------

ROD = ConnectingRod(420.0, 140.0, 40.0, inertia_g_mm2=1.3e6)
RADIUS, OFFSET, PISTON_G = 43.0, 6.0, 380.0
CRANK_G, CRANK_CENTRE, CRANK_INERTIA = 3000.0, -9.0, 4.0e6


def single() -> FiringEngine:
    crank = SliderCrank(RADIUS, ROD.length_mm, OFFSET)
    cylinder = Cylinder(
        crank,
        ROD.big_end_g,
        ROD.small_end_g + PISTON_G,
        small_end_g=ROD.small_end_g,
        couple_inertia_g_mm2=ROD.couple_inertia_g_mm2,
    )
    piece = CrankUnbalance(np.array([CRANK_G * CRANK_CENTRE, 0.0]), 0.0)
    engine = Engine((cylinder,), (piece,), CRANK_INERTIA + CRANK_G * CRANK_CENTRE**2)
    throws = (ThrowPlace(0.0, 0.0, (0,)),)
    cycle = burning(crank, 4, heat_j=500.0)
    return FiringEngine(engine, throws, (-50.0, 50.0), (40.0, 40.0), (cycle,), (crank.dead_centres_rad[0],))


MASSES = np.array(
    [CRANK_G, CRANK_G, CRANK_INERTIA, ROD.mass_g, ROD.mass_g, 1.3e6, PISTON_G, PISTON_G, 1e4],
    dtype=np.float64,
)
CENTRE, REST = ROD.centre_from_big_end_mm, ROD.length_mm - ROD.centre_from_big_end_mm


def assembled(angle: float) -> Array:
    """Centres and turns (9,) of crank, rod and piston at a crank angle."""
    pin = RADIUS * np.array([math.cos(angle), math.sin(angle)])
    tilt = math.asin((OFFSET - pin[1]) / ROD.length_mm)
    along = np.array([math.cos(tilt), math.sin(tilt)])
    crank = CRANK_CENTRE * np.array([math.cos(angle), math.sin(angle)])
    return np.array([*crank, angle, *(pin + CENTRE * along), tilt, *(pin + ROD.length_mm * along), 0.0])


def joints(q: Array, v: Array) -> tuple[Array, Array]:
    """Jacobian (8, 9) of main bearing, crankpin, wrist pin and cylinder; and −J̇ v (8,)."""
    c, s, co, si = math.cos(q[2]), math.sin(q[2]), math.cos(q[5]), math.sin(q[5])
    matrix, change = np.zeros((8, 9)), np.zeros(8)
    for row, (crank, rod, crank_2, rod_2) in enumerate(((-s, -si, -c, -co), (c, co, -s, -si))):
        matrix[row, row], matrix[row, 2] = 1.0, -CRANK_CENTRE * crank
        matrix[2 + row, 3 + row], matrix[2 + row, 5] = 1.0, -CENTRE * rod
        matrix[2 + row, row], matrix[2 + row, 2] = -1.0, (CRANK_CENTRE - RADIUS) * crank
        matrix[4 + row, 6 + row], matrix[4 + row, 3 + row], matrix[4 + row, 5] = 1.0, -1.0, -REST * rod
        change[row] = CRANK_CENTRE * crank_2 * v[2] ** 2
        change[2 + row] = CENTRE * rod_2 * v[5] ** 2 - (CRANK_CENTRE - RADIUS) * crank_2 * v[2] ** 2
        change[4 + row] = REST * rod_2 * v[5] ** 2
    matrix[6, 7] = matrix[7, 8] = 1.0
    return matrix, change


def moved(q: Array, v: Array, gas_n: float, load_n_m: float) -> tuple[Array, Array]:
    """Accelerations (9,) and joint forces (8,) [g·mm/s²] under gas on the piston and a load on the shaft."""
    matrix, change = joints(q, v)
    applied = np.zeros(9)
    applied[6], applied[2] = -gas_n / N_PER_G_MM_S2, -load_n_m / N_M_PER_G_MM2_S2
    whole = np.block([[np.diag(MASSES), matrix.T], [matrix, np.zeros((8, 8))]])
    scale = np.concatenate([np.sqrt(MASSES), np.full(8, 1.0 / math.sqrt(1000.0))])
    solved = (
        np.linalg.solve(whole / np.outer(scale, scale), np.concatenate([applied, change]) / scale) / scale
    )
    return solved[:9], solved[9:]


def started(speed: float, angle: float) -> Array:
    q = assembled(angle)
    matrix, _ = joints(q, np.zeros(9))
    rest = np.delete(np.arange(9), 2)
    v = np.zeros(9)
    v[2] = speed
    v[rest] = np.linalg.solve(matrix[:, rest], -matrix[:, 2] * speed)
    return np.concatenate([q, v])


def test_a_free_running_multibody_model_meets_torque_speed_and_every_load() -> None:
    """From bottom to bottom dead centre through the burn, with no code of the engine but the gas pressure."""
    firing, load = single(), 12.0
    cycle, top = firing.cycles[0], firing.firing_rad[0]
    low, high = top - 2.4, top + 2.3

    def gas_n(angle: float) -> float:
        return float(firing.gas(np.array([angle])).force_n[0, 0])

    def slope(_: float, state: Array) -> Array:
        forces = moved(state[:9], state[9:], gas_n(float(state[2])), load)[0]
        return np.concatenate([state[9:], forces])

    def arrived(_: float, state: Array) -> float:
        return float(state[2]) - high

    arrived.terminal = True  # type: ignore[attr-defined]
    first = started(420.0, low)
    run = solve_ivp(slope, (0.0, 0.1), first, method="DOP853", rtol=1e-12, atol=1e-12, events=arrived)
    assert run.status == 1
    assert cycle.known_rad[0] + top < low
    # Speed: ½ J θ̇² grows by the work of gas less load.
    angles = run.y[2]
    inertia = firing.inertia_g_mm2(angles) * N_M_PER_G_MM2_S2

    def net_mpa(after_firing: Array) -> Array:
        return cycle.pressure_mpa(after_firing) - BAR

    work = [cycle.integral(low - top, float(angle) - top, net_mpa) * 1e-3 for angle in angles]
    energy = 0.5 * inertia[0] * 420.0**2 + np.array(work) - load * (angles - low)
    np.testing.assert_allclose(run.y[11], np.sqrt(2.0 * energy / inertia), rtol=1e-8)
    assert np.ptp(run.y[11]) > 20.0
    # Loads: the Lagrange multipliers of the joints.
    for state in run.y.T[::7]:
        angle, speed = float(state[2]), float(state[11])
        acceleration, joint = moved(started(speed, angle)[:9], started(speed, angle)[9:], gas_n(angle), load)
        found = loads(
            firing.engine,
            firing.mains_z_mm,
            speed,
            np.array([angle]),
            float(acceleration[2]),
            firing.gas(np.array([angle])).force_n,
        )
        joint = joint * N_PER_G_MM_S2
        close = 1e-8 * float(np.abs(joint).max())
        np.testing.assert_allclose(found.main_n.sum(axis=0)[0], joint[0:2], rtol=0.0, atol=close)
        np.testing.assert_allclose(found.crankpin_n[0, 0], joint[2:4], rtol=0.0, atol=close)
        np.testing.assert_allclose(found.wrist_pin_n[0, 0], joint[4:6], rtol=0.0, atol=close)
        np.testing.assert_allclose(found.wall_n[0, 0], joint[6], rtol=0.0, atol=close)
        shaft = found.torque_n_m[0] - found.gas_torque_n_m[0]
        assert shaft == pytest.approx(-load, abs=1e-8 * abs(found.gas_torque_n_m[0]) + 1e-8)
        assert acceleration[2] == pytest.approx(state_acceleration(firing, angle, speed, load), rel=1e-8)


def state_acceleration(firing: FiringEngine, angle: float, speed: float, load_n_m: float) -> float:
    """θ̈ = (T − ½ J′ θ̇²)/J."""
    at = np.array([angle])
    parts = LoadParts.of(firing, at).at_speed(speed)
    torque = float(parts.gas_torque_n_m[0] - parts.torque_n_m[0]) - load_n_m
    return torque / (float(firing.inertia_g_mm2(at)[0]) * N_M_PER_G_MM2_S2)


def test_the_periodic_speed_is_where_an_integration_over_time_settles() -> None:
    firing, wanted = single(), 200.0
    analysis = CycleAnalysis(firing, wanted)
    uneven = analysis.uneven_speed
    assert uneven is not None
    assert uneven.mean_rad_s == pytest.approx(wanted, rel=1e-12)
    load = float(firing.grid.mean(analysis.gas_n_m))

    def slope(angle: float, speed: Array) -> Array:
        return np.array([state_acceleration(firing, angle, float(speed[0]), load) / float(speed[0])])

    at = firing.grid.even_rad[:400:40]
    run = solve_ivp(
        slope, (0.0, float(at[-1])), [uneven.speed_rad_s[0]], t_eval=at, rtol=1e-8, atol=1e-8, max_step=0.1
    )
    np.testing.assert_allclose(run.y[0], uneven.speed_rad_s[:400:40], rtol=2e-6)


def test_the_flywheel_needed_gives_the_fluctuation_wanted() -> None:
    analysis = CycleAnalysis(single(), 200.0)
    needed = analysis.flywheel_needed_g_mm2(0.03)
    assert needed is not None
    firing = single()
    heavier = FiringEngine(
        firing.engine,
        firing.throws,
        firing.mains_z_mm,
        firing.main_diameters_mm,
        firing.cycles,
        firing.firing_rad,
        needed,
    )
    uneven = CycleAnalysis(heavier, 200.0).uneven_speed
    assert uneven is not None
    assert uneven.fluctuation == pytest.approx(0.03, rel=1e-9)
    assert CycleAnalysis(heavier, 200.0).flywheel_needed_g_mm2(0.03) == pytest.approx(needed, rel=1e-9)
    assert CycleAnalysis(heavier, 200.0).flywheel_needed_g_mm2(5.0) == 0.0


def test_a_crank_without_inertia_would_stop() -> None:
    angle = np.linspace(0.0, 4.0 * math.pi, 720, endpoint=False)
    assert periodic_speed(angle, 50.0 * np.cos(2.0 * angle), np.full(720, 1e-9), 10.0) is None


def test_a_twelve_is_quick_and_so_are_many_speeds_and_factors() -> None:
    from benchmarks.cycle import loads_of_a_cycle, seconds, speeds_and_factors

    assert loads_of_a_cycle().main_n.shape == (7, 7200, 2)
    assert min(seconds(loads_of_a_cycle, 5)) < 0.1  # the least of a few: others may be using the machine
    assert min(seconds(speeds_and_factors, 2)) < 1.0
