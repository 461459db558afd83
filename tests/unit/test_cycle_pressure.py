"""Pressure and work of one cylinder: published anchors, closed forms, and a solver of its own."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from autobalance.engines.cycle.closed_part import Chamber, Charge, Wiebe
from autobalance.engines.cycle.cylinder import CylinderCycle, GasExchange, Strokes
from autobalance.engines.cycle.wall_heat import GasEquation, SolvedPart, Woschni
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.types import Array

BAR = 0.1
CHARGE = Charge(BAR, 330.0, 1.4)
EVEN = GasExchange(4, BAR, BAR, BAR)
LONG_ROD = Chamber(SliderCrank(45.0, 1e7), 90.0, 10.0)
SHORT_ROD = Chamber(SliderCrank(45.0, 140.0, 8.0), 90.0, 10.0)
FIRST_MM3 = float(LONG_ROD.volume_mm3(np.array(-math.pi)))
HEAT = 20.0 * BAR * FIRST_MM3


def deg(angle: float) -> float:
    return math.radians(angle)


def fired(
    start_deg: float, chamber: Chamber = LONG_ROD, exchange: GasExchange = EVEN, duration_deg: float = 40.0
) -> CylinderCycle:
    heat = Wiebe(deg(start_deg), deg(duration_deg), 5.0, 3.0, HEAT)
    return CylinderCycle.modelled(chamber, exchange, CHARGE, heat, None)


@pytest.mark.parametrize(
    ("start_deg", "peak", "at_deg", "work", "efficiency"),
    [(-20.0, 87.782, 10.80, 11.9147, 0.59574), (0.0, 53.532, 27.69, 11.0973, 0.55487)],
)
def test_anchors_of_a_burn_over_40_degrees(
    start_deg: float, peak: float, at_deg: float, work: float, efficiency: float
) -> None:
    found = fired(start_deg)
    assert found.peak[0] / BAR == pytest.approx(peak, abs=6e-4)
    assert math.degrees(found.peak[1]) == pytest.approx(at_deg, abs=0.02)
    assert found.work_n_mm / (BAR * FIRST_MM3) == pytest.approx(work, abs=6e-5)
    assert found.work_n_mm / HEAT == pytest.approx(efficiency, abs=6e-6)


def test_a_sudden_burn_is_the_otto_cycle() -> None:
    shares = [fired(0.0, duration_deg=width).work_n_mm / HEAT for width in (4.0, 2.0, 1.0, 1e-3)]
    missing = 1.0 - 10.0**-0.4 - np.array(shares)
    assert pytest.approx(0.601893, abs=5e-7) == 1.0 - 10.0**-0.4
    assert missing[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.abs(missing[:2] / missing[1:3] - 4.0) < 0.02)  # quadratic in the width


def test_torque_of_the_gas_is_its_work() -> None:
    late = GasExchange(4, BAR, 1.3 * BAR, BAR, deg(-140.0), deg(130.0))
    for found in (fired(-12.0, SHORT_ROD, late), fired(0.0, duration_deg=1e-3), fired(-12.0, SHORT_ROD)):
        assert found.torque_work_n_mm == pytest.approx(found.work_n_mm, rel=1e-9)


def test_pumping_is_the_rectangle_between_exhaust_and_intake() -> None:
    found = fired(-10.0, SHORT_ROD, GasExchange(4, BAR, 1.1 * BAR, BAR))
    assert found.pumping_work_n_mm == pytest.approx(-0.1 * BAR * SHORT_ROD.swept_mm3, rel=1e-12)
    assert found.work_n_mm == found.closed_work_n_mm + found.pumping_work_n_mm


def test_motored_is_an_adiabat_without_work() -> None:
    found = CylinderCycle.modelled(LONG_ROD, EVEN, CHARGE, None, None)
    assert found.peak[0] == pytest.approx(BAR * 10.0**1.4, rel=1e-12)
    assert found.peak[1] == pytest.approx(0.0, abs=1e-6)
    assert found.work_n_mm == pytest.approx(0.0, abs=1e-9 * BAR * FIRST_MM3)
    assert found.peak_temperature_k == pytest.approx(330.0 * 10.0**0.4, rel=1e-12)
    assert found.heat_n_mm is None


@pytest.mark.parametrize("exponent", [0.7, 1.0, 3.0])
def test_the_integral_is_what_a_solver_of_the_equation_finds(exponent: float) -> None:
    heat = Wiebe(deg(-15.0), deg(50.0), 5.0, exponent, HEAT)
    low, high = deg(-130.0), deg(125.0)
    found = CylinderCycle.modelled(SHORT_ROD, GasExchange(4, BAR, BAR, BAR, low, high), CHARGE, heat, None)

    def slope(angle: float, pressure: Array) -> Array:
        volume, change = SHORT_ROD.volume_and_slope(np.array(angle))
        burnt = 0.0 if angle <= heat.start_rad else float(heat.rate_n_mm(np.array(angle)))
        result: Array = (0.4 * burnt - 1.4 * pressure * change) / volume
        return result

    start = heat.start_rad + 1e-9 * (exponent < 1.0)
    up = solve_ivp(slope, (low, start), [BAR], method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    at = np.linspace(start, high - 1e-4, 40)
    run = solve_ivp(slope, (start, high), up, method="DOP853", t_eval=at, rtol=1e-11, atol=1e-12)
    solved = run.y[0]
    tolerance = 1e-9 if exponent >= 1.0 else 1e-4  # the solver leaves the steep start out
    np.testing.assert_allclose(found.pressure_mpa(at), solved, rtol=tolerance)


def test_pressure_by_stroke_and_after_each_jump() -> None:
    exchange = GasExchange(4, 0.09, 0.12, BAR, deg(-150.0), deg(140.0))
    found = fired(-10.0, exchange=exchange)
    at = np.radians([-360.0, -200.0, -150.0, 140.0, 250.0, 359.9, 360.0, 500.0])
    assert found.pressure_mpa(at).tolist()[:2] == [0.09, 0.09]
    assert found.pressure_mpa(at)[2] == pytest.approx(BAR)  # the charge's own pressure where it is shut in
    assert found.pressure_mpa(at).tolist()[3:] == [0.12, 0.12, 0.12, 0.09, 0.09]
    assert found.pressure_mpa(at + 4.0 * math.pi) == pytest.approx(found.pressure_mpa(at))


def test_two_strokes_repeat_each_turn() -> None:
    exchange = GasExchange(2, BAR, 9.9, BAR, deg(-120.0), deg(110.0))
    found = fired(-10.0, exchange=exchange)
    at = np.radians([110.0, 170.0, 239.9])
    assert found.pressure_mpa(at).tolist() == [BAR, BAR, BAR]
    turned = np.linspace(0.0, 6.0, 50)
    assert found.pressure_mpa(turned + 2.0 * math.pi) == pytest.approx(found.pressure_mpa(turned), rel=1e-9)
    assert found.torque_work_n_mm == pytest.approx(found.work_n_mm, rel=1e-9)


@pytest.mark.parametrize("strokes", [2, 4])
def test_an_offset_moves_the_dead_centres_that_are_the_defaults(strokes: Strokes) -> None:
    exchange = GasExchange(strokes, BAR, BAR, BAR)
    low, high = exchange.closed_ends_rad(SHORT_ROD)
    assert high - low == pytest.approx(2.0 * math.pi)
    ends = SHORT_ROD.volume_mm3(np.array([low, high, 0.0]))
    assert ends[:2] == pytest.approx(SHORT_ROD.swept_mm3 + SHORT_ROD.clearance_mm3)
    assert ends[2] == pytest.approx(SHORT_ROD.swept_mm3 / 9.0)
    found = fired(-10.0, SHORT_ROD, exchange)
    assert found.torque_work_n_mm == pytest.approx(found.work_n_mm, rel=1e-9)


def test_a_crankcase_gives_back_what_it_takes() -> None:
    case = GasExchange(2, BAR, BAR, BAR, deg(-120.0), deg(110.0), 3.0 * SHORT_ROD.swept_mm3)
    found, free = (
        fired(-10.0, SHORT_ROD, case),
        fired(-10.0, SHORT_ROD, GasExchange(2, BAR, BAR, BAR, deg(-120.0), deg(110.0))),
    )
    assert found.torque_work_n_mm == pytest.approx(free.torque_work_n_mm, rel=1e-9)
    volume = SHORT_ROD.volume_mm3(np.array([0.0, SHORT_ROD.bottom_after_top_rad]))
    assert found.below_mpa(volume).tolist() == pytest.approx([BAR, BAR * 1.5**1.4])


# --- wall heat and γ(T) -------------------------------------------------------------------------------------


def test_the_solved_part_without_walls_is_the_integral() -> None:
    heat = Wiebe(deg(-20.0), deg(40.0), 5.0, 3.0, HEAT)
    solved = SolvedPart.of(LONG_ROD, CHARGE, heat, (-math.pi, math.pi), None)
    exact = fired(-20.0)
    assert solved.work_n_mm == pytest.approx(exact.work_n_mm, rel=1e-8)
    at = np.linspace(-3.0, 3.0, 101)
    volume = LONG_ROD.volume_mm3(at)
    np.testing.assert_allclose(solved.pressure_mpa(at, volume), exact.pressure_mpa(at), rtol=1e-7)


def test_walls_take_heat_and_the_first_law_holds() -> None:
    heat = Wiebe(deg(-20.0), deg(40.0), 5.0, 3.0, HEAT)
    found = CylinderCycle.modelled(SHORT_ROD, EVEN, CHARGE, heat, Woschni(450.0, 300.0))
    assert found.part is not None
    ends = np.array(EVEN.closed_ends_rad(SHORT_ROD))
    volume = SHORT_ROD.volume_mm3(ends)
    inner = found.part.pressure_mpa(ends, volume) * volume / 0.4
    released = float(heat.released_n_mm(ends[1:])[0])
    taken = found.part.wall_heat_n_mm
    assert 0.05 * HEAT < taken < 0.4 * HEAT
    assert found.closed_work_n_mm == pytest.approx(released - taken - (inner[1] - inner[0]), rel=1e-8)
    assert found.torque_work_n_mm == pytest.approx(found.work_n_mm, rel=1e-8)
    faster = CylinderCycle.modelled(SHORT_ROD, EVEN, CHARGE, heat, Woschni(450.0, 900.0))
    assert faster.part is not None
    assert faster.part.wall_heat_n_mm < taken  # less time


def test_gamma_that_falls_with_temperature_lowers_peak_and_efficiency() -> None:
    heat = Wiebe(deg(-20.0), deg(40.0), 5.0, 3.0, HEAT)
    real = CylinderCycle.modelled(LONG_ROD, EVEN, Charge(BAR, 330.0, 1.4, -6e-5), heat, None)
    assert real.peak[0] < fired(-20.0).peak[0]
    assert 0.4 * HEAT < real.work_n_mm < fired(-20.0).work_n_mm
    assert real.torque_work_n_mm == pytest.approx(real.work_n_mm, rel=1e-8)


@pytest.mark.parametrize("walls", [None, Woschni(450.0, 300.0)], ids=["adiabatic", "woschni"])
def test_heat_is_work_and_what_the_gas_keeps(walls: Woschni | None) -> None:
    """First law to 1e-9: d(p V)/(γ − 1) with γ − 1 = a + b p V has a logarithm for integral."""
    heat, gamma_per_k = Wiebe(deg(-15.0), deg(50.0), 5.0, 3.0, HEAT), -7e-5
    solved = SolvedPart.of(SHORT_ROD, Charge(BAR, 330.0, 1.35, gamma_per_k), heat, (-math.pi, math.pi), walls)
    first, last = (float(solved.table[1][place]) for place in (0, -1))
    b = gamma_per_k * 330.0 / first
    a = 0.35 - gamma_per_k * 330.0
    kept = math.log((a + b * last) / (a + b * first)) / b
    released = float(heat.released_n_mm(np.array([math.pi]))[0])
    assert (solved.wall_heat_n_mm > 0.0) is (walls is not None)
    balance = released - solved.wall_heat_n_mm - solved.work_n_mm - kept
    assert abs(balance) < 1e-9 * released


def test_gas_below_absolute_zero_is_refused() -> None:
    gas = GasEquation(SHORT_ROD, CHARGE, None, -math.pi, Woschni(450.0, 300.0))
    with pytest.raises(ValueError, match="it must stay above 0 K"):
        gas.rates((0.0, 100.0, 1.0, 0.0, 1.0, 1.0), -1.0)


# --- refusals -----------------------------------------------------------------------------------------------


def test_impossible_cylinders_are_refused() -> None:
    with pytest.raises(ValueError, match="compression ratio is 1; must be > 1"):
        Chamber(SliderCrank(45.0, 140.0), 90.0, 1.0)
    with pytest.raises(ValueError, match="bore is 0 mm"):
        Chamber(SliderCrank(45.0, 140.0), 0.0, 10.0)
    with pytest.raises(ValueError, match="gamma is 1; must be > 1"):
        Charge(BAR, 330.0, 1.0)
    with pytest.raises(ValueError, match="intake pressure is -1 bar"):
        Charge(-BAR, 330.0, 1.4)
    with pytest.raises(ValueError, match="duration_rad of the heat release is 0"):
        Wiebe(0.0, 0.0, 5.0, 3.0, 1.0)
    with pytest.raises(ValueError, match="heat release starts at 170°; must be while the valves are shut"):
        fired(170.0, exchange=GasExchange(4, BAR, BAR, BAR, None, deg(140.0)))
    with pytest.raises(ValueError, match="longer than a cycle, 360°"):
        fired(0.0, exchange=GasExchange(2, BAR, BAR, BAR, deg(-180.0), deg(190.0)))
