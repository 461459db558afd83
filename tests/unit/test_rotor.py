"""Moments, unbalance, tolerance: the simplest bodies, exact numbers, and every error."""

import math

import numpy as np
import pytest

from autobalance.rigid_rotor.moments import Moments
from autobalance.rigid_rotor.tolerance import (
    Tolerance,
    achieved_grade_mm_s,
    permissible_unbalance_g_mm,
    share_between_planes,
)
from autobalance.rigid_rotor.unbalance import Unbalance

ROUNDING = 1e-12  # relative, double precision over a handful of operations


def placement(angle: float, shift: tuple[float, float, float]) -> np.ndarray:
    matrix = np.eye(4)
    c, s = math.cos(angle), math.sin(angle)
    matrix[:2, :2] = [[c, -s], [s, c]]
    matrix[:3, 3] = shift
    return matrix


def test_a_body_minus_itself_is_zero() -> None:
    body = Moments.point(3.0, np.array([1.0, 2.0, 3.0])) + Moments.point(2.0, np.array([-1.0, 0.5, 0.0]))
    nothing = body - body
    assert nothing.mass_g == 0.0
    assert not nothing.first_g_mm.any()
    assert not nothing.second_g_mm2.any()
    with pytest.raises(ZeroDivisionError, match="no centre of mass"):
        _ = nothing.centre_mm


def test_moving_moments_is_moving_the_points() -> None:
    points = np.array([[1.0, 2.0, 3.0], [-4.0, 0.5, 2.0], [0.0, 7.0, -1.0]])
    masses = [1.0, 2.5, 0.25]
    matrix = placement(0.7, (3.0, -2.0, 11.0))
    here = there = Moments.zero()
    for mass, point in zip(masses, points, strict=True):
        here += Moments.point(mass, point)
        there += Moments.point(mass, matrix[:3, :3] @ point + matrix[:3, 3])
    moved = here.moved(matrix)
    assert moved.mass_g == there.mass_g
    np.testing.assert_allclose(moved.first_g_mm, there.first_g_mm, rtol=ROUNDING, atol=1e-12)
    np.testing.assert_allclose(moved.second_g_mm2, there.second_g_mm2, rtol=ROUNDING, atol=1e-11)
    assert moved.centre_mm == pytest.approx(there.centre_mm)


def test_inertia_has_negative_products_off_the_diagonal() -> None:
    body = Moments.point(2.0, np.array([1.0, 3.0, 5.0]))
    inertia = body.inertia_g_mm2
    assert inertia[0, 1] == -6.0
    assert inertia[0, 0] == 2.0 * (9.0 + 25.0)
    assert body.polar_inertia_g_mm2 == inertia[2, 2] == 20.0


def test_density_scales_everything() -> None:
    body = Moments.point(2.0, np.array([1.0, 3.0, 5.0])).scaled(3.0)
    assert (body.mass_g, body.first_g_mm[1], body.second_g_mm2[2, 2]) == (6.0, 18.0, 150.0)


def test_resultant_and_moment_go_to_two_planes_and_back() -> None:
    there = Unbalance(np.array([3.0, -4.0]), np.array([120.0, 33.0]))
    vectors = there.in_planes(-40.0, 25.0)
    back = Unbalance.of_planes(vectors, -40.0, 25.0)
    np.testing.assert_allclose(back.resultant_g_mm, there.resultant_g_mm, rtol=ROUNDING)
    np.testing.assert_allclose(back.moment_g_mm2, there.moment_g_mm2, rtol=ROUNDING, atol=1e-11)
    assert there.magnitude_g_mm == 5.0
    np.testing.assert_allclose(there.moment_about_g_mm2(2.0), [114.0, 41.0])
    assert (there - there).magnitude_g_mm == 0.0


def test_unbalance_of_moments_takes_the_lever_along_z() -> None:
    body = Moments.point(2.0, np.array([1.0, 3.0, 5.0]))
    unbalance = Unbalance.of(body)
    assert unbalance.resultant_g_mm.tolist() == [2.0, 6.0]
    assert unbalance.moment_g_mm2.tolist() == [10.0, 30.0]


def test_planes_that_coincide_are_refused() -> None:
    with pytest.raises(ValueError, match="both planes stand at z = 5 mm"):
        Unbalance(np.ones(2), np.ones(2)).in_planes(5.0, 5.0)


@pytest.mark.parametrize(
    ("vector", "degrees"),
    [((1, 0), 0.0), ((0, 2), 90.0), ((-1, 0), 180.0), ((0, -1), 270.0), ((1, -1e-18), 0.0)],
)
def test_the_angle_is_at_least_0_and_below_360(vector: tuple[float, float], degrees: float) -> None:
    angle = Unbalance(np.array(vector, dtype=float), np.zeros(2)).angle_rad
    assert math.degrees(angle) == pytest.approx(degrees, abs=1e-12)
    assert 0.0 <= angle < 2 * math.pi


def test_permissible_unbalance_of_the_motocross_crank() -> None:
    omega = 15200 * 2 * math.pi / 60
    assert permissible_unbalance_g_mm(2700.0, 6.3, omega) == pytest.approx(10.6864168, abs=5e-8)
    assert achieved_grade_mm_s(7.39, 2700.0, omega) == pytest.approx(4.35665209, abs=5e-9)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf])
@pytest.mark.parametrize(("place", "name"), [(0, "rotor mass"), (1, "grade"), (2, "speed")])
def test_permissible_unbalance_refuses_what_is_not_positive(bad: float, place: int, name: str) -> None:
    values = [1.0, 1.0, 1.0]
    values[place] = bad
    with pytest.raises(ValueError, match=name):
        permissible_unbalance_g_mm(*values)


@pytest.mark.parametrize(
    ("z", "shares"),
    [
        (0.0, (5.0, 5.0)),
        (8.0, (4.0, 6.0)),
        (36.0, (3.0, 7.0)),
        (-36.0, (7.0, 3.0)),
        (44.0, (3.0, 10.5)),
        (80.0, (3.0, 13.0)),
        (-80.0, (13.0, 3.0)),
    ],
)
def test_shares_of_the_planes(z: float, shares: tuple[float, float]) -> None:
    assert share_between_planes(10.0, z, -40.0, 40.0) == pytest.approx(shares)


def test_planes_out_of_order_are_refused() -> None:
    with pytest.raises(ValueError, match="first must be lower"):
        share_between_planes(10.0, 0.0, 40.0, -40.0)


def tolerance(judge: str, planes: tuple[float, float] | None = (-40.0, 40.0)) -> Tolerance:
    return Tolerance.of(
        grade_mm_s=10.0,
        service_speed_rad_s=1.0,
        rotor_mass_g=1.0,
        z_centre_mm=0.0,
        planes_z_mm=planes,
        judge=judge,  # type: ignore[arg-type]
    )


def test_a_couple_is_seen_by_the_dynamic_verdict_only() -> None:
    couple = Unbalance(np.zeros(2), np.array([0.0, 80.0 * 6.0]))
    assert tolerance("static").is_met_by(couple)
    assert tolerance("dynamic").used_share(couple) == pytest.approx(6.0 / 5.0)
    assert not tolerance("dynamic").is_met_by(couple)


def test_a_dynamic_verdict_without_planes_is_refused() -> None:
    with pytest.raises(ValueError, match="two tolerance planes"):
        tolerance("dynamic", None)
    assert tolerance("static", None).planes == ()
