"""Oil films: closed forms, limits of the numerical solution, its order, its coefficients."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.engines.bearings.cases import Supply, outlet_rise_K, running_temperature_C
from autobalance.engines.bearings.film import (
    CONTACT_ECCENTRICITY_RATIO,
    Boundary,
    Film,
    FilmModel,
    JournalBearing,
    film_at_eccentricity,
    film_at_load,
    film_coefficients,
    film_for_load,
)
from autobalance.engines.bearings.oil import WaltherOil
from autobalance.engines.bearings.reynolds import ocvirk, reynolds

SHORT_BEARING = {0.2: (0.46119, 75.43), 0.4: (0.17046, 60.94), 0.6: (0.06253, 46.32), 0.8: (0.013885, 30.50)}
"""Eccentricity ratio → S (L/D)², attitude [°], from Ocvirk's formulas."""
BEARING = JournalBearing(0.05, 0.025, 25e-6)
VISCOSITY_PA_S, SPEED_RAD_S = 0.012, 300.0
COARSE = (60, 20)
FINITE = 1e-6
"""Step of difference quotients of the eccentricity ratio."""


@pytest.mark.parametrize("ratio", SHORT_BEARING)
def test_short_bearing_table(ratio: float) -> None:
    film = ocvirk(0.25)(ratio)
    number, attitude = SHORT_BEARING[ratio]
    assert film.sommerfeld * 0.25**2 == pytest.approx(number, rel=5e-5)
    assert math.degrees(film.attitude_rad) == pytest.approx(attitude, abs=5e-3)


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.9])
def test_short_bearing_pressure_gives_its_force(ratio: float) -> None:
    film = ocvirk(0.5)(ratio)
    angle, place, pressure = film.pressure.angle_rad, film.pressure.place, film.pressure.pressure
    lines = np.trapezoid(pressure, place, axis=1)
    assert np.trapezoid(lines * np.cos(angle), angle) == pytest.approx(film.radial, rel=0.01)
    assert np.trapezoid(lines * np.sin(angle), angle) == pytest.approx(film.tangential, rel=0.01)
    assert pressure.max() == pytest.approx(film.greatest_pressure, rel=0.02)
    assert pressure.max() <= film.greatest_pressure


@pytest.mark.parametrize("boundary", ["half", "reynolds"])
@pytest.mark.parametrize("ratio", [0.3, 0.8])
def test_reynolds_tends_to_ocvirk(boundary: Boundary, ratio: float) -> None:
    short, grid = ocvirk(0.02)(ratio), reynolds(0.02, boundary)(ratio)
    assert grid.sommerfeld == pytest.approx(short.sommerfeld, rel=2e-3)
    assert grid.attitude_rad == pytest.approx(short.attitude_rad, abs=1e-3)
    assert grid.side_flow == pytest.approx(short.side_flow, rel=3e-3)
    assert grid.greatest_pressure == pytest.approx(short.greatest_pressure, rel=4e-3)
    np.testing.assert_allclose(grid.stiffness, short.stiffness, rtol=5e-3)


def test_half_film_coefficients_tend_to_ocvirk() -> None:
    short, grid = ocvirk(0.02)(0.5), reynolds(0.02, "half")(0.5)
    np.testing.assert_allclose(grid.stiffness, short.stiffness, rtol=3e-3)
    np.testing.assert_allclose(grid.damping, short.damping, rtol=3e-3)


@pytest.mark.parametrize("ratio", [0.2, 0.6, 0.9])
def test_full_film_tends_to_sommerfelds_long_bearing(ratio: float) -> None:
    number = math.sqrt(1.0 - ratio**2) * (2.0 + ratio**2) / (12.0 * math.pi**2 * ratio)
    errors = [reynolds(slenderness, "full")(ratio).sommerfeld / number - 1.0 for slenderness in (10.0, 40.0)]
    assert 0.05 < errors[0] < 0.12  # an open end costs about half a diameter of length
    assert errors[1] == pytest.approx(errors[0] / 4.0, rel=0.12)
    assert reynolds(1000.0, "full")(ratio).sommerfeld == pytest.approx(number, rel=1e-3)
    assert math.degrees(reynolds(40.0, "full")(ratio).attitude_rad) == pytest.approx(90.0, abs=1e-6)


@pytest.mark.parametrize("boundary", ["half", "reynolds", "full"])
def test_the_error_falls_with_the_square_of_the_cells(boundary: Boundary) -> None:
    finest = reynolds(1.0, boundary, (240, 80))(0.6).sommerfeld
    cells = np.array([30, 45, 60, 90])
    errors = [reynolds(1.0, boundary, (n, n // 3))(0.6).sommerfeld / finest - 1.0 for n in cells.tolist()]
    order = -np.polyfit(np.log(cells), np.log(np.abs(errors)), 1)[0]
    assert 1.8 < order < 2.5
    assert abs(errors[-1]) < 1e-3


@pytest.mark.parametrize("grid", [(61, 20), (60, 21), (61, 21)])
@pytest.mark.parametrize("boundary", ["half", "reynolds", "full"])
def test_odd_grids_agree(boundary: Boundary, grid: tuple[int, int]) -> None:
    odd, even = reynolds(0.5, boundary, grid)(0.7), reynolds(0.5, boundary, COARSE)(0.7)
    assert odd.sommerfeld == pytest.approx(even.sommerfeld, rel=3e-3)
    assert odd.attitude_rad == pytest.approx(even.attitude_rad, abs=3e-3)
    assert odd.greatest_pressure == pytest.approx(even.greatest_pressure, rel=5e-3)
    np.testing.assert_allclose(odd.stiffness, even.stiffness, rtol=0.02, atol=1e-9)


def test_the_film_ends_without_slope_and_nowhere_below_zero() -> None:
    film = reynolds(1.0)(0.6)
    middle = film.pressure.pressure[:, 0]
    order = np.argsort(film.pressure.angle_rad)
    middle, angle = middle[order], film.pressure.angle_rad[order]
    assert (film.pressure.pressure >= 0.0).all()
    end = int(np.nonzero((middle <= 0.0) & (angle > math.pi))[0][0])
    assert math.pi < angle[end] < 1.4 * math.pi
    steepest = np.abs(np.diff(middle) / np.diff(angle)).max()
    assert middle[end - 1] / (angle[end] - angle[end - 1]) < 0.1 * steepest
    assert film.load > reynolds(1.0, "half")(0.6).load


@pytest.mark.parametrize("model", [ocvirk(0.5), reynolds(0.5, "half", COARSE), reynolds(0.5, "full", COARSE)])
def test_slopes_are_those_of_the_force(model: FilmModel) -> None:
    film, more, less = model(0.5), model(0.5 + 1e-3), model(0.5 - 1e-3)
    assert film.radial_slope == pytest.approx((more.radial - less.radial) / 2e-3, rel=4e-3, abs=1e-6)
    assert film.tangential_slope == pytest.approx((more.tangential - less.tangential) / 2e-3, rel=4e-3)


def test_slopes_with_a_free_end_are_those_of_the_force() -> None:
    model = reynolds(0.5)
    film, more, less = model(0.5), model(0.51), model(0.49)
    assert film.radial_slope == pytest.approx((more.radial - less.radial) / 0.02, rel=5e-3)
    assert film.tangential_slope == pytest.approx((more.tangential - less.tangential) / 0.02, rel=5e-3)


def test_damping_of_a_free_film_is_symmetric() -> None:
    damping = reynolds(0.5)(0.7).damping
    assert damping[0, 1] == pytest.approx(damping[1, 0], rel=5e-3)
    short = ocvirk(0.5)(0.7).damping
    assert short[0, 1] == pytest.approx(short[1, 0], rel=1e-12)


@pytest.mark.parametrize("model", [ocvirk(0.5), reynolds(0.5, "reynolds", COARSE)])
def test_stiffness_is_the_change_of_force_in_fixed_axes(model: FilmModel) -> None:
    """Move the journal along x and y of the load's axes and take the film's force again."""
    film = film_at_eccentricity(BEARING, model, VISCOSITY_PA_S, SPEED_RAD_S, 0.6)
    assert film is not None
    place = 0.6 * np.array([math.cos(film.attitude_rad), math.sin(film.attitude_rad)])
    step = 5e-3
    found = np.zeros((2, 2))
    for axis in (0, 1):
        ends = [_force(model, place + sign * step * np.eye(2)[axis]) for sign in (1.0, -1.0)]
        found[:, axis] = -(ends[0] - ends[1]) / (2.0 * step * BEARING.clearance_m)
    np.testing.assert_allclose(film.stiffness_N_m, found, rtol=0.01)


def _force(model: FilmModel, place: np.ndarray) -> np.ndarray:
    unit = model(float(np.hypot(*place)))
    force = BEARING.force_unit_N(VISCOSITY_PA_S, SPEED_RAD_S)
    radial, tangential = place / np.hypot(*place), np.array([-place[1], place[0]]) / np.hypot(*place)
    return np.asarray(force * (unit.radial * radial + unit.tangential * tangential))


@pytest.mark.parametrize(
    "model", [ocvirk(0.5), reynolds(0.5, "reynolds", COARSE), reynolds(0.5, "full", COARSE)]
)
@pytest.mark.parametrize("ratio", [0.01, 0.3, 0.7, 0.98])
def test_a_load_finds_its_eccentricity(model: FilmModel, ratio: float) -> None:
    load = model(ratio).load
    found = film_for_load(model, load)
    assert found is not None
    assert found.eccentricity_ratio == pytest.approx(ratio, rel=1e-8)


def test_contact_is_a_result() -> None:
    model = ocvirk(0.5)
    at_the_limit = model(CONTACT_ECCENTRICITY_RATIO).load
    assert film_for_load(model, 1.0001 * at_the_limit) is None
    assert film_for_load(model, 0.9999 * at_the_limit) is not None
    assert film_at_load(BEARING, model, VISCOSITY_PA_S, SPEED_RAD_S, 1e9) is None
    assert film_at_eccentricity(BEARING, model, VISCOSITY_PA_S, SPEED_RAD_S, 0.995) is None


@pytest.mark.parametrize("model", [ocvirk(0.5), reynolds(0.5, "half", COARSE), reynolds(0.5, "full", COARSE)])
def test_a_centred_journal_has_petroffs_moment_and_coefficients(model: FilmModel) -> None:
    film = film_at_load(BEARING, model, VISCOSITY_PA_S, SPEED_RAD_S, 0.0)
    assert film is not None
    assert film.eccentricity_ratio == 0.0
    assert film.load_N == film.side_flow_m3_s == film.greatest_pressure_Pa == 0.0
    assert film.sommerfeld is None
    petroff = 2.0 * math.pi * VISCOSITY_PA_S * SPEED_RAD_S * 0.025**3 * 0.025 / 25e-6
    assert film.moment_N_m == pytest.approx(petroff, rel=1e-12)
    assert np.isfinite(film.stiffness_N_m).all()
    half_speed = 0.5 * SPEED_RAD_S * film.damping_N_s_m[0, 0]
    assert film.stiffness_N_m[0, 1] == pytest.approx(half_speed, rel=1e-3)


def test_numbers_of_a_film_in_si() -> None:
    film = film_at_eccentricity(BEARING, ocvirk(0.5), VISCOSITY_PA_S, SPEED_RAD_S, 0.4)
    assert film is not None
    speed_1_s = SPEED_RAD_S / (2.0 * math.pi)
    number = VISCOSITY_PA_S * speed_1_s * 0.025 * 0.05 / film.load_N * (0.025 / 25e-6) ** 2
    assert film.sommerfeld == pytest.approx(number, rel=1e-12)
    assert number * 0.25 == pytest.approx(0.17046, rel=5e-5)
    assert film.side_flow_m3_s == pytest.approx(math.pi * speed_1_s * 0.05 * 0.025 * 25e-6 * 0.4, rel=1e-12)
    assert film.least_film_m == pytest.approx(15e-6, rel=1e-12)


def test_oil_that_enters_the_film_leaves_it() -> None:
    """Flow past a line along the shaft, at the widest gap and at the narrowest: the difference leaves."""
    ratio, slenderness = 0.5, 0.7
    film = reynolds(slenderness, "full", (240, 80))(ratio)
    angle, place, pressure = film.pressure.angle_rad, film.pressure.place, film.pressure.pressure
    lines = np.trapezoid(np.column_stack([pressure, np.zeros(len(angle))]), np.append(place, 1.0), axis=1)
    slope = np.gradient(np.concatenate([lines[-2:], lines, lines[:2]]), np.unwrap(_padded(angle)))[2:-2]
    gap = 1.0 + ratio * np.cos(angle)
    around = 0.5 * gap - gap**3 * slope / 12.0
    widest, narrowest = int(np.argmax(gap)), int(np.argmin(gap))
    assert around[widest] - around[narrowest] == pytest.approx(film.side_flow, rel=5e-3)


def _padded(angle: np.ndarray) -> np.ndarray:
    return np.concatenate([angle[-2:] - 2.0 * np.pi, angle, angle[:2] + 2.0 * np.pi])


def test_coefficients_over_the_speed_turn_with_the_load() -> None:
    speeds = [100.0, 300.0, 900.0]
    along_x = film_coefficients(BEARING, ocvirk(0.5), VISCOSITY_PA_S, speeds, (800.0, 0.0))
    down = film_coefficients(BEARING, ocvirk(0.5), VISCOSITY_PA_S, speeds, (0.0, -800.0))
    assert (np.diff(along_x.eccentricity_ratio) < 0.0).all()
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])
    np.testing.assert_allclose(down.stiffness_N_m, quarter @ along_x.stiffness_N_m @ quarter.T, rtol=1e-10)
    single = film_at_load(BEARING, ocvirk(0.5), VISCOSITY_PA_S, 300.0, 800.0)
    assert single is not None
    np.testing.assert_allclose(along_x.damping_N_s_m[1], single.damping_N_s_m, rtol=1e-8)
    broken = film_coefficients(BEARING, ocvirk(0.5), VISCOSITY_PA_S, [1e-3, 300.0], (800.0, 0.0))
    assert np.isnan(broken.stiffness_N_m[0]).all()
    assert np.isfinite(broken.stiffness_N_m[1]).all()


def test_heat_of_friction_leaves_with_the_oil() -> None:
    oil, supply = WaltherOil.of_points(((40.0, 100.0), (100.0, 11.0))), Supply(60.0)
    model = ocvirk(0.5)

    def film_at(celsius: float) -> Film | None:
        return film_at_load(BEARING, model, oil.viscosity_Pa_s(celsius), SPEED_RAD_S, 2000.0)

    found = running_temperature_C(film_at, oil, supply)
    assert found is not None
    celsius, film = found
    assert celsius > 61.0
    assert celsius - 60.0 == pytest.approx(0.5 * outlet_rise_K(film, oil, supply), abs=1e-4)
    heat = 860.0 * 2000.0 * film.side_flow_m3_s * 2.0 * (celsius - 60.0)
    assert heat == pytest.approx(film.moment_N_m * SPEED_RAD_S, rel=1e-4)


def test_heat_has_no_balance_where_the_film_breaks() -> None:
    oil = WaltherOil.of_points(((40.0, 100.0), (100.0, 11.0)))
    assert running_temperature_C(lambda _: None, oil, Supply(60.0)) is None
