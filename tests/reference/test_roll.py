"""The couple that rolls the block, and balance shafts on mounts, against walls, levers and own matrices."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import autobalance as ab
from autobalance.running_gear.loads import loads
from autobalance.running_gear.roll import momentum_roll_n_m, roll_n_m, roll_orders
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import Cylinder, Engine
from tests.near import near
from tests.reference.test_articulated import Multibody, radial

Array = NDArray[np.float64]
TURN = 2.0 * math.pi * np.arange(1440) / 1440
N_M = 1e-9
"""g·mm²/s² in N·m."""


def rod_and_piston(
    crank: tuple[float, float, float], masses: tuple[float, float, float, float], angle: float, speed: float
) -> tuple[float, float]:
    """Wall force on the block along +Y and the rods' torque on the crank, of one rigid rod and piston.

    ``crank``: radius, rod length, offset [mm]; ``masses``: rod, its centre from the crankpin, its inertia
    about its centre, piston [g, mm, g·mm², g]. Newton and Euler of both bodies as one linear system.
    """
    r, length, offset = crank
    rod, centre, inertia, piston = masses

    def bodies(at: float) -> Array:
        tilt = math.asin((offset - r * math.sin(at)) / length)
        u = np.array([math.cos(tilt), math.sin(tilt)])
        pin = r * np.array([math.cos(at), math.sin(at)])
        return np.array([*(pin + centre * u), tilt, (pin + length * u)[0]])

    step = 1e-3
    points = [bodies(angle + k * step) for k in (-2, -1, 0, 1, 2)]
    a, b, c, d, e = points
    second = (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / (12.0 * step**2) * speed**2
    tilt = c[2]
    u = np.array([math.cos(tilt), math.sin(tilt)])
    to_pin, to_wrist = -centre * u, (length - centre) * u
    # unknown: force of the crank on the rod (2), of the piston on the rod (2), of the wall on the piston
    system = np.zeros((5, 5))
    system[0, [0, 2]] = 1.0
    system[1, [1, 3]] = 1.0
    system[2] = [-to_pin[1], to_pin[0], -to_wrist[1], to_wrist[0], 0.0]
    system[3, 2] = -1.0
    system[4, [3, 4]] = -1.0, 1.0
    right = [rod * second[0], rod * second[1], inertia * second[2], piston * second[3], 0.0]
    pin_x, pin_y, _, _, wall = np.linalg.solve(system, right)
    torque = -r * (math.cos(angle) * pin_y - math.sin(angle) * pin_x)
    return -wall, torque


@pytest.mark.parametrize("offset", [0.0, 10.0, -6.0])
@pytest.mark.parametrize("share", [1.0, 0.8, 1.3])
def test_a_rod_and_its_wall_against_newton_and_euler(offset: float, share: float) -> None:
    """Wall × lever of two bodies; rods of m a b on a centred cylinder give minus the torque, others not."""
    r, length, rod, centre, piston, speed = 44.9, 152.0, 520.0, 44.0, 640.0, 300.0
    inertia = share * rod * centre * (length - centre)
    small = rod * centre / length
    cylinder = Cylinder(
        SliderCrank(r, length, offset),
        rod - small,
        piston + small,
        small_end_g=small,
        couple_inertia_g_mm2=inertia - rod * centre * (length - centre),
    )
    engine = Engine((cylinder,))
    angles = TURN[::60]
    roll, torques = [], []
    for angle in angles:
        wall, torque = rod_and_piston(
            (r, length, offset), (rod, centre, inertia, piston), float(angle), speed
        )
        place = r * math.cos(angle) + math.sqrt(length**2 - (offset - r * math.sin(angle)) ** 2)
        roll.append(place * wall * N_M)
        torques.append(torque * N_M)
    size = max(abs(each) for each in roll)
    found = roll_n_m(engine, angles, speed)
    assert near(found, np.array(roll), within=1e-7 * size)
    only_torque = -np.array(torques)
    if offset == 0.0 and share == 1.0:
        assert near(found, only_torque, within=1e-7 * size)
        assert np.abs(momentum_roll_n_m(engine, angles, speed)).max() == 0.0
    else:
        assert np.abs(found - only_torque).max() > 0.01 * size


@pytest.mark.parametrize(("count", "offset", "skew"), [(3, 0.0, 0.0), (5, 4.0, 0.03), (9, -3.0, 0.02)])
def test_walls_and_angular_momentum_agree_on_a_radial_with_gas(
    count: int, offset: float, skew: float
) -> None:
    """Σ piston × wall + offset × gas on the head = −dH/dt − T, to 1e-8, by an own multibody system."""
    engine, speed = radial(count, offset, skew), 260.0
    angles = np.linspace(0.0, 2.0 * math.pi, 23, endpoint=False)
    gas = np.random.default_rng(count).uniform(0.0, 2e4, (count, len(angles)))
    plain = roll_n_m(engine, angles, speed)
    gas_torque = loads(engine, (0.0, 10.0), speed, angles, gas_n=gas).gas_torque_n_m
    for n, angle in enumerate(angles):
        body = Multibody(engine, float(angle), speed, gas[:, n])
        pin, walls = body.forces()
        roll = sum(
            (place[0].conjugate() * wall * 1j * bank).imag - each.slider_crank.offset_mm * push
            for each, place, wall, bank, push in zip(
                engine.cylinders, body.w, walls, body.banks, gas[:, n], strict=True
            )
        )
        torque = (body.c[0].conjugate() * pin).imag
        momentum = sum(
            each.reciprocating_g * (w[0].conjugate() * w[2]).imag
            + each.rotating_g * (k[0].conjugate() * k[2]).imag
            for each, w, k in zip(engine.cylinders, body.w, body.k, strict=True)
        )
        assert float(roll.real) == pytest.approx(-momentum * 1e-6 - torque, rel=1e-8)
        assert (plain[n] - gas_torque[n]) * 1e3 == pytest.approx(float(roll.real), rel=1e-8, abs=1e-3)


def test_orders_of_the_roll_are_its_signal() -> None:
    engine = radial(5, 4.0, 0.03)
    total = sum(
        (amplitude * np.exp(1j * n * TURN)).real for n, amplitude in enumerate(roll_orders(engine, 40))
    )
    own = roll_n_m(engine, TURN, 1.0)
    assert near(total, own - own.mean(), within=1e-8 * np.abs(own).max())


# --- shafts and the line of the piston ----------------------------------------------------------------------

RUCKLE = {"r": 44.9, "l": 152.0, "m": 1216.0, "e": 10.0, "rpm": 2000.0}
"""Ruckle 2014, Sec. 3.1.2: a single with an offset cylinder."""


def ruckle_acceleration(angle: Array) -> Array:
    """Acceleration of Ruckle's piston by finite differences of its place [mm/s²]."""
    r, length, offset = (RUCKLE[key] for key in ("r", "l", "e"))
    speed = RUCKLE["rpm"] * math.pi / 30.0

    def place(at: Array) -> Array:
        return np.asarray(r * np.cos(at) + np.sqrt(length**2 - (offset - r * np.sin(at)) ** 2))

    step = 1e-3
    return (place(angle + step) - 2.0 * place(angle) + place(angle - step)) / step**2 * speed**2


def ruckle_roll(height: float) -> float:
    """Greatest roll of Ruckle's single with a pair whose line is ``height`` off the axis [N·m]."""
    r, mass, offset = (RUCKLE[key] for key in ("r", "m", "e"))
    speed = RUCKLE["rpm"] * math.pi / 30.0
    angle = np.linspace(0.0, 2.0 * math.pi, 7201)
    line = offset * mass * ruckle_acceleration(angle)
    # the pair pulls against the piston: −m r ω² cos θ on the block, along the cylinder
    pair = -mass * r * speed**2 * np.cos(angle)
    return float(np.abs(line - height * pair).max()) * N_M


def ruckle_job(crank: ab.Crank, height: float | None) -> dict[str, Any]:
    scale = crank.throws[0].crank_radius_mm / RUCKLE["r"]
    shafts = [
        {
            "order": 1,
            "sense": sense,
            "product_g_mm": RUCKLE["m"] * RUCKLE["r"] / 2.0 / scale,
            "phase_deg": 180.0,
            "place_mm": [0.0, (height or 0.0) * scale],
        }
        for sense in ("forward", "backward")
    ]
    return {
        "engine": {
            "rod_length_mm": RUCKLE["l"] * scale,
            "layout": {"bank_deg": 0.0, "offset_mm": RUCKLE["e"] * scale},
            "rotating_g": {"big_end": 100.0},
            "reciprocating_g": {"piston": RUCKLE["m"] / scale**2},
        },
        "balance": {"factor": 0.0, "grade": 6.3, "speed_rpm": RUCKLE["rpm"]},
        "correction": {"method": "drill"},
        **({} if height is None else {"shafts": shafts}),
    }


@pytest.fixture(scope="module")
def single() -> ab.Crank:
    return ab.generate("single", segments=32).crank


@pytest.mark.parametrize(("height", "figure"), [(0.0, 31.1), (10.0, 9.3)])
def test_shafts_belong_under_an_offset_cylinder(single: ab.Crank, height: float, figure: float) -> None:
    """Weights scaled so that the roll is that of the source's engine."""
    job = ruckle_job(single, height)
    told = ab.shafts(job, single).report["with"]
    assert ruckle_roll(height) == pytest.approx(figure, abs=0.05)
    assert told["greatest_roll_n_m"] == pytest.approx(ruckle_roll(height), rel=1e-4)
    states = ab.forces(job, single).report["states"]
    for state in states:
        assert state["with_shafts"]["greatest_roll_besides_torque_n_m"] == pytest.approx(
            ruckle_roll(height), rel=1e-4
        )
        left = {each["order"]: each for each in state["with_shafts"]["orders"]}
        bare = {each["order"]: each for each in state["force"]["orders"]}
        # the offset's share in quadrature, e/l, is what a pair in phase with the crank leaves
        assert left[1.0]["backward_n"] == pytest.approx(0.068 * bare[1.0]["backward_n"], rel=0.01)
        assert left[2.0] == bare[2.0]


@pytest.mark.parametrize("turns", ["ccw", "cw"])
def test_proposed_shafts_stand_where_the_roll_is_least(single: ab.Crank, turns: str) -> None:
    job = ruckle_job(single, None)
    job["engine"]["turns"] = turns
    report = ab.shafts(job, single).report
    scale = single.throws[0].crank_radius_mm / RUCKLE["r"]
    assert report["without"]["greatest_roll_n_m"] == pytest.approx(ruckle_roll(0.0), rel=1e-3)
    pair, alone, _ = (each for each in report["proposals"] if each["shafts"])
    middle = np.mean([each["place_mm"] for each in pair["shafts"]], axis=0)
    assert middle == pytest.approx([0.0, RUCKLE["e"] * scale], abs=0.04 * RUCKLE["e"] * scale)
    # the first order is gone altogether, the others stay
    line = RUCKLE["e"] * RUCKLE["m"] * ruckle_acceleration(TURN) * N_M
    spectrum = np.fft.rfft(line)
    spectrum[1] = 0.0
    rest = np.fft.irfft(spectrum, len(line))
    assert pair["greatest_roll_n_m"] == pytest.approx(np.abs(rest).max(), rel=1e-4)
    # one shaft takes half of the force, and all of the roll at twice the distance
    assert alone["shafts"][0]["place_mm"] == pytest.approx([0.0, 2.0 * RUCKLE["e"] * scale], rel=0.1, abs=1.0)
    assert "Roll couple on the block" in ab.shafts(job, single).text()


def test_without_offset_shafts_stay_on_the_axis(single: ab.Crank) -> None:
    job = ruckle_job(single, None)
    job["engine"]["layout"] = {"bank_deg": 30.0}
    report = ab.shafts(job, single).report
    assert report["without"]["greatest_roll_n_m"] == 0.0
    assert {tuple(s["place_mm"]) for each in report["proposals"] for s in each["shafts"]} == {(0.0, 0.0)}


# --- on mounts ----------------------------------------------------------------------------------------------

MASS, RADIUS_MASS = 145.0e3, 330.0
CENTRE = np.array([120.0, -60.0, 0.0])
INERTIA = np.diag([9.0e9, 1.1e10, 1.4e10])
MOUNTS = (
    ([-250.0, 700.0, 0.0], [18.0, 60.0, 40.0]),
    ([-250.0, -650.0, -80.0], [12.0, 45.0, 20.0]),
    ([-250.0, -650.0, 80.0], [12.0, 45.0, 20.0]),
)
BAR = np.array([620.0, 380.0, 330.0])
DAMPING = 0.08


def mounted(rpm: float, wrench: Array) -> float:
    """RMS velocity of the handlebar [mm/s] under a wrench (n, 6) about the crank axis over a turn."""
    speed = rpm * math.pi / 30.0

    def rows(place: Array) -> Array:
        arm = place - CENTRE
        cross = np.array([[0, arm[2], -arm[1]], [-arm[2], 0, arm[0]], [arm[1], -arm[0], 0]])
        return np.hstack([np.eye(3), cross])

    mass = np.zeros((6, 6))
    mass[:3, :3], mass[3:, 3:] = MASS * np.eye(3), INERTIA
    stiff = np.zeros((6, 6), dtype=complex)
    for at, k in MOUNTS:
        at_rows = rows(np.array(at))
        stiff += at_rows.T @ np.diag(np.array(k) * 1e6 * (1.0 + 2.0j * DAMPING)) @ at_rows
    about_centre = wrench.copy()
    about_centre[:, 3:] -= np.cross(CENTRE, wrench[:, :3])
    spectrum = np.fft.rfft(about_centre, axis=0) * (2.0 / len(wrench))
    total = 0.0
    for n in range(1, 9):
        omega = n * speed
        motion = np.linalg.solve(stiff - omega**2 * mass, spectrum[n])
        total += 0.5 * float((np.abs(1j * omega * rows(BAR) @ motion) ** 2).sum())
    return math.sqrt(total)


def single_wrench(
    rpm: float, factor: float, shaft: float, place: tuple[float, float], offset: float
) -> Array:
    """Forces of a single by finite differences; one shaft against the crank; the roll by the wall's lever."""
    r, length, speed = 29.0, 120.0, rpm * math.pi / 30.0
    step = 1e-3

    def along(at: Array) -> Array:
        return np.asarray(r * np.cos(at) + np.sqrt(length**2 - (offset - r * np.sin(at)) ** 2))

    x = along(TURN)
    second = (along(TURN + step) - 2.0 * x + along(TURN - step)) / step**2 * speed**2
    tilt = np.arcsin((offset - r * np.sin(TURN)) / length)
    wall = RADIUS_MASS * second * np.tan(tilt)  # of the massless rod's side push, on the block
    out = np.zeros((len(TURN), 6))
    weight = -factor * RADIUS_MASS * r * speed**2
    back = shaft * speed**2
    out[:, 0] = -RADIUS_MASS * second + weight * np.cos(TURN) - back * np.cos(TURN)
    out[:, 1] = weight * np.sin(TURN) + back * np.sin(TURN)
    out[:, 5] = x * wall + place[0] * back * np.sin(TURN) + place[1] * back * np.cos(TURN)
    return out


@pytest.mark.parametrize(
    ("rpm", "shaft", "place", "offset"),
    [
        (7500.0, 0.0, (0.0, 0.0), 0.0),
        (7500.0, 4785.0, (0.0, 0.0), 0.0),
        (1000.0, 4785.0, (0.0, 0.0), 0.0),
        (4000.0, 4785.0, (-35.0, 60.0), 0.0),
        (5200.0, 0.0, (0.0, 0.0), 10.0),
        (1000.0, 4785.0, (0.0, 20.0), 10.0),
    ],
)
@pytest.mark.parametrize("turns", ["ccw", "cw"])
def test_shafts_and_offsets_shake_the_handlebar(
    single: ab.Crank, rpm: float, shaft: float, place: tuple[float, float], offset: float, turns: str
) -> None:
    """A motorcycle's single with its balance shaft against an own rigid body on springs."""
    side = -1.0 if turns == "cw" else 1.0
    mounts = {
        "mass_kg": MASS / 1e3,
        "centre_mm": [CENTRE[0], side * CENTRE[1], CENTRE[2]],
        "inertia_kg_mm2": (INERTIA / 1e3).tolist(),
        "damping_ratio": DAMPING,
        "speed_rpm": [rpm, rpm + 1.0],
        "points": 2,
        "mount": [{"at_mm": [at[0], side * at[1], at[2]], "k_N_mm": k} for at, k in MOUNTS],
        "point": [{"name": "handlebar", "at_mm": [BAR[0], side * BAR[1], BAR[2]]}],
    }
    job: dict[str, Any] = {
        "engine": {
            "turns": turns,
            "rod_length_mm": 120.0,
            "rotating_g": {"big_end": 200.0},
            "reciprocating_g": {"piston": RADIUS_MASS},
            "layout": {"bank_deg": 0.0, "offset_mm": side * offset},
        },
        "balance": {"factor": 0.5, "grade": 16, "speed_rpm": 7500},
        "correction": {"method": "drill"},
        "mounts": mounts,
    }
    if shaft:
        against = {"order": 1, "sense": "backward", "product_g_mm": shaft, "phase_deg": 180.0}
        job["shafts"] = [{**against, "place_mm": [place[0], side * place[1]]}]
    rows = ab.forces(job, single, factors=(0.5,), mounts=True).report["mounts"]["responses"]
    told = next(each for each in rows[0]["places"] if each["name"] == "handlebar")["velocity_rms_mm_s"][0]
    own = mounted(rpm, single_wrench(rpm, 0.5, shaft, place, offset))
    assert told == pytest.approx(own, rel=2e-6)


def test_a_shaft_that_takes_the_first_order_changes_the_best_factor(single: ab.Crank) -> None:
    """Figures of the handlebar at 7500 rpm, without and with the shaft."""
    bare = mounted(7500.0, single_wrench(7500.0, 0.5, 0.0, (0.0, 0.0), 0.0))
    with_shaft = mounted(7500.0, single_wrench(7500.0, 0.5, 4785.0, (0.0, 0.0), 0.0))
    assert bare == pytest.approx(27.65, rel=2e-3)
    assert with_shaft == pytest.approx(6.21, rel=5e-3)


# --- in the cycle -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turns", ["ccw", "cw"])
@pytest.mark.parametrize(("height", "figure"), [(None, 31.1), (0.0, 31.1), (10.0, 9.3)])
def test_a_cycle_has_the_couple_of_an_offset_cylinder(
    single: ab.Crank, height: float | None, figure: float, turns: str
) -> None:
    """Ruckle 2014, Sec. 3.1.2: the couple beside the torque's is that of inertia, whatever the gas does."""
    job = ruckle_job(single, height)
    side = -1.0 if turns == "cw" else 1.0
    job["engine"]["turns"] = turns
    job["engine"]["layout"]["offset_mm"] *= side
    for shaft in job.get("shafts", []):
        shaft["place_mm"][1] *= side
    job["cycle"] = {"bore_mm": 70.0, "compression_ratio": 10.0, "heat_J": 300.0}
    result = ab.cycle(job, crank=single)
    roll = result.report["roll"]
    assert roll["greatest_besides_torque_N_m"] == pytest.approx(figure, abs=0.05)
    assert roll["greatest_pistons_N_m"] == pytest.approx(31.1, abs=0.05)
    # second way: walls by their levers, and gas on the head beside the crank axis
    analysis, shaft_roll = result.analysis, ruckle_roll(0.0)
    (cylinder,) = analysis.firing.engine.cylinders
    place = cylinder.slider_crank.motion(analysis.grid.angle_rad + cylinder.throw_angle_rad).x_mm
    gas = analysis.firing.parts.gas_state.force_n[0]
    lever = cylinder.slider_crank.offset_mm
    block = (place * analysis.loads.wall_n[0] - lever * gas) * 1e-3
    assert shaft_roll == pytest.approx(31.1, abs=0.05)
    if height is None:
        assert roll["greatest_N_m"] == pytest.approx(block.max(), rel=1e-9)
        assert roll["least_N_m"] == pytest.approx(block.min(), rel=1e-9)
        for each in roll["orders"]:
            (own,) = np.abs(analysis.grid.harmonics(block, np.array([each["order"]])))
            assert each["roll_N_m"] == pytest.approx(own, rel=1e-9, abs=1e-9 * np.abs(block).max())
    assert roll["mean_N_m"] == pytest.approx(-analysis.firing.gas_mean_n_m, rel=1e-9)
    assert "without the reaction of the torque" in result.text()


def test_shafts_tell_the_roll_by_order_before_and_after(single: ab.Crank) -> None:
    report = ab.shafts(ruckle_job(single, 10.0), single).report
    line = RUCKLE["e"] * RUCKLE["m"] * ruckle_acceleration(TURN) * N_M
    spectrum = np.abs(np.fft.rfft(line)) * 2.0 / len(line)
    before, after = (
        {each["order"]: each["roll_n_m"] for each in report[key]["roll_orders"]}
        for key in ("without", "with")
    )
    for order in (1, 2, 3, 4):
        assert before[order] == pytest.approx(spectrum[order], rel=1e-4, abs=1e-4)
    pull = RUCKLE["m"] * RUCKLE["r"] * (RUCKLE["rpm"] * math.pi / 30.0) ** 2 * RUCKLE["e"] * N_M
    first = abs(np.fft.rfft(line)[1] * 2.0 / len(line) + pull)
    assert after[1] == pytest.approx(first, rel=1e-3)
    assert after[2] == before[2]
    # each proposal under the cylinder: no first order is left
    (pair, *_) = (each for each in report["proposals"] if len(each["shafts"]) == 2)
    assert pair["roll_orders"][0]["roll_n_m"] < 1e-6 * before[1]
