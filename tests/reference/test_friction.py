"""Friction of the rotor bench's bearings, Petroff and squeeze film of the documents."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.engines.bearings.analysis import load_means
from autobalance.engines.bearings.dry import friction_moment_N_m, small_angle_moment_N_m, small_angle_mu
from autobalance.engines.bearings.fed_film import (
    damping_N_s_m,
    stiffness_N_m,
    uniform_pressure_damping_N_s_m,
)
from autobalance.engines.bearings.film import JournalBearing, petroff_moment_N_m
from autobalance.engines.bearings.film import friction_moment_N_m as oiled_moment_N_m
from autobalance.engines.bearings.loads import cubic_mean_load_N, equivalent_load_N, mean_load_N
from autobalance.running_gear.conrod import cylinder_mass_g
from autobalance.running_gear.loads import centrifugal_force_n
from autobalance.units import RAD_S_PER_RPM
from tests.reference.published import CASES, check, inputs

DENSITY_KG_M3 = 7850.0
GRAVITY_M_S2 = 9.81
HOLE_MM = 37.0
PRINTED_CELLS = [case for case in CASES if case.startswith("FR-02")]
SIMULATED_CELLS = [case for case in CASES if case.startswith("FR-04")]


def hole_mass_g(given: dict[str, float]) -> float:
    return cylinder_mass_g(given["dh"], HOLE_MM, DENSITY_KG_M3)


def hole_force_N(given: dict[str, float], radius_mm: float) -> float:
    return centrifugal_force_n(hole_mass_g(given) * radius_mm, given["n"] * RAD_S_PER_RPM)


def test_fm_01() -> None:
    x = np.linspace(1e-6, 1.0 - 1e-6, 401)
    apart = np.abs(equivalent_load_N(x, 1.0 - x) - cubic_mean_load_N(x, 1.0 - x))
    check(
        "FM-01",
        {
            "fm_half": load_means(0.5, 0.5).f_m or 0.0,
            "fm_0": load_means(0.0, 1.0).f_m or 0.0,
            "fm_1": load_means(1.0, 0.0).f_m or 0.0,
            "p3_half": float(cubic_mean_load_N(0.5, 0.5)),
            "max_abs_dev_from_cubic_mean": float(apart.max()),
            "p1_half": float(mean_load_N(0.5, 0.5)),
            "p2_half": math.hypot(0.5, 0.5),
        },
    )


def test_fr_01() -> None:
    given = inputs("FR-01")
    torques = {name: given[name] for name in ("T3", "T6", "T9")}
    printed = {"T3": 0.7773, "T6": 1.2771, "T9": 1.4718}
    bounds = [
        [2e3 * torque / (given["d"] * (printed[name] + off)) for name, torque in torques.items()]
        for off in (5e-5, -5e-5)
    ]
    mu = {f"mu{name[1]}": small_angle_mu(T, given["W"], given["d"] / 1e3) for name, T in torques.items()}
    solid_g = cylinder_mass_g(98.0, 36.704, DENSITY_KG_M3) + cylinder_mass_g(
        20.0, 188.0 - 36.704, DENSITY_KG_M3
    )
    check(
        "FR-01",
        {
            **mu,
            "W_low": max(bounds[0]),
            "W_high": min(bounds[1]),
            "m_at_9.81": given["W"] / GRAVITY_M_S2,
            "weight_of_Table_7.2_solid": solid_g / 1e3 * GRAVITY_M_S2,
        },
    )


@pytest.mark.parametrize("case", PRINTED_CELLS)
def test_fr_02(case: str) -> None:
    given = inputs(case)
    diameter = given["d"] / 1e3
    weight = given["W0"] - hole_mass_g(given) / 1e3 * GRAVITY_M_S2
    force = hole_force_N(given, given["r"])
    means = load_means(weight, force)
    undrilled = load_means(given["W0"], hole_force_N(given, 29.3))
    found = {
        "mu": small_angle_mu(given["T"], means.equivalent_N, diameter),
        "mu_if_r_29.3_W0": small_angle_mu(given["T"], undrilled.equivalent_N, diameter),
        "F_m": means.equivalent_N,
        "mu_mean_load": small_angle_mu(given["T"], means.mean_N, diameter),
    }
    if case == "FR-02-2-3000":
        printed = load_means(given["W0"], 42.2).equivalent_N
        found["mu_if_F_is_42.2_W0"] = small_angle_mu(given["T"], printed, diameter)
    check(case, found)


@pytest.mark.parametrize("case", SIMULATED_CELLS)
def test_fr_04(case: str) -> None:
    given = inputs(case)
    force = hole_force_N(given, given["r"]) if given["dh"] else 0.0
    means = load_means(given["W"], force)
    diameter = given["d"] / 1e3
    check(
        case,
        {
            "T_mean_load": float(small_angle_moment_N_m(means.mean_N, diameter, given["mu"])),
            "T_if_Fm_were_used": float(small_angle_moment_N_m(means.equivalent_N, diameter, given["mu"])),
        },
    )


def test_fr_05() -> None:
    given = inputs("FR-05")
    slow, fast = load_means(given["W"], given["F"]), load_means(given["W"], 380.0)
    check(
        "FR-05",
        {
            "ratio_minus_1_pct": 100.0 * (slow.equivalent_N / slow.mean_N - 1.0),
            "ratio_case2_9000_pct": 100.0 * (fast.equivalent_N / fast.mean_N - 1.0),
        },
    )


def test_fr_07() -> None:
    given = inputs("FR-07")
    exact = float(friction_moment_N_m(given["W"], given["d"] / 1e3, given["mu"]))
    small = float(small_angle_moment_N_m(given["W"], given["d"] / 1e3, given["mu"]))
    check("FR-07", {"T_small_angle": small, "T_exact": exact, "error_pct": 100.0 * (small / exact - 1.0)})


def test_fr_08() -> None:
    given = inputs("FR-08")
    bearing = JournalBearing(given["D"], given["L"], given["c"])
    viscosity, speed = given["mu"], 2.0 * math.pi * given["N"]
    check(
        "FR-08",
        {
            "T_concentric": oiled_moment_N_m(bearing, viscosity, speed),
            "T_petroff_direct": petroff_moment_N_m(bearing, viscosity, speed),
            "T_ecc_0.6": oiled_moment_N_m(bearing, viscosity, speed, 0.6, 500.0, math.radians(50.0)),
            "error_factor_if_rad_per_s": speed / given["N"],
        },
    )


def test_fr_09() -> None:
    given = inputs("FR-09")
    viscosity, length, width, film = (given[name] for name in ("eta", "L", "Z", "H"))
    square = uniform_pressure_damping_N_s_m(viscosity, length, width, film)
    strip = viscosity, 100.0 * width, width, film
    check(
        "FR-09",
        {
            "C_doc": square,
            "C_reynolds": damping_N_s_m(viscosity, length, width, film),
            "ratio_square": square / damping_N_s_m(viscosity, length, width, film),
            "ratio_strip_L=100Z": uniform_pressure_damping_N_s_m(*strip) / damping_N_s_m(*strip),
        },
    )


def test_fr_10() -> None:
    given = inputs("FR-10")
    check("FR-10", {"k": stiffness_N_m(given["W"], given["H"])})
