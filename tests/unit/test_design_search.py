"""Profiles, their moments, and the clearances of what turns, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.errors import JobError
from autobalance.profile_search.files import front_plot
from autobalance.profile_search.neighbours import OtherShaft, Piston, Rod, circle_mm, least_clearance
from autobalance.profile_search.outlines import Profile, fitted_radii_mm, refuse_crossing
from autobalance.solid.csg.region import Region

PROFILE = Profile.even((math.radians(95.0), math.radians(250.0)), 11, 26.0)
RADII = 45.0 + 9.0 * np.random.default_rng(3).random(11)


def test_moments_are_those_of_the_outline() -> None:
    own = PROFILE.moments(RADII)[0]
    area, first, second = Region.of([PROFILE.polygon_mm(RADII)]).area_moments()
    fine = 2e-4  # the facets of the outline
    assert own.area_mm2 == pytest.approx(area, rel=fine)
    assert own.first_mm3 == pytest.approx(first, rel=fine)
    assert own.second_mm4 == pytest.approx(second, rel=fine)


def test_gradients_are_those_of_differences() -> None:
    slope, step = PROFILE.moments(RADII)[1], 1e-4
    for place, unit in enumerate(np.eye(11)):
        more, less = (PROFILE.moments(RADII + sign * step * unit)[0] for sign in (1.0, -1.0))
        area = (more.area_mm2 - less.area_mm2) / (2.0 * step)
        assert slope.area_mm2[place] == pytest.approx(area, rel=1e-7)
        first = (more.first_mm3 - less.first_mm3) / (2.0 * step)
        assert slope.first_mm3[place] == pytest.approx(first, rel=1e-6, abs=1e-6)
        second = (more.second_mm4 - less.second_mm4) / (2.0 * step)
        assert slope.second_mm4[place] == pytest.approx(second, rel=1e-6, abs=1e-4)


def test_a_circle_is_fitted_and_measured() -> None:
    angles = np.linspace(PROFILE.angles_rad[0], PROFILE.angles_rad[-1], 200)
    radii, error = fitted_radii_mm(PROFILE, angles, np.full(200, 50.0))
    assert error < 0.01
    exact = 0.5 * (50.0**2 - 26.0**2) * (PROFILE.angles_rad[-1] - PROFILE.angles_rad[0])
    assert PROFILE.moments(radii)[0].area_mm2 == pytest.approx(exact, rel=3e-4)
    assert PROFILE.curvature_radii_mm(radii)[20:-20] == pytest.approx(50.0, rel=0.05)


def test_control_points_that_cross_are_refused() -> None:
    with pytest.raises(JobError, match="from point 1 to 2 meets that from 3 to 4"):
        refuse_crossing(np.array([[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]), "counterweight[1]")


def at(radius_mm: float, angle_deg: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    angle = math.radians(angle_deg)
    return np.array([[radius_mm * math.cos(angle), radius_mm * math.sin(angle)]])


def test_a_rim_passes_the_piston_nearest_at_bottom_dead_centre() -> None:
    piston = Piston("piston 1", (-5.0, 5.0), 0.0, 30.0, 110.0, 20.0, 25.0)
    found = least_clearance(piston, at(55.0, 180.0), (-10.0, 10.0))
    assert found.least_mm == pytest.approx(110.0 - 30.0 - 20.0 - 55.0, abs=1e-9)
    assert math.degrees(found.at_rad) == pytest.approx(180.0, abs=0.01)
    beside = least_clearance(piston, at(55.0, 180.0), (8.0, 10.0))
    assert beside.least_mm == pytest.approx(math.hypot(5.0, 3.0), abs=1e-6)


def test_a_shank_swings_through_what_is_beside_its_pin() -> None:
    rod = Rod("rod 1", (-25.0, 25.0), 0.0, 30.0, 110.0, 22.0, 10.0)
    shank = least_clearance(rod, at(10.0, 180.0), (-1.0, 1.0))
    assert shank.least_mm == pytest.approx(-10.0, abs=1e-6)  # on the shank's own axis at 180°
    assert math.degrees(shank.at_rad) == pytest.approx(180.0, abs=0.1)
    big_end = least_clearance(rod, at(20.0, 0.0), (-1.0, 1.0))
    assert big_end.least_mm == pytest.approx(10.0 - 22.0, abs=1e-6)
    apart = least_clearance(rod, at(20.0, 0.0), (28.0, 40.0))
    assert apart.least_mm == pytest.approx(3.0, abs=1e-9)


@pytest.mark.parametrize("ratio", [-1.0, 2.0, 0.5])
def test_a_round_shaft_is_passed_at_its_centre_distance(ratio: float) -> None:
    shaft = OtherShaft("shaft 1", (0.0, 5.0), np.array([0.0, 95.0]), circle_mm(20.0), ratio, 0.0)
    found = least_clearance(shaft, at(50.0, 77.0), (0.0, 5.0))
    assert found.least_mm == pytest.approx(95.0 - 50.0 - 20.0, abs=5e-3)
    assert math.degrees(found.at_rad) % 360.0 == pytest.approx(13.0, abs=0.5)


def test_a_square_shaft_is_met_by_its_corner() -> None:
    square = np.array([[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]])
    shaft = OtherShaft("shaft 1", (0.0, 5.0), np.array([0.0, 80.0]), square, -1.0, math.radians(45.0))
    found = least_clearance(shaft, at(60.0, 0.0), (0.0, 5.0))  # at 90° the square has turned by −90° + 45°
    assert found.least_mm == pytest.approx(80.0 - 60.0 - 10.0 * math.sqrt(2.0), abs=1e-3)


def test_a_thin_tooth_that_passes_between_the_angles_looked_at_is_found() -> None:
    """Of the other shaft's round body 2.5 mm are left; of its one tooth 2.0 mm, for 0.05°."""
    ratio, tooth = -7.5, math.radians(0.2)
    angles = np.sort(np.concatenate([np.arange(60) * math.tau / 60, [tooth, math.tau - tooth]]))
    radii = np.where(angles == 0.0, 38.0, 37.5 / math.cos(math.pi / 60))
    radii[[1, -1]] = 37.5
    outline = radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    meets = math.radians(13.0)
    phase = -0.5 * math.pi - ratio * meets  # the corner and the tooth point at each other
    shaft = OtherShaft("shaft 1", (0.0, 5.0), np.array([0.0, 100.0]), outline, ratio, phase)
    found = least_clearance(shaft, at(60.0, 77.0), (0.0, 5.0))
    assert found.least_mm == pytest.approx(2.0, abs=1e-4)
    assert found.at_rad == pytest.approx(meets, abs=1e-4)
    assert least_clearance(shaft, at(60.0, 77.0), (0.0, 5.0), refine=False).least_mm > 2.3


def test_a_single_objective_is_drawn_over_the_designs_and_not_over_itself() -> None:
    values = np.array([[3.0], [1.0], [2.0]])
    svg = front_plot(("mass_g",), values[1:2], values)["svg"].decode()
    assert svg.count("mass_g") == 1
    assert "design, in order" in svg
