"""Bearing loads and torque against a multibody model of the same mechanism, momentum and energy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from autobalance.running_gear.conrod import ConnectingRod
from autobalance.running_gear.loads import (
    Loads,
    lever_shares,
    loads,
    support_of,
    variable_inertia_g_mm2,
    whole_turn,
)
from autobalance.running_gear.parts import Parts
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import CrankUnbalance, Cylinder, Engine, vee
from autobalance.types import Array
from autobalance.units import N_M_PER_G_MM2_S2, N_PER_G_MM_S2

ROD = ConnectingRod(420.0, 140.0, 40.0, inertia_g_mm2=1.3e6)
PISTON_G = 380.0
RADIUS_MM, OFFSET_MM = 43.0, 6.0
CRANK_G, CRANK_CENTRE_MM, CRANK_INERTIA = 3000.0, -9.0, 4.0e6  # about its own centre of mass [g·mm²]


def single() -> Engine:
    """One cylinder with an offset and a rigid rod; its crank's centre of mass lies opposite the crankpin."""
    cylinder = Cylinder(
        SliderCrank(RADIUS_MM, ROD.length_mm, OFFSET_MM),
        rotating_g=ROD.big_end_g,
        reciprocating_g=ROD.small_end_g + PISTON_G,
        small_end_g=ROD.small_end_g,
        couple_inertia_g_mm2=ROD.couple_inertia_g_mm2,
    )
    crank = CrankUnbalance(np.array([CRANK_G * CRANK_CENTRE_MM, 0.0]), 0.0)
    return Engine((cylinder,), (crank,), CRANK_INERTIA + CRANK_G * CRANK_CENTRE_MM**2)


@dataclass(frozen=True, eq=False)
class Bodies:
    """Crank, rod and piston as three rigid bodies held together by the forces of their joints.

    Coordinates q = (x, y, turn) of each body's centre of mass; the joints are main bearing, crankpin, wrist
    pin and cylinder (the piston may neither turn nor leave its line). None of the engine's code is used.
    """

    masses = np.repeat([CRANK_G, ROD.mass_g, PISTON_G], 3) * np.array(
        [1.0, 1.0, CRANK_INERTIA / CRANK_G, 1.0, 1.0, 1.3e6 / 420.0, 1.0, 1.0, 1e4]
    )

    @staticmethod
    def assembled(angle: float) -> Array:
        """Coordinates (9,) at a crank angle."""
        pin = RADIUS_MM * np.array([math.cos(angle), math.sin(angle)])
        tilt = math.asin((OFFSET_MM - pin[1]) / ROD.length_mm)
        along = np.array([math.cos(tilt), math.sin(tilt)])
        crank = CRANK_CENTRE_MM * np.array([math.cos(angle), math.sin(angle)])
        wrist = pin + ROD.length_mm * along
        return np.array([*crank, angle, *(pin + ROD.centre_from_big_end_mm * along), tilt, *wrist, 0.0])

    @staticmethod
    def joints(q: Array) -> Array:
        """Gaps (8,) of the joints: zero when assembled."""
        crank = np.array([math.cos(q[2]), math.sin(q[2])])
        rod = np.array([math.cos(q[5]), math.sin(q[5])])
        main = q[0:2] - CRANK_CENTRE_MM * crank
        crankpin = q[3:5] - ROD.centre_from_big_end_mm * rod - (main + RADIUS_MM * crank)
        wrist = q[6:8] - (q[3:5] + (ROD.length_mm - ROD.centre_from_big_end_mm) * rod)
        return np.array([*main, *crankpin, *wrist, q[7] - OFFSET_MM, q[8]])

    @classmethod
    def jacobian(cls, q: Array) -> Array:
        """Derivative (8, 9) of the gaps by the coordinates."""
        matrix = np.zeros((8, 9))
        crank_x, crank_y = -math.sin(q[2]), math.cos(q[2])
        rod_x, rod_y = -math.sin(q[5]), math.cos(q[5])
        rest = ROD.length_mm - ROD.centre_from_big_end_mm
        for row, (crank, rod) in enumerate(((crank_x, rod_x), (crank_y, rod_y))):
            matrix[row, row], matrix[row, 2] = 1.0, -CRANK_CENTRE_MM * crank
            matrix[2 + row, 3 + row], matrix[2 + row, 5] = 1.0, -ROD.centre_from_big_end_mm * rod
            matrix[2 + row, row], matrix[2 + row, 2] = -1.0, (CRANK_CENTRE_MM - RADIUS_MM) * crank
            matrix[4 + row, 6 + row], matrix[4 + row, 3 + row], matrix[4 + row, 5] = 1.0, -1.0, -rest * rod
        matrix[6, 7] = matrix[7, 8] = 1.0
        return matrix

    @classmethod
    def step(cls, q: Array, v: Array, torque: float) -> tuple[Array, Array]:
        """Accelerations (9,) and joint forces (8,) at a state; M a + Jᵀ λ = applied, J a = −J̇ v."""
        matrix = cls.jacobian(q)
        small = 1e-6 / max(1.0, float(np.abs(v).max()))
        change = (cls.jacobian(q + small * v) - cls.jacobian(q - small * v)) / (2.0 * small)
        whole = np.block([[np.diag(cls.masses), matrix.T], [matrix, np.zeros((8, 8))]])
        applied = np.zeros(9)
        applied[2] = torque
        scale = np.sqrt(np.concatenate([cls.masses, 1.0 / np.repeat(1000.0, 8)]))
        solved = np.linalg.solve(
            whole / np.outer(scale, scale), np.concatenate([applied, -change @ v]) / scale
        )
        both = solved / scale
        return both[:9], both[9:]

    @classmethod
    def velocities(cls, q: Array, speed: float) -> Array:
        """Velocities (9,) of all bodies at a crank speed."""
        matrix = cls.jacobian(q)
        rest = np.delete(np.arange(9), 2)
        v = np.zeros(9)
        v[2] = speed
        v[rest] = np.linalg.solve(matrix[:, rest], -matrix[:, 2] * speed)
        return v


def integrated(speed: float, torque: float, duration: float, steps: int) -> tuple[Array, Array]:
    """States of a multibody integration (Runge–Kutta): coordinates and velocities, (steps + 1, 9) each."""
    q = Bodies.assembled(0.3)
    v = Bodies.velocities(q, speed)
    states = [(q, v)]
    h = duration / steps
    for _ in range(steps):
        slopes: list[tuple[Array, Array]] = []
        for share in (0.0, 0.5, 0.5, 1.0):
            at_q, at_v = (
                (q, v) if not slopes else (q + share * h * slopes[-1][0], v + share * h * slopes[-1][1])
            )
            slopes.append((at_v, Bodies.step(at_q, at_v, torque)[0]))
        q = q + h / 6.0 * sum(w * s[0] for w, s in zip((1, 2, 2, 1), slopes, strict=True))
        v = v + h / 6.0 * sum(w * s[1] for w, s in zip((1, 2, 2, 1), slopes, strict=True))
        states.append((q, v))
    return np.array([s[0] for s in states]), np.array([s[1] for s in states])


def at_state(angle: float, speed: float, acceleration: float) -> Loads:
    return loads(single(), [-50.0, 50.0], speed, np.array([angle]), acceleration)


def test_loads_are_the_joint_forces_of_the_multibody_model() -> None:
    torque = 8.0e9  # g·mm²/s², 8 N·m
    coordinates, velocities = integrated(speed=90.0, torque=torque, duration=0.08, steps=1600)
    assert np.abs(Bodies.joints(coordinates[-1])).max() < 1e-5  # it stayed together
    assert coordinates[-1, 2] > 2.0 * math.pi  # and turned
    for q, v in zip(coordinates[::160], velocities[::160], strict=True):
        acceleration, joint = Bodies.step(q, v, torque)
        found = at_state(float(q[2]), float(v[2]), float(acceleration[2]))
        size = float(np.abs(joint[:7]).max()) * N_PER_G_MM_S2
        close = 1e-6 * size  # the integration drifts by 1e-7
        np.testing.assert_allclose(
            found.main_n.sum(axis=0)[0], joint[0:2] * N_PER_G_MM_S2, rtol=0.0, atol=close
        )
        np.testing.assert_allclose(found.crankpin_n[0, 0], joint[2:4] * N_PER_G_MM_S2, rtol=0.0, atol=close)
        np.testing.assert_allclose(found.wrist_pin_n[0, 0], joint[4:6] * N_PER_G_MM_S2, rtol=0.0, atol=close)
        np.testing.assert_allclose(found.wall_n[0, 0], joint[6] * N_PER_G_MM_S2, rtol=0.0, atol=close)
        assert found.torque_n_m[0] == pytest.approx(torque * N_M_PER_G_MM2_S2, rel=1e-5)


def test_forces_are_the_change_of_momentum_of_the_multibody_model() -> None:
    coordinates, velocities = integrated(speed=150.0, torque=0.0, duration=0.02, steps=2000)
    momentum = velocities.reshape(-1, 3, 3)[:, :, :2].transpose(0, 2, 1) @ Bodies.masses[::3]
    h = 0.02 / 2000
    for number in range(100, 1900, 225):
        change = (momentum[number + 1] - momentum[number - 1]) / (2.0 * h) * N_PER_G_MM_S2
        acceleration = float(velocities[number + 1, 2] - velocities[number - 1, 2]) / (2.0 * h)
        found = at_state(float(coordinates[number, 2]), float(velocities[number, 2]), acceleration)
        shaking = found.main_n.sum(axis=0)[0] + np.array([0.0, found.wall_n[0, 0]])
        np.testing.assert_allclose(
            shaking, -change, atol=1e-4 * np.abs(momentum).max() * N_PER_G_MM_S2 * 150.0
        )


def test_mean_inertia_torque_is_zero_and_its_work_the_change_of_energy() -> None:
    engine, speed = single(), 800.0
    turn = whole_turn(720)
    torque = loads(engine, [-50.0, 50.0], speed, turn).torque_n_m
    assert abs(torque.mean()) < 1e-12 * np.abs(torque).max()
    energy = (
        0.5
        * speed**2
        * N_M_PER_G_MM2_S2
        * variable_inertia_g_mm2(engine.cylinders[0], engine.cylinders[0].slider_crank.motion(turn))
    )
    spectrum = np.fft.rfft(torque)  # exact integral over the angle: the torque is smooth and periodic
    spectrum[1:] /= 1j * np.arange(1, spectrum.size)
    work = np.fft.irfft(spectrum, n=720)
    np.testing.assert_allclose(work - work[0], energy - energy[0], atol=1e-10 * np.ptp(energy))


def test_mean_torque_is_the_kinetic_energy_of_speeding_up() -> None:
    engine, rate = single(), 5000.0
    turn = whole_turn(360)
    torque = loads(engine, [-50.0, 50.0], 0.0, turn, rate).torque_n_m
    inertia = engine.polar_inertia_g_mm2 + variable_inertia_g_mm2(
        engine.cylinders[0], engine.cylinders[0].slider_crank.motion(turn)
    )
    np.testing.assert_allclose(torque, inertia * rate * N_M_PER_G_MM2_S2, rtol=1e-13)


@pytest.mark.parametrize("acceleration", [0.0, 3000.0])
def test_torque_is_that_of_the_crankpin_loads(acceleration: float) -> None:
    engine = vee(
        [0.0, 2.1, 4.0], 90.0, [-0.5, 0.6], SliderCrank(40.0, 130.0), Parts(400.0, 500.0, 80.0), 20.0
    )
    turn = whole_turn(90)
    found = loads(engine, [-180.0, -60.0, 60.0, 180.0], 500.0, turn, acceleration)
    torque = np.zeros(90)
    for cylinder, load in zip(engine.cylinders, found.crankpin_n, strict=True):
        pin_x = 40.0 * np.cos(turn + cylinder.throw_angle_rad)
        pin_y = 40.0 * np.sin(turn + cylinder.throw_angle_rad)
        torque -= (pin_x * load[:, 1] - pin_y * load[:, 0]) * 1e-3
    np.testing.assert_allclose(found.torque_n_m, torque, atol=1e-9)


def test_mains_and_walls_carry_the_shaking_force_and_moment() -> None:
    mains = [-180.0, -60.0, 60.0, 180.0]
    engine = vee(
        [0.0, 2.1, 4.0], 90.0, [-0.5, 0.6], SliderCrank(40.0, 130.0), Parts(400.0, 500.0, 80.0), 20.0
    )
    turn = whole_turn(64)
    found = loads(engine, mains, 500.0, turn)
    walls = np.stack(
        [
            wall[:, None] * np.array([-math.sin(cylinder.bank_rad), math.cos(cylinder.bank_rad)])
            for cylinder, wall in zip(engine.cylinders, found.wall_n, strict=True)
        ]
    )
    force = found.main_n.sum(axis=0) + walls.sum(axis=0)
    np.testing.assert_allclose(force, engine.force_n(turn, 500.0), atol=1e-9)
    moment = np.tensordot(mains, found.main_n, axes=1) * 1e-3
    moment += np.tensordot([cylinder.z_mm for cylinder in engine.cylinders], walls, axes=1) * 1e-3
    summed = sum(
        (order.moment_n_m[None, :] * np.exp(1j * order.order * turn)[:, None]).real
        for order in engine.orders(500.0, highest=24)
    )
    np.testing.assert_allclose(moment, summed, atol=1e-7)


def test_crank_frame_is_the_engine_frame_turned_back() -> None:
    turn = whole_turn(8)
    engine = Engine((), (CrankUnbalance(np.array([100.0, 0.0]), 10.0),))
    found = loads(engine, [0.0, 40.0], 300.0, turn)
    seen = found.main_in_crank_frame_n()
    np.testing.assert_allclose(seen[0, :, 0], 0.75 * 100.0 * 300.0**2 * 1e-6)
    np.testing.assert_allclose(seen[:, :, 1], 0.0, atol=1e-12)


def test_every_load_is_carried_whole() -> None:
    mains = [-100.0, -20.0, 50.0]
    for z in (-150.0, -100.0, -60.0, -20.0, 0.0, 50.0, 90.0):
        shares = lever_shares(z, mains)
        assert shares.sum() == pytest.approx(1.0)
        assert float(shares @ np.array(mains)) == pytest.approx(z)


@pytest.mark.parametrize("mains", [[], [0.0], [10.0, 10.0], [20.0, 10.0]])
def test_main_bearings_must_increase(mains: list[float]) -> None:
    with pytest.raises(ValueError, match="expected at least two, increasing"):
        lever_shares(0.0, mains)


@pytest.mark.timing
def test_a_turn_of_a_twelve_is_quick() -> None:
    from benchmarks.engine_loads import revolution, seconds

    assert revolution().main_n.shape == (7, 7200, 2)
    assert min(seconds(5)) < 0.05  # the least of a few: others may be using the machine


def test_one_place_that_holds_the_crank_takes_what_two_bearings_would() -> None:
    """Force and moment follow from statics: those of any two bearings, brought to the place."""
    engine, angle, places, here = single(), whole_turn(24), (-30.0, 50.0), 17.0
    support, beside = support_of(engine, here, 300.0, angle, 40.0)
    two = loads(engine, places, 300.0, angle, 40.0)
    np.testing.assert_allclose(support.force_n, two.main_n.sum(axis=0), atol=1e-8)
    moment = sum(load * (z - here) for load, z in zip(two.main_n, places, strict=True))
    np.testing.assert_allclose(support.moment_n_m, 1e-3 * moment, atol=1e-8)
    np.testing.assert_array_equal(beside.crankpin_n, two.crankpin_n)
