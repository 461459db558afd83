"""The film through a cycle: mobility against quadrature, steady and whirling loads in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from autobalance.engines.bearings import orbit
from autobalance.engines.bearings.film import JournalBearing, film_at_load
from autobalance.engines.bearings.orbit import Orbits, film_orbits
from autobalance.engines.bearings.reynolds import ocvirk

BEARING = JournalBearing(0.05, 0.02, 25e-6)
VISCOSITY_PA_S, SPEED_RAD_S = 0.01, 300.0
TURN = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
CYCLE = np.linspace(0.0, 4.0 * np.pi, 480, endpoint=False)
RATIO_ERROR = 3e-5
"""What integration and the test of repeating leave, in the clearance."""


def orbits(
    angle: np.ndarray,
    force: np.ndarray,
    speed: float = SPEED_RAD_S,
    bush: float = 0.0,
    most_turns: int | None = None,
) -> Orbits:
    size = BEARING.diameter_m, BEARING.length_m, BEARING.clearance_m
    return film_orbits(angle, force, speed, VISCOSITY_PA_S, *size, bush, most_turns)


def engine_force(angle: np.ndarray) -> np.ndarray:
    """A gas peak along x and a turning inertia."""
    gas = 12000.0 * np.exp(-((np.mod(angle - 0.2, 4.0 * np.pi) / 0.5) ** 2))
    return np.stack([gas - 2500.0 * np.cos(angle), -1500.0 * np.sin(angle)], axis=-1)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("degrees", [0.0, 30.0, 90.0, -140.0, 180.0])
def test_the_half_film_is_its_integral(ratio: float, degrees: float) -> None:
    middle = math.radians(degrees)

    def integral(sines: int) -> float:
        def share(u: float) -> float:
            return math.cos(u) ** (2 - sines) * math.sin(u) ** sines / (1.0 - ratio * math.cos(u)) ** 3

        ends = middle - 0.5 * math.pi, middle + 0.5 * math.pi
        return float(quad(share, *ends, points=[0.0], limit=200)[0])

    found = orbit.half_film(np.array(ratio), (np.array(math.cos(middle)), np.array(math.sin(middle))))
    np.testing.assert_allclose(found, [integral(sines) for sines in range(3)], rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize("ratio", [0.0, 0.5, 0.95, 0.999])
def test_the_velocity_makes_its_force(ratio: float) -> None:
    angle = np.linspace(-np.pi, np.pi, 361)
    ratios = np.full(angle.shape, ratio)
    force = np.cos(angle), np.sin(angle)
    velocity = orbit.squeeze_velocity(ratios, force)
    size = np.hypot(*velocity)
    rr, rt, tt = orbit.half_film(ratios, (velocity[0] / size, velocity[1] / size))
    made = rr * velocity[0] + rt * velocity[1], rt * velocity[0] + tt * velocity[1]
    np.testing.assert_allclose(made, force, atol=1e-7)
    assert (velocity[0] * force[0] + velocity[1] * force[1] > 0.0).all()


def test_no_force_squeezes_nothing() -> None:
    zero = np.zeros(3)
    along, across = orbit.squeeze_velocity(np.array([0.0, 0.5, 0.9]), (zero, zero))
    assert (along == 0.0).all()
    assert (across == 0.0).all()


@pytest.mark.parametrize("load_N", [300.0, 2000.0, 20000.0])
def test_a_steady_load_ends_in_ocvirks_film(load_N: float) -> None:
    found = orbits(TURN, np.tile([0.0, -load_N], (len(TURN), 1)))
    film = film_at_load(BEARING, ocvirk(BEARING.slenderness), VISCOSITY_PA_S, SPEED_RAD_S, load_N)
    assert film is not None
    attitude = film.attitude_rad - 0.5 * math.pi
    place = film.eccentricity_ratio * np.array([math.cos(attitude), math.sin(attitude)])
    np.testing.assert_allclose(found.eccentricity[-1, 0], place, atol=RATIO_ERROR)
    assert found.mean_moment_N_m[0] == pytest.approx(film.moment_N_m, rel=1e-3)
    assert found.turns_to_settle[0] > 0


@pytest.mark.parametrize("load_speed", [-1.0, 2.0])
def test_a_turning_load_is_a_steady_one_at_another_speed(load_speed: float) -> None:
    """In axes that turn with the load the surfaces turn at Ω/2 − Ω_load on average."""
    load_N = 2000.0
    force = load_N * np.stack([np.cos(load_speed * TURN), np.sin(load_speed * TURN)], axis=-1)
    found = orbits(TURN, force)
    apparent = abs(1.0 - 2.0 * load_speed) * SPEED_RAD_S
    film = film_at_load(BEARING, ocvirk(BEARING.slenderness), VISCOSITY_PA_S, apparent, load_N)
    assert film is not None
    # Between rows the force is a chord: at 6° a row it is up to 1.4e-3 shorter than on the arc.
    np.testing.assert_allclose(found.ratio[:, 0], film.eccentricity_ratio, atol=4e-4)
    behind = np.arctan2(found.eccentricity[:, 0, 1], found.eccentricity[:, 0, 0]) - load_speed * TURN
    side = math.copysign(1.0, 1.0 - 2.0 * load_speed)
    np.testing.assert_allclose(np.cos(behind), math.cos(film.attitude_rad), atol=1e-3)
    assert (np.sign(np.sin(behind)) == side).all()


def test_the_bushs_speed_adds_to_the_journals() -> None:
    steady = np.tile([1500.0, 0.0], (len(TURN), 1))
    with_bush = orbits(TURN, steady, bush=SPEED_RAD_S)
    twice = orbits(TURN, steady, speed=2.0 * SPEED_RAD_S)
    np.testing.assert_allclose(with_bush.eccentricity[-1], twice.eccentricity[-1], atol=RATIO_ERROR)
    shear = with_bush.mean_moment_N_m - 0.5 * 25e-6 * with_bush.eccentricity[-1, :, 1] * 1500.0
    assert abs(shear[0]) < 1e-6  # both surfaces turn alike: nothing is sheared


def test_a_bush_that_swings_is_told_by_angle() -> None:
    force = engine_force(CYCLE)
    size = BEARING.diameter_m, BEARING.length_m, BEARING.clearance_m
    still = film_orbits(CYCLE, force, SPEED_RAD_S, VISCOSITY_PA_S, *size, np.full((len(CYCLE), 1), 40.0))
    np.testing.assert_allclose(
        still.eccentricity, orbits(CYCLE, force, bush=40.0).eccentricity, atol=RATIO_ERROR
    )
    swing = 0.25 * SPEED_RAD_S * np.cos(CYCLE)[:, None]
    path = film_orbits(CYCLE, force, SPEED_RAD_S, VISCOSITY_PA_S, *size, swing)
    x, y = path.eccentricity[:, 0].T
    step = CYCLE[1] - CYCLE[0]
    rate = [(np.roll(each, -1) - np.roll(each, 1)) / (2.0 * step) for each in (x, y)]
    mean = 0.5 * (1.0 + swing[:, 0] / SPEED_RAD_S)
    squeeze = np.array([rate[0] + mean * y, rate[1] - mean * x])
    unit = VISCOSITY_PA_S * SPEED_RAD_S * 0.025 * 0.02**3 / 25e-6**2
    for row in range(15, 480, 60):
        made = _film_force(np.array([x[row], y[row]]), squeeze[:, row])
        assert np.hypot(*(made * unit - force[row])) < 0.01 * np.hypot(*force[row]) + 5.0


def test_squeezing_without_turning_follows_its_closed_form() -> None:
    """A constant load on a bush that turns against its journal: straight down, at the rate of J(ε)."""
    path = orbits(TURN, np.tile([4000.0, 0.0], (len(TURN), 1)), bush=-SPEED_RAD_S, most_turns=1)
    unit = VISCOSITY_PA_S * SPEED_RAD_S * 0.025 * 0.02**3 / 25e-6**2

    def rate(_angle: float, ratio: np.ndarray) -> np.ndarray:
        ahead = orbit.half_film(ratio, (np.ones(1), np.zeros(1)))[0]
        return np.asarray(4000.0 / unit / ahead)

    sinking = solve_ivp(rate, (0.0, 2.0 * np.pi), [0.0], t_eval=TURN, rtol=1e-10, atol=1e-12).y[0]
    np.testing.assert_allclose(path.eccentricity[:, 0, 0], sinking, atol=RATIO_ERROR)
    assert np.abs(path.eccentricity[..., 1]).max() < 1e-9
    assert path.turns_to_settle[0] == 0


def test_the_orbit_of_an_engine_repeats_and_obeys_its_equation() -> None:
    force = engine_force(CYCLE)
    path = orbits(CYCLE, force)
    assert 0 < path.turns_to_settle[0] <= 10
    assert path.turns_to_settle[0] % 2 == 0
    assert not path.contact[0]
    x, y = path.eccentricity[:, 0].T
    step = CYCLE[1] - CYCLE[0]
    rate = [(np.roll(each, -1) - np.roll(each, 1)) / (2.0 * step) for each in (x, y)]
    squeeze = np.array([rate[0] + 0.5 * y, rate[1] - 0.5 * x])
    unit = VISCOSITY_PA_S * SPEED_RAD_S * 0.025 * 0.02**3 / 25e-6**2
    for row in range(0, 480, 30):
        made = _film_force(np.array([x[row], y[row]]), squeeze[:, row])
        assert np.hypot(*(made * unit - force[row])) < 0.01 * np.hypot(*force[row]) + 5.0


def _film_force(place: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Integrate the short film's positive pressure by brute force."""
    angle = np.linspace(0.0, 2.0 * np.pi, 20001)[:-1]
    direction = np.stack([np.cos(angle), np.sin(angle)])
    pressure = np.maximum(velocity @ direction, 0.0) / (1.0 - place @ direction) ** 3
    return np.asarray((direction * pressure).sum(axis=1) * (2.0 * np.pi / len(angle)))


def test_cases_go_through_together_as_alone() -> None:
    force = engine_force(CYCLE)
    together = film_orbits(
        CYCLE,
        np.stack([force, 0.3 * force, 1.5 * force], axis=1),
        np.array([200.0, 400.0, 600.0]),
        np.array([0.012, 0.010, 0.008]),
        0.05,
        np.array([0.02, 0.02, 0.025]),
        np.array([25e-6, 30e-6, 22e-6]),
    )
    alone = film_orbits(CYCLE, 1.5 * force, 600.0, 0.008, 0.05, 0.025, 22e-6)
    np.testing.assert_allclose(together.case(2).ratio, alone.ratio, atol=1e-4)
    assert together.least_film_m.shape == (3,)
    rows = np.argmin(together.film_m, axis=0)
    np.testing.assert_array_equal(together.least_at_rad, CYCLE[rows])


def test_a_load_too_great_is_contact() -> None:
    force = np.tile([1e7, 0.0], (len(TURN), 1))
    path = orbits(TURN, force)
    assert path.contact[0]
    assert np.isfinite(path.eccentricity).all()


def test_a_path_that_settles_too_slowly_is_closed_by_newton() -> None:
    """A light film turns at nearly half the speed for hundreds of cycles; its end is the periodic orbit."""
    angle = np.asarray(np.arange(120.0) * (np.pi / 30.0), dtype=np.float64)
    light = np.stack([1.0 + 0.5 * np.cos(0.5 * angle), 0.5 * np.sin(angle)], axis=-1)
    path = orbits(angle, light)
    assert path.turns_to_settle[0] > orbit.MOST_TURNS
    # one more cycle from any of its places, by a finer integration, comes back there
    unit = VISCOSITY_PA_S * SPEED_RAD_S * 0.025 * 0.02**3 / 25e-6**2
    motion = orbit._Motion(angle, light[:, None] / unit, np.full((len(angle), 1), 0.5))
    start = path.eccentricity[0].T
    passed, end = orbit._cycle(motion, start, 1e-9)
    np.testing.assert_allclose(end, start, atol=orbit.CYCLE_CHANGE_TOLERANCE)
    np.testing.assert_allclose(path.eccentricity, passed, atol=1e-4)
