"""Published figures on holes, counterweights and what is left for the last holes."""

import math

import numpy as np
import pytest

from autobalance.correction.holes.hole import drill_body
from autobalance.rigid_rotor.tolerance import permissible_unbalance_g_mm
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.solid import Solid
from autobalance.units import G_MM_PER_OZ_IN, RAD_S_PER_RPM

STEEL = 7.85e-3


def force_n(unbalance_g_mm: float, speed_rpm: float) -> float:
    return unbalance_g_mm * 1e-6 * (speed_rpm * RAD_S_PER_RPM) ** 2


def drilled_g_mm(diameter_mm: float) -> float:
    """Unbalance of a hole through the 37 mm disc of the rig at 29.3 mm."""
    disc = Solid.box(np.array([-60.0, -60.0, 0.0]), np.array([60.0, 60.0, 37.0]))
    at = np.eye(4)
    at[0, 3] = 29.3
    hole = drill_body(0.5 * diameter_mm, -1.0, 38.0, 0.0).moved(at)
    return float((disc.moments(STEEL) - (disc - hole).moments(STEEL)).first_g_mm[0])


def test_unb_5_load_step_between_two_holes() -> None:
    """Hoem & Røsholm 2016, 5.2.4: 737.7 N from the 16 mm to the 19.5 mm hole at 9000 rpm."""
    step = force_n(drilled_g_mm(19.5) - drilled_g_mm(16.0), 9000.0)
    assert step == pytest.approx(737.68, abs=0.02)  # the two printed forces, rounded to 0.01 N each


def test_ru_08_crank_without_its_top_counterweight() -> None:
    """Ruckle 2014, Table 3: two counterweights and two webs; 223.28 kg·mm for the pair."""
    one = Moments.point(5751.6, np.array([18.7, 0.0, 40.0])) + Moments.point(
        230.9, np.array([17.7, 0.0, 40.0])
    )
    mirrored = one.moved(np.diag([-1.0, 1.0, -1.0, 1.0])).moved(np.diag([-1.0, -1.0, 1.0, 1.0]))
    assert (one + mirrored).first_g_mm[0] == pytest.approx(223283.7, rel=1e-12)


def test_iso_04_overbalance_allowance() -> None:
    """Ruckle 2014, 3.1.1: 1500 to 2000 g·mm left for drilling, some 140 times the permissible value."""
    assert pytest.approx(2.08310798915, rel=1e-9) == 1500.0 / G_MM_PER_OZ_IN
    assert pytest.approx(2.77747731886, rel=1e-9) == 2000.0 / G_MM_PER_OZ_IN
    permissible = permissible_unbalance_g_mm(2700.0, 6.3, 15200.0 * RAD_S_PER_RPM)
    assert 1500.0 / permissible == pytest.approx(140.365103864, rel=1e-9)


def test_holes_of_one_depth_grow_with_the_square_of_their_diameter() -> None:
    assert drilled_g_mm(19.5) / drilled_g_mm(8.0) == pytest.approx((19.5 / 8.0) ** 2, rel=1e-8)
    assert drilled_g_mm(8.0) == pytest.approx(STEEL * math.pi * 16.0 * 37.0 * 29.3, rel=1e-6)
