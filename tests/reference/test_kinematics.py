"""Kinematics, series and balance factor of the three documents."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalance.running_gear.conrod import ConnectingRod
from autobalance.running_gear.loads import FirstOrder, centrifugal_force_n
from autobalance.running_gear.shafts import BalanceShaft
from autobalance.running_gear.slider_crank import (
    SliderCrank,
    greatest_speed_angle_of_two_harmonics_rad,
    harmonic_coefficient,
    harmonic_series,
    swept_volume_cm3,
)
from autobalance.types import Array
from autobalance.units import RAD_S_PER_RPM
from tests.reference.published import check, inputs


def spectrum(crank: SliderCrank) -> Array:
    """Acceleration harmonics over r ω² from a transform of the exact acceleration (not of the position)."""
    angle = 2.0 * math.pi * np.arange(4096) / 4096
    result: Array = np.abs(np.fft.rfft(crank.motion(angle).ddx_mm)) / 2048 / crank.crank_radius_mm
    return result


def test_kin_01() -> None:
    given = inputs("KIN-01")
    crank = SliderCrank(given["r"], given["l"])
    quarter = float(crank.position_mm(np.array(math.pi / 2)))
    check("KIN-01", {"t": float(crank.position_mm(np.array(0.0))) - quarter, "h": given["r"] + quarter})


def test_kin_02() -> None:
    ratio = inputs("KIN-02")["lam"]
    transformed = spectrum(SliderCrank(ratio, 1.0))
    computed = {f"A{order}": harmonic_coefficient(order, ratio) for order in (2, 4, 6, 8)}
    for order in (2, 4, 6, 8):
        difference = float(transformed[order]) - harmonic_coefficient(order, ratio)
        assert abs(difference) < 1e-10
        computed[f"A{order}_fft_minus_series"] = round(difference, 11)
    check("KIN-02", computed)


def coefficients(order: int, terms: int) -> dict[int, float]:
    """Power of λ → coefficient of an even order."""
    return {term.power: term.coefficient for term in harmonic_series(order, terms)}


def test_kin_03() -> None:
    second, fourth = coefficients(2, 5), coefficients(4, 4)
    sixth = coefficients(6, 1)[5]
    check(
        "KIN-03",
        {
            "A2_l3": second[3],
            "A2_l5": second[5],
            "A4_l3": fourth[3],
            "A4_l5": fourth[5],
            "A6_l5": sixth,
            "A6_l5_Ruckle": sixth,
            "A8_l7": coefficients(8, 1)[7],
        },
    )


def test_kin_04() -> None:
    given = inputs("KIN-04")
    ratio, angle = given["lam"], given["theta"]
    # The acceleration's harmonic is order² times the position's; the constant keeps the dead centre right.
    orders = {2: (1, 3), 4: (3, 2), 6: (5, 1)}  # order: first power, terms up to λ⁵
    cosines = {
        order: (-1) ** (order // 2 + 1)
        * sum(term.coefficient * ratio**term.power for term in harmonic_series(order, terms))
        / order**2
        for order, (_, terms) in orders.items()
    }
    constant = 1.0 / ratio - sum(cosines.values())  # x/r = 1/λ + 1 at θ = 0
    series = constant + math.cos(angle) + sum(c * math.cos(o * angle) for o, c in cosines.items())
    exact = float(SliderCrank(ratio, 1.0).position_mm(np.array(angle))) / ratio
    check("KIN-04", {"series": series, "exact": exact, "difference": series - exact})


def test_kin_05() -> None:
    ratio = inputs("KIN-05")["lam"]
    top, bottom = -SliderCrank(ratio, 1.0).motion(np.array([0.0, math.pi])).ddx_mm / ratio
    check("KIN-05", {"TDC": float(top), "BDC": float(bottom), "A2_exact": harmonic_coefficient(2, ratio)})


def test_kin_06() -> None:
    ratio = inputs("KIN-06")["lam"]
    check(
        "KIN-06",
        {
            "exact": math.degrees(SliderCrank(ratio, 1.0).greatest_speed_angles_rad[0]),
            "two_harmonic": math.degrees(greatest_speed_angle_of_two_harmonics_rad(ratio)),
        },
    )


@pytest.mark.parametrize(
    ("rod_over_stroke", "degrees"), [(1.5, 73.18), (1.75, 75.14), (2.0, 76.72), (2.5, 79.10)]
)
def test_kin_06_other_rods(rod_over_stroke: float, degrees: float) -> None:
    down, up = SliderCrank(0.5, rod_over_stroke).greatest_speed_angles_rad
    assert math.degrees(down) == pytest.approx(degrees, abs=0.005)
    assert down + up == pytest.approx(2.0 * math.pi)


def test_kin_07() -> None:
    given = inputs("KIN-07")
    check("KIN-07", {"lam": SliderCrank(given["r"], given["l"]).ratio})


def test_kin_08() -> None:
    given = inputs("KIN-08")
    crank = SliderCrank(given["r"], given["l"], given["e"])
    top, bottom = crank.dead_centres_rad
    harmonics = np.abs(crank.harmonics(3))
    np.testing.assert_allclose(harmonics, spectrum(crank)[:4], atol=1e-10)
    check(
        "KIN-08",
        {
            "stroke": crank.stroke_mm,
            "tdc": math.degrees(top),
            "bdc": math.degrees(bottom),
            "h1": float(harmonics[1]),
            "h2": float(harmonics[2]),
            "h3": float(harmonics[3]),
        },
    )


def test_kin_09() -> None:
    given = inputs("KIN-09")
    check("KIN-09", {"V": swept_volume_cm3(given["bore"], given["stroke"]), "r": given["stroke"] / 2})


def test_bf_01() -> None:
    given = inputs("BF-01")
    speed = given["n"] * RAD_S_PER_RPM
    product = given["m"] * given["r"] * 1e6
    secondary = centrifugal_force_n(given["lam"] * product, speed)
    at_double_speed = BalanceShaft(2, True, given["lam"] * product / 4, 0.0).force_n(np.array(0.0), speed)
    check(
        "BF-01",
        {
            "primary": centrifugal_force_n(product, speed),
            "secondary": secondary,
            "difference": round(float(at_double_speed[0]) - secondary, 9),
        },
    )


def resultant_n(force: FirstOrder, angle_rad: float) -> float:
    angle = np.array(angle_rad)
    return float(np.hypot(force.inline_n(angle), force.transverse_n(angle)))


@pytest.mark.parametrize("factor", ["0", "0.28", "0.5", "0.6375", "0.64", "1"])
def test_bf_02(factor: str) -> None:
    force = FirstOrder(1.0, float(factor))
    check(
        f"BF-02-{factor}",
        {
            "max": force.greatest_n,
            "min": force.least_n,
            "mean": force.mean_n,
            "rms": force.rms_n,
            "at_0deg": resultant_n(force, 0.0),
            "at_90deg": round(resultant_n(force, math.pi / 2), 15),
            "backward_circle": force.backward_n,
            "forward_circle": force.forward_n,
        },
    )


def test_bf_03() -> None:
    given = inputs("BF-03")
    rod = ConnectingRod(given["m"] * 1e3, given["a"] + given["b"], given["a"])
    check(
        "BF-03",
        {
            "m_a": rod.big_end_g * 1e-3,
            "m_b": rod.small_end_g * 1e-3,
            "I_lumped": rod.two_mass_inertia_g_mm2 * 1e-3,
        },
    )
