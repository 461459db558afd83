"""The motocross crank of Hoem & Røsholm 2016: parts, factors, products and corrections."""

from __future__ import annotations

import numpy as np
import pytest

from autobalance.engine.balance_factor import (
    balance_factor,
    bob_weight_moments,
    counterweight_product_target_g_mm,
)
from autobalance.engine.parts import Parts, ThrowLoad
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
        parts = Parts(rotating_g - CRANKPIN_G, given["m_rec"], CRANKPIN_G)
        return counterweight_product_target_g_mm(parts, 0.6375, CRANK_RADIUS_MM) / given["m_cw"]

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
