"""Rods, shafts, tables, counterweights, stroking, substitute rotors and grades; each error fires."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.engines.forces.counterweight import (
    Fan,
    ShaftWeight,
    bolted_pair,
    complete_balance,
    fan_counterweight,
    fan_counterweight_for,
)
from autobalance.engines.forces.stroking import stroked_crank, substitute_rotor
from autobalance.rigid_rotor.tolerance import GRADES, listed_grade, specific_unbalance_mm
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.running_gear.conrod import (
    ConnectingRod,
    balancing_counterweights,
    cut_at_centre_of_mass,
    cylinder_mass_g,
    final_hole_depth_mm,
    section_sums,
)
from autobalance.running_gear.loads import whole_turn
from autobalance.running_gear.parts import Parts, correction_mass_g
from autobalance.running_gear.shafts import counter_rotating_shaft, roll_moment_n_m, shaft_pair
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import Cylinder, Engine, vee
from tests.shafts import force_n, placed

TURN = whole_turn(72)
FAN = fan_counterweight(60.0, 25.0, 120.0, 20.0)


# --- rods


def test_rod_of_a_solid_is_the_rod_of_its_points() -> None:
    along = np.array([math.cos(0.7), math.sin(0.7), 0.0])
    start = np.array([12.0, -5.0, 30.0])
    points = [(300.0, 0.0), (80.0, 60.0), (150.0, 150.0)]
    moments = Moments.zero()
    for mass, distance in points:
        moments = moments + Moments.point(mass, start + distance * along)
    rod = ConnectingRod.from_solid(moments, start, start + 150.0 * along)
    centre = sum(mass * distance for mass, distance in points) / 530.0
    assert rod.centre_from_big_end_mm == pytest.approx(centre)
    assert rod.inertia_g_mm2 == pytest.approx(sum(m * (d - centre) ** 2 for m, d in points))
    assert rod.big_end_g + rod.small_end_g == pytest.approx(530.0)


def test_two_masses_at_the_eyes_miss_nothing_of_themselves() -> None:
    ends = Moments.point(400.0, np.zeros(3)) + Moments.point(150.0, np.array([140.0, 0.0, 0.0]))
    rod = ConnectingRod.from_solid(ends, np.zeros(3), np.array([140.0, 0.0, 0.0]))
    assert rod.couple_inertia_g_mm2 == pytest.approx(0.0, abs=1e-6)
    assert ConnectingRod(550.0, 140.0, 30.0).couple_inertia_g_mm2 == 0.0


def test_a_light_cut_is_warned_of_in_either_sense() -> None:
    rod = ConnectingRod.from_two_scales(1000.0, 500.0, 150.0)
    assert "100.0 g at the big end" in cut_at_centre_of_mass(rod, 1100.0, 400.0).warning


def test_impossible_rods_are_refused() -> None:
    with pytest.raises(ValueError, match="mass of the connecting rod is 0 g"):
        ConnectingRod(0.0, 150.0, 10.0)
    with pytest.raises(ValueError, match="length of the connecting rod is -1 mm"):
        ConnectingRod(500.0, -1.0, 0.0)
    with pytest.raises(ValueError, match="must be within its length"):
        ConnectingRod(500.0, 150.0, 160.0)
    with pytest.raises(ValueError, match="inertia of the connecting rod is -5"):
        ConnectingRod(500.0, 150.0, 60.0, -5.0)
    with pytest.raises(ValueError, match="the small end weighs -3 g"):
        ConnectingRod.from_two_scales(100.0, -3.0, 150.0)
    with pytest.raises(ValueError, match="both eyes of the connecting rod have one centre"):
        ConnectingRod.from_solid(Moments.point(1.0, np.zeros(3)), np.zeros(3), np.zeros(3))


# --- shafts


@pytest.mark.parametrize("bank", [0.0, 0.6, -2.0])
@pytest.mark.parametrize("order", [1, 2, 4])
def test_a_pair_cancels_a_force_along_its_cylinder(order: int, bank: float) -> None:
    along = np.array([math.cos(bank), math.sin(bank)])
    for amplitude in (1000.0, -300.0):
        wanted = amplitude * 200.0**2 * 1e-6 * np.cos(order * (TURN - bank))[:, None] * along
        pair = placed(shaft_pair(order, amplitude), bank)
        # At crank angle = bank the piston stands at top dead centre; the pair is set at θ = 0.
        force = force_n(pair, TURN - bank, 200.0)
        np.testing.assert_allclose(force, -wanted, atol=1e-9)


def test_a_counter_rotating_shaft_takes_the_backward_part_of_a_vee() -> None:
    engine = vee([0.3], 0.0, [-0.4, 0.6], SliderCrank(40.0, 140.0), Parts(400.0, 500.0, 50.0))
    first = engine.with_counterweights(0.5).orders(300.0, highest=1)[1]
    shaft = counter_rotating_shaft(first, 300.0)
    left = (first.force_n * np.exp(1j * TURN)[:, None]).real + shaft.force_n(TURN, 300.0)
    np.testing.assert_allclose(left, 0.0, atol=1e-9 * first.greatest_force_n)


def test_shafts_roll_the_engine_unless_mirrored() -> None:
    for bank in (0.0, 0.8):
        mirrored = placed(shaft_pair(1, 1000.0), bank, half_distance_mm=50.0)
        np.testing.assert_allclose(roll_moment_n_m(mirrored, TURN - bank, 300.0)[[0]], 0.0, atol=1e-12)
    pair = placed(shaft_pair(1, 1000.0), half_distance_mm=50.0, height_mm=10.0)
    moment = roll_moment_n_m(pair, TURN, 300.0)
    # Each carries half; their levers are 50 mm to either side, so the moments across cancel in pairs.
    one_side = roll_moment_n_m(pair[:1], TURN, 300.0)
    assert np.abs(moment).max() < np.abs(one_side).max()
    shifted = placed(shaft_pair(1, 1000.0))
    np.testing.assert_allclose(roll_moment_n_m(shifted, TURN, 300.0), 0.0, atol=1e-12)


def test_a_pair_at_one_height_beside_the_cylinder_rolls_by_its_distance() -> None:
    first, second = placed(shaft_pair(1, 1000.0))
    moved = [
        type(shaft)(shaft.order, shaft.forward, shaft.product_g_mm, shaft.phase_rad, 0.0, 30.0)
        for shaft in (first, second)
    ]
    expected = -30.0 * force_n(moved, TURN, 300.0)[:, 0] * 1e-3
    np.testing.assert_allclose(roll_moment_n_m(moved, TURN, 300.0), expected, atol=1e-12)
    assert np.abs(expected).max() == pytest.approx(1000.0 * 300.0**2 * 1e-6 * 0.030)


def test_bolt_on_weights_are_weighed_where_they_can_be() -> None:
    weights = (ShaftWeight("main", 20.0, 100.0, 101.0), ShaftWeight("screws", 10.0, 8.0))
    masses, places = [101.0, 8.0], [20.0, 10.0]
    pair = bolted_pair(1, 5000.0, masses, places)
    assert [weight.product_g_mm for weight in weights] == [2020.0, 80.0]
    assert weights[0].cad_product_g_mm == 2000.0
    assert weights[0].deviation == pytest.approx(0.01)
    assert weights[1].deviation is None
    assert pair.residual_g_mm == pytest.approx(5000.0 - 2.0 * (2020.0 + 80.0))
    assert bolted_pair(1, 5000.0, masses[:1], places[:1]).product_g_mm == 4040.0
    with pytest.raises(ValueError, match="must be of one length"):
        bolted_pair(1, 5000.0, masses, places[:1])


def test_impossible_shafts_are_refused() -> None:
    with pytest.raises(ValueError, match="order of the balance shafts is 0"):
        shaft_pair(0, 1.0)
    with pytest.raises(ValueError, match="lever of the rod's counterweight is 0 mm"):
        complete_balance(
            crank_g_mm=0.0,
            crank_radius_mm=40.0,
            rod_g=300.0,
            rod_length_mm=140.0,
            rod_centre_mm=50.0,
            piston_g=300.0,
            rod_counterweight_mm=0.0,
            crank_counterweight_mm=30.0,
        )


# --- tables


def test_counterweights_that_a_table_asks_for_balance_it() -> None:
    x_mm, y_mm, z_mm = [3.0, 1.0, 0.0, 0.0], [8.0, 45.0, -30.0, -30.0], [20.0, 60.0, 15.0, 95.0]
    products = balancing_counterweights([700.0, 900.0, 500.0, 500.0], x_mm, y_mm, z_mm, 3, 4)
    (x_3, y_3), (x_4, y_4) = products.first_g_mm, products.second_g_mm
    for shift in (0.0, 100.0):  # and not only about this datum
        sums = section_sums(
            [700.0, 900.0, 1.0, 1.0],
            [3.0, 1.0, x_3, x_4],
            [8.0, 45.0, y_3, y_4],
            [z - shift for z in z_mm],
        )
        np.testing.assert_allclose(sums.static_g_mm, 0.0, atol=1e-9)
        np.testing.assert_allclose(sums.dynamic_g_mm2, 0.0, atol=1e-7)


def test_a_counterweight_that_is_not_in_the_table_is_named() -> None:
    with pytest.raises(ValueError, match="second is 3; the table has sections 1 to 2"):
        balancing_counterweights([1.0, 1.0], [0.0, 0.0], [1.0, 1.0], [0.0, 5.0], 2, 3)


def test_final_holes_take_off_what_they_are_asked_to() -> None:
    depth = final_hole_depth_mm(1500.0, 20.0, 60.0, 7850.0)
    taken = cylinder_mass_g(20.0, depth, 7850.0) * (60.0 - 0.5 * depth)
    assert taken == pytest.approx(1500.0)
    assert final_hole_depth_mm(0.0, 20.0, 60.0, 7850.0) == 0.0


@pytest.mark.parametrize("overbalance", [-1.0, 5000.0])
def test_a_hole_past_the_axis_is_refused(overbalance: float) -> None:
    with pytest.raises(ValueError, match="removes 0 to 4439 g·mm"):
        final_hole_depth_mm(overbalance, 20.0, 60.0, 7850.0)


SIZES = ["outer_radius", "thickness", "fan_angle"]


def changed(product_g_mm: float, size: str, fan: Fan = FAN) -> Fan:
    """Return a fan with a size changed for a product."""
    sizes = fan.outer_radius_mm, fan.inner_radius_mm, fan.fan_angle_deg, fan.thickness_mm
    return fan_counterweight_for(product_g_mm, size, *sizes)


@pytest.mark.parametrize("size", SIZES)
def test_a_size_solved_for_gives_the_product(size: str) -> None:
    assert changed(1.1 * FAN.product_g_mm, size).product_g_mm == pytest.approx(1.1 * FAN.product_g_mm)


@pytest.mark.parametrize("size", SIZES)
def test_sensitivities_are_relative_derivatives(size: str) -> None:
    key = f"{size}_deg" if size == "fan_angle" else f"{size}_mm"
    sensitivity = f"sensitivity_{size.removeprefix('outer_').removeprefix('fan_')}"
    wider = changed(FAN.product_g_mm * (1.0 + 1e-6), size)
    growth = math.log(getattr(wider, key) / getattr(FAN, key))
    assert 1e-6 / growth == pytest.approx(getattr(FAN, sensitivity), rel=1e-5)


def test_a_half_turn_fan_gains_nothing_from_a_wider_angle() -> None:
    half = fan_counterweight(60.0, 25.0, 180.0, 20.0)
    assert half.sensitivity_angle == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(ValueError, match="a fan of 180° has the most"):
        changed(1.01 * half.product_g_mm, "fan_angle", half)


def test_impossible_counterweights_are_refused() -> None:
    with pytest.raises(ValueError, match="the inner must be ≥ 0 and less than the outer"):
        fan_counterweight(25.0, 25.0, 60.0, 20.0)
    with pytest.raises(ValueError, match="must be above 0 and at most 360°"):
        fan_counterweight(60.0, 25.0, 361.0, 20.0)
    with pytest.raises(ValueError, match="both must be > 0"):
        fan_counterweight(60.0, 25.0, 60.0, 0.0)
    with pytest.raises(ValueError, match="product of the counterweight is 0"):
        changed(0.0, "thickness")
    with pytest.raises(ValueError, match="must be one of outer_radius, thickness, fan_angle"):
        changed(1.0, "colour")


def test_impossible_cylinders_and_radii_are_refused() -> None:
    with pytest.raises(ValueError, match="diameter must be > 0"):
        cylinder_mass_g(0.0, 10.0, 7850.0)
    with pytest.raises(ValueError, match="radius of the correction is 0 mm"):
        correction_mass_g(100.0, 0.0)


# --- stroking, substitute rotor, grades

STROKING = {
    "stroke_mm": 53.8,
    "bore_mm": 76.8,
    "crankpin_mm": 30.0,
    "crankpin_width_mm": 20.0,
    "main_journal_mm": 28.0,
    "rotating_g": 134.0,
    "reciprocating_g": 260.0,
    "factor": 0.5,
}


@pytest.mark.parametrize(("rotating_g", "lowers"), [(134.0, False), (500.0, True)])
def test_stroking_moves_the_rods_out_and_grinds_the_pin_away(rotating_g: float, *, lowers: bool) -> None:
    crank = stroked_crank(**{**STROKING, "rotating_g": rotating_g}, ground_crankpin_mm=28.0, crankpin_g=120.0)
    assert crank.stroke_mm == pytest.approx(55.8)
    assert crank.crank_radius_mm == pytest.approx(27.9)
    assert crank.overlap_mm == pytest.approx(0.5 * (28.0 + 28.0 - 55.8))
    assert (crank.factor < 0.5) == lowers
    assert crank.product_change_g_mm == pytest.approx((0.5 - crank.factor) * 260.0 * 27.9)


def test_stroking_by_nothing_changes_nothing() -> None:
    crank = stroked_crank(**STROKING, ground_crankpin_mm=30.0, crankpin_g=120.0)
    assert crank.factor == pytest.approx(0.5)
    assert crank.product_change_g_mm == pytest.approx(0.0, abs=1e-9)


def test_impossible_grinding_is_refused() -> None:
    with pytest.raises(ValueError, match="no larger than the old"):
        stroked_crank(**STROKING, ground_crankpin_mm=31.0, crankpin_g=120.0)
    with pytest.raises(ValueError, match="must hold the pin before grinding"):
        stroked_crank(**STROKING, ground_crankpin_mm=28.0, crankpin_g=10.0)


def test_impossible_rotors_are_refused() -> None:
    with pytest.raises(ValueError, match="the disc must be the larger"):
        substitute_rotor(1e3, 20.0, 20.0, 188.0, 7850.0)
    with pytest.raises(ValueError, match=r"the disc would have to be .* at most the length"):
        substitute_rotor(1e6, 98.0, 20.0, 188.0, 7850.0)


def test_grades_fall_and_the_listed_one_is_met() -> None:
    values = [grade.grade_mm_s for grade in GRADES]
    assert values == sorted(values, reverse=True)
    for grade in GRADES:
        assert listed_grade(grade.grade_mm_s) is grade
    assert listed_grade(5000.0) is None
    with pytest.raises(ValueError, match="service speed is 0"):
        specific_unbalance_mm(6.3, 0.0)


def test_engine_without_cylinders_has_only_its_crank() -> None:
    assert Engine(()).orders(100.0, highest=1)[1].greatest_force_n == 0.0
    assert Cylinder(SliderCrank(40.0, 140.0), 1.0, 1.0).direction.tolist() == [1.0, 0.0]
