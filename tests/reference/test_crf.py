"""The motocross crank of Hoem & Røsholm 2016: parts, factors, products and corrections."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.engines.forces.stroking import stroke_for_displacement_mm, stroked_crank
from autobalance.running_gear.loads import FirstOrder, centrifugal_force_n
from autobalance.running_gear.parts import (
    Parts,
    ThrowLoad,
    balance_factor,
    bob_weight_moments,
    correction_mass_g,
    counterweight_product_g_mm,
)
from autobalance.units import RAD_S_PER_RPM
from fixtures import make
from tests.reference.published import check, inputs

CRANK_RADIUS_MM = 26.9
CRANKPIN_G = 114.65


def summed(case: str) -> tuple[float, float]:
    """Rotating and reciprocating mass of the part list of a case [g]."""
    given = inputs(case)
    parts = Parts(
        rotating_g=given["be"] + given["bb"],
        reciprocating_g=sum(given[name] for name in ("se", "sb", "pis", "clips", "wp")),
        crankpin_g=given["pin"],
    )
    return parts.bob_weight_g(0.0), parts.reciprocating_on_throw_g


def factor_of(product_g_mm: float, rotating_g: float, reciprocating_g: float) -> float:
    """Balance factor of a single-throw crank whose counterweight has that product."""
    throw = ThrowLoad(Parts(rotating_g - CRANKPIN_G, reciprocating_g, CRANKPIN_G), CRANK_RADIUS_MM, 0.0, 0.0)
    unbalance = np.array([rotating_g * CRANK_RADIUS_MM - product_g_mm, 0.0])
    factor = balance_factor(unbalance, [throw])
    assert factor is not None
    return factor


@pytest.mark.parametrize("case", ["CRF-01", "CRF-02"])
def test_crf_01_02(case: str) -> None:
    rotating, reciprocating = summed(case)
    check(case, {"m_rot": rotating, "m_rec": reciprocating})


def test_crf_03() -> None:
    given = inputs("CRF-03")
    product = given["m_cw"] * given["rp"]

    def radius(rotating_g: float) -> float:
        weights = rotating_g - CRANKPIN_G, given["m_rec"]
        return counterweight_product_g_mm(*weights, 0.6375, CRANK_RADIUS_MM, CRANKPIN_G) / given["m_cw"]

    check(
        "CRF-03",
        {
            "fb": factor_of(product, given["m_rot"], given["m_rec"]),
            "fb_with_282.96": factor_of(product, 282.96, given["m_rec"]),
            "rp_for_0.6375": radius(given["m_rot"]),
            "rp_for_0.6375_282.96": radius(282.96),
            "mcw_rp": product,
            "mcw_rp_uncertainty": given["m_cw"] * 0.005,
        },
    )


def test_crf_04() -> None:
    given = inputs("CRF-04")
    check("CRF-04", {"fb": factor_of(given["m_cw"] * given["rp"], given["m_rot"], given["m_rec"])})


def test_crf_05() -> None:
    given = inputs("CRF-05")
    fitted = Parts(given["m_rot"] - given["pin"], given["m_rec"], given["pin"])
    on_machine = Parts(given["m_rot"] - given["pin"], given["m_rec"], 0.0)
    check(
        "CRF-05",
        {
            "bob_64_with_pin": fitted.bob_weight_g(0.6375),
            "bob_28_with_pin": fitted.bob_weight_g(0.28),
            "bob_64_on_machine": on_machine.bob_weight_g(0.6375),
            "bob_28_on_machine": on_machine.bob_weight_g(0.28),
        },
    )


def test_factor_of_a_crank_undoes_its_bob_weights() -> None:
    throws = [
        ThrowLoad(Parts(300.0, 250.0, 40.0, rods=2), 30.0, 0.4, -20.0),
        ThrowLoad(Parts(280.0, 260.0, 0.0), 31.0, 1.9, 25.0),
    ]
    unbalance = -bob_weight_moments(throws, 0.37).first_g_mm[:2]
    rotating = bob_weight_moments(throws, 0.0).first_g_mm[:2]
    assert balance_factor(unbalance + rotating, throws) == pytest.approx(0.37, rel=1e-12)


DENSITY_KG_M3 = 7850.0
COUNTERWEIGHTS = 2


@pytest.mark.parametrize(("case", "residual_g_mm"), [("CRF-06-0.6375", 8.01), ("CRF-06-0.28", 7.39)])
def test_crf_06(case: str, residual_g_mm: float) -> None:
    given = inputs(case)
    weights = given["m_rot"] - CRANKPIN_G, given["m_rec"]
    target = counterweight_product_g_mm(*weights, given["fb"], given["r"], CRANKPIN_G)
    unbalance = given["old"] - target
    mass = correction_mass_g(unbalance, given["r_corr"])

    def first_moment_mm3(unbalance_g_mm: float) -> float:
        return unbalance_g_mm / COUNTERWEIGHTS / (DENSITY_KG_M3 * 1e-6 * given["depth"])

    check(
        case,
        {
            "target": target,
            "U": unbalance,
            "m_corr": mass,
            "per_counterweight": mass / COUNTERWEIGHTS,
            "shoulder_area": first_moment_mm3(unbalance) / given["r_corr"],
            "Q": first_moment_mm3(unbalance),
            "Q_low": first_moment_mm3(unbalance - residual_g_mm),
            "Q_high": first_moment_mm3(unbalance + residual_g_mm),
        },
    )


def test_crf_07() -> None:
    given = inputs("CRF-07")

    def left(product_wanted_g_mm: float) -> float:
        wanted = ThrowLoad(Parts(0.0, 0.0, product_wanted_g_mm / CRANK_RADIUS_MM), CRANK_RADIUS_MM, 0.0, 0.0)
        return float(given["balanced"] - bob_weight_moments([wanted], 0.28).first_g_mm[0])

    check("CRF-07", {"residual": left(given["new"]), "as_printed": left(given["orig"])})


def test_crf_08() -> None:
    given = inputs("CRF-08")
    per_mm3 = COUNTERWEIGHTS * DENSITY_KG_M3 * 1e-6

    def one_shot_error_g_mm(growth_mm2: float, depth_mm: float) -> float:
        """Return what a pass misses that takes the shoulder for prismatic."""
        return 0.5 * per_mm3 * growth_mm2 * depth_mm**2

    errors = {name: one_shot_error_g_mm(given["Q1"], given[f"d{name}"]) for name in ("64", "28")}
    check(
        "CRF-08",
        {
            "err64": errors["64"],
            "err28": errors["28"],
            "Q1_max_for_1_pass": given["U"] / one_shot_error_g_mm(1.0, given["d64"]),
            "Q1_min_for_2_passes": given["U"] / one_shot_error_g_mm(1.0, given["d28"]),
            "y0_times_length_for_14deg": given["Q1"] / math.tan(make.DRAFT_RAD),
        },
    )
    assert errors["64"] < given["U"] < errors["28"]  # one pass and two, as printed

    size = make.drafted()
    full, step = float(make.drafted_shoulder(size)[1]), 1e-3
    growth = 2.0 * (full - float(make.drafted_shoulder(size, step)[1]) - make.SHOULDER_Q_MM3 * step) / step**2
    for name in ("64", "28"):
        depth = given[f"d{name}"]
        gone = full - float(make.drafted_shoulder(size, depth)[1])
        missed = per_mm3 * (gone - make.SHOULDER_Q_MM3 * depth)
        # The bundled shoulder's edge is a chord: its growth changes a little with the depth.
        assert missed == pytest.approx(one_shot_error_g_mm(growth, depth), rel=0.02)
        assert missed == pytest.approx(errors[name], rel=0.05)


def test_crf_09() -> None:
    size = make.straight()
    outer, inner = size.counterweight_radius, size.shoulder_inner_radius
    check(
        "CRF-09",
        {
            "A_shoulder": math.pi / 2.0 * (outer**2 - inner**2),
            "R": outer,
            "ri": inner,
            "Ru": size.web_radius,
            "tw": size.web_thickness,
            "ts": size.shoulder_height,
            "L_pin": size.pin_length,
            "id_pin": size.pin_bore,
            "L_journal_each": size.journal_length,
            "length_total": size.pin_length + 2.0 * size.journal_length,
            "m_journals": make.JOURNALS_MASS_G * 1e-3,
        },
    )


def test_crf_10() -> None:
    given = inputs("CRF-10")
    weights = given["m_rot"] - CRANKPIN_G, given["m_rec"]
    per_mm = COUNTERWEIGHTS * DENSITY_KG_M3 * 1e-6 * given["Q"]

    def target(factor: float) -> float:
        return counterweight_product_g_mm(*weights, factor, given["r"], CRANKPIN_G)

    check(
        "CRF-10",
        {
            "fb_after_0.948": factor_of(given["old"] - per_mm * 0.948, given["m_rot"], given["m_rec"]),
            "fb_after_2.807": factor_of(given["old"] - per_mm * 2.807, given["m_rot"], given["m_rec"]),
            "residual_64": given["old"] - per_mm * 0.948 - target(0.6375),
            "residual_28": given["old"] - per_mm * 2.807 - target(0.28),
            "depth_64": (given["old"] - target(0.6375)) / per_mm,
            "depth_28": (given["old"] - target(0.28)) / per_mm,
        },
    )


def test_crf_11() -> None:
    given = inputs("CRF-11")
    speed = given["n"] * RAD_S_PER_RPM
    product = given["m_rec"] * given["r"] * 1e6
    force = FirstOrder(centrifugal_force_n(product, speed), given["fb"])
    check(
        "CRF-11", {"F": float(-force.transverse_n(np.array(np.pi / 2))), "F_rec_primary": force.amplitude_n}
    )


def test_crf_12() -> None:
    given = inputs("CRF-12")
    width_mm = 16.0
    crank = stroked_crank(
        stroke_mm=given["S"],
        bore_mm=given["bore"],
        crankpin_mm=given["d0"],
        ground_crankpin_mm=given["d1"],
        crankpin_width_mm=width_mm,
        main_journal_mm=28.0,
        density_kg_m3=DENSITY_KG_M3,
        rotating_g=134.04,
        reciprocating_g=261.5,
        crankpin_g=CRANKPIN_G,
        factor=0.28,
    )
    check(
        "CRF-12",
        {
            "stroke_new": crank.stroke_mm,
            "V_new": crank.displacement_cm3,
            "stroke_for_297cc_same_bore": stroke_for_displacement_mm(297.0, given["bore"]),
            "pin_mass_change_per_mm_length": crank.crankpin_change_g / width_mm,
        },
    )
