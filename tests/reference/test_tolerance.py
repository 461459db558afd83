"""Permissible unbalance, units, overlap, substitute rotor and drilled holes of the documents."""

from __future__ import annotations

import pytest

from autobalance.engines.forces.stroking import MidspanDisc, crankpin_overlap_mm, disc_rotor, substitute_rotor
from autobalance.rigid_rotor.tolerance import (
    achieved_grade_mm_s,
    permissible_unbalance_g_mm,
    share_between_planes,
    specific_unbalance_mm,
)
from autobalance.running_gear.conrod import cylinder_mass_g
from autobalance.running_gear.loads import centrifugal_force_n
from autobalance.running_gear.parts import correction_mass_g
from autobalance.units import G_MM_PER, RAD_S_PER_RPM
from tests.reference.published import CASES, check, inputs

DENSITY_KG_M3 = 7850.0
UNBALANCED_HOLES = ["UNB-2", "UNB-3", "UNB-4"]


def test_iso_01() -> None:
    given = inputs("ISO-01")
    speed = given["n"] * RAD_S_PER_RPM
    permissible = permissible_unbalance_g_mm(given["m"] * 1e3, given["G"], speed)
    a, b = share_between_planes(permissible, 0.0, -40.0, 40.0)
    assert a == b
    check(
        "ISO-01",
        {
            "U_per": permissible,
            "omega": speed,
            "e_per": specific_unbalance_mm(given["G"], speed) * 1e3,
            "per_plane_symmetric": a,
        },
    )


def test_iso_02() -> None:
    given = inputs("ISO-02")
    speed = given["n"] * RAD_S_PER_RPM
    one_factor = given["m_rec"] * given["r"]
    check(
        "ISO-02",
        {
            "G_28": achieved_grade_mm_s(given["u28"], given["m"], speed),
            "G_64": achieved_grade_mm_s(given["u64"], given["m"], speed),
            "dfb_28": given["u28"] / one_factor,
            "dfb_64": given["u64"] / one_factor,
            "m_at_24mm": correction_mass_g(given["u28"], 24.0),
        },
    )


def test_iso_03() -> None:
    unit = G_MM_PER["oz·in"]
    check(
        "ISO-03",
        {
            "stock_2ozin": 2.0 * unit,
            "street_0.5ozin": 0.5 * unit,
            "race_0.2ozin": 0.2 * unit,
            "stock_in_ozin": 1439.0 / unit,
            "street_in_ozin": 359.0 / unit,
            "race_in_ozin": 143.0 / unit,
            "with_28.33g_per_oz": 2.0 * 28.33 * 25.4,
        },
    )


def test_iso_04() -> None:
    low, high = 1.5 * G_MM_PER["kg·mm"], 2.0 * G_MM_PER["kg·mm"]
    permissible = permissible_unbalance_g_mm(2700.0, 6.3, 15200 * RAD_S_PER_RPM)
    unit = G_MM_PER["oz·in"]
    check("ISO-04", {"low": low / unit, "high": high / unit, "in_U_per_CRF": low / permissible})


def test_cpo_01() -> None:
    given = inputs("CPO-01")
    check("CPO-01", {"CPO": crankpin_overlap_mm(given["dm"], given["dp"], given["S"])})
    assert crankpin_overlap_mm(28.0, 28.0, 64.1) < 0.0  # no overlap is no error


def test_rot_01() -> None:
    given = inputs("ROT-01")

    def rotor(disc_mm: float) -> MidspanDisc:
        return substitute_rotor(given["I"], disc_mm, given["d2"], given["L1"], DENSITY_KG_M3)

    printed = disc_rotor(98.0, given["d2"], given["L1"], 36.704, DENSITY_KG_M3)
    check(
        "ROT-01",
        {
            "t_98": rotor(98.0).thickness_mm,
            "t_100": rotor(100.0).thickness_mm,
            "L2_from_printed_t": printed.shaft_each_side_mm,
            "L2_98": rotor(98.0).shaft_each_side_mm,
        },
    )


def test_rot_02() -> None:
    given = inputs("ROT-02")
    wanted = 2847.335
    built = disc_rotor(given["d1"], given["d2"], given["L1"], given["t"], DENSITY_KG_M3)
    larger = disc_rotor(100.0, given["d2"], given["L1"], given["t"], DENSITY_KG_M3)
    right = substitute_rotor(wanted, given["d1"], given["d2"], given["L1"], DENSITY_KG_M3)
    check(
        "ROT-02",
        {
            "I": built.polar_inertia_kg_mm2,
            "I_deficit_pct": 100.0 * (built.polar_inertia_kg_mm2 / wanted - 1.0),
            "mass": built.mass_g * 1e-3,
            "weight_9.81": built.mass_g * 1e-3 * 9.81,
            "I_100": larger.polar_inertia_kg_mm2,
            "mass_100": larger.mass_g * 1e-3,
            "I_98_right_t": right.polar_inertia_kg_mm2,
            "mass_98_right_t": right.mass_g * 1e-3,
        },
    )


def hole_force_n(diameter_mm: float, length_mm: float, radius_mm: float, rpm: float) -> float:
    """Rotating force of the metal that a drilled hole lacks."""
    mass = cylinder_mass_g(diameter_mm, length_mm, DENSITY_KG_M3)
    return centrifugal_force_n(mass * radius_mm, rpm * RAD_S_PER_RPM)


@pytest.mark.parametrize("case", UNBALANCED_HOLES)
def test_unb_2_3_4(case: str) -> None:
    given = inputs(case)
    d, t, r = given["d"], given["t"], given["r"]
    check(
        case,
        {
            "m_u": cylinder_mass_g(d, t, DENSITY_KG_M3),
            "F3000": hole_force_n(d, t, r, 3000.0),
            "F6000": hole_force_n(d, t, r, 6000.0),
            "F9000": hole_force_n(d, t, r, 9000.0),
            "F9000_r29.6": hole_force_n(d, t, 29.6, 9000.0),
            "m_u_t36.704": cylinder_mass_g(d, 36.704, DENSITY_KG_M3),
            "F9000_t36.704_r29.6": hole_force_n(d, 36.704, 29.6, 9000.0),
        },
    )


def test_unb_5() -> None:
    given = inputs("UNB-5")
    check("UNB-5", {"dF": given["a"] - given["b"]})
    step = hole_force_n(19.5, 37.0, 29.3, 9000.0) - hole_force_n(16.0, 37.0, 29.3, 9000.0)
    assert step == pytest.approx(CASES["UNB-5"]["values"]["dF"]["printed"], abs=0.05)
