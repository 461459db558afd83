"""The documented formulas by their names; every reference case that one of them can tell."""

import json
import math
from typing import Any

import pytest

import autobalance as ab
from autobalance.formulas.calc import call, names
from tests import jobs
from tests.reference.published import CASES, EXACT, inputs


def calculated(capsys: pytest.CaptureFixture[str], name: str, **values: object) -> Any:
    texts = [
        f"{key}={','.join(map(repr, value)) if isinstance(value, list) else value}"
        for key, value in values.items()
    ]
    assert jobs.run("calc", name, *texts, "--json", "-") == 0
    return json.loads(capsys.readouterr().out)["result"]


def value(case: str, name: str) -> float:
    return float(CASES[case]["values"][name]["value"])


def test_every_formula_is_listed_and_has_its_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("calc", "--list") == 0
    listed = capsys.readouterr().out
    for name in names():
        assert f"\n{name} " in f"\n{listed}"
        assert jobs.run("calc", name, "--help") == 0
        told = capsys.readouterr().out
        assert f"autobalance calc {name}" in told
        assert "References" in told
        assert getattr(ab.theory, name) is not None


def test_kinematics(capsys: pytest.CaptureFixture[str]) -> None:
    found = calculated(capsys, "dead_centres", crank_radius_mm=44.9, rod_length_mm=152.0, offset_mm=10.0)
    assert found["stroke_mm"] == pytest.approx(90.014, abs=5e-4)
    speed = calculated(capsys, "greatest_piston_speed", crank_radius_mm=1.0, rod_length_mm=4.0)
    assert speed["two_harmonics_deg"] == pytest.approx(77.01, abs=5e-3)
    crank = {"crank_radius_mm": 30, "rod_length_mm": 120, "speed_rpm": 9000}
    motion = calculated(capsys, "piston_motion", **crank, angle_deg=30)
    ahead, behind = (
        calculated(capsys, "piston_motion", **crank, angle_deg=30 + off) for off in (1e-3, -1e-3)
    )
    seconds = math.radians(2e-3) / (9000 * math.pi / 30.0)
    assert (ahead["position_mm"] - behind["position_mm"]) / seconds / 1e3 == pytest.approx(
        motion["velocity_m_s"], rel=1e-7
    )
    assert (ahead["velocity_m_s"] - behind["velocity_m_s"]) / seconds == pytest.approx(
        motion["acceleration_m_s2"], rel=1e-7
    )
    assert math.sin(math.radians(motion["rod_angle_deg"])) == pytest.approx(0.125, rel=1e-12)


def test_weights_and_factors(capsys: pytest.CaptureFixture[str]) -> None:
    given = inputs("CRF-05")
    weights = {"rotating_g": given["m_rot"] - given["pin"], "reciprocating_g": given["m_rec"]}
    with_pin = calculated(capsys, "bob_weight_g", **weights, factor=0.28, crankpin_g=given["pin"])
    assert with_pin == pytest.approx(value("CRF-05", "bob_28_with_pin"), rel=EXACT)
    rods = inputs("RU-09")
    rod = calculated(
        capsys, "conrod_on_scales", big_end_g=rods["sc_b"], small_end_g=rods["sc_s"], length_mm=152.0
    )
    assert rod["mass_g"] == pytest.approx(value("RU-09", "scale_total"), rel=EXACT)
    cut = calculated(
        capsys,
        "conrod_cut_in_two",
        big_end_g=rods["sc_b"],
        small_end_g=rods["sc_s"],
        big_half_g=rods["cad_b"],
        small_half_g=rods["cad_s"],
    )
    assert cut["moved_g"] == pytest.approx(value("RU-09", "mass_moved"), rel=EXACT)
    crf = inputs("CRF-04")
    factor = calculated(
        capsys,
        "balance_factor",
        counterweight_product_g_mm=crf["m_cw"] * crf["rp"],
        rotating_g=crf["m_rot"],
        reciprocating_g=crf["m_rec"],
        crank_radius_mm=26.9,
    )
    assert factor == pytest.approx(value("CRF-04", "fb"), rel=EXACT)
    orders = inputs("RU-01-standard")
    table = calculated(
        capsys,
        "order_table",
        reciprocating_g=orders["m"],
        crank_radius_mm=orders["r"],
        rod_length_mm=orders["l"],
    )
    assert abs(table[1]["exact_g_mm"]) == pytest.approx(value("RU-01-standard", "o2_exact"), rel=EXACT)


def test_sections_and_shafts(capsys: pytest.CaptureFixture[str]) -> None:
    fan = inputs("RU-16")
    sizes = {
        "outer_radius_mm": fan["R"],
        "inner_radius_mm": fan["ri"],
        "fan_angle_deg": fan["al"],
        "thickness_mm": fan["T"],
    }
    found = calculated(capsys, "fan_counterweight", **sizes)
    assert found["product_g_mm"] * 1e-3 == pytest.approx(value("RU-16", "U"), rel=EXACT)
    assert found["sensitivity_radius"] == pytest.approx(value("RU-16", "elasticity_R"), rel=EXACT)
    wider = calculated(
        capsys,
        "fan_counterweight_for",
        product_g_mm=1.05 * found["product_g_mm"],
        change="fan_angle",
        **sizes,
    )
    assert wider["product_g_mm"] == pytest.approx(1.05 * found["product_g_mm"], rel=1e-12)
    pair = calculated(capsys, "shaft_pair", order=2, amplitude_g_mm=inputs("RU-06")["need"])
    assert pair["product_each_g_mm"] == pytest.approx(value("RU-06", "correct_per_shaft"), rel=EXACT)
    one = calculated(
        capsys,
        "substitute_rotor",
        polar_inertia_kg_mm2=2847.335,
        disc_mm=98.0,
        shaft_mm=20.0,
        length_mm=188.0,
    )
    back = calculated(
        capsys,
        "disc_rotor",
        disc_mm=98.0,
        shaft_mm=20.0,
        length_mm=188.0,
        thickness_mm=one["thickness_mm"],
    )
    assert back["polar_inertia_kg_mm2"] == pytest.approx(2847.335, rel=1e-12)
    hole = calculated(capsys, "drilled_hole", diameter_mm=8.0, depth_mm=37.0, radius_mm=29.3, speed_rpm=9000)
    assert hole["force_N"] == pytest.approx(379.97, abs=5e-3)
    sums = calculated(
        capsys, "section_sums", mass_g=[2.0, 1.0], x_mm=[0.0, 0.0], y_mm=[5.0, -10.0], z_mm=[10.0, 30.0]
    )
    assert sums["dynamic_g_mm2"] == [0.0, -200.0]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "needs the name of a formula"),
        (("crankpin_overlap",), "did you mean 'crankpin_overlap_mm'?"),
        (("swept_volume_cm3", "bore_mm=76.8"), "stroke_mm missing"),
        (("swept_volume_cm3", "bore=76.8"), "has no 'bore'; its keys are bore_mm, stroke_mm"),
        (("swept_volume_cm3", "bore_mm=wide", "stroke_mm=1"), "must be a number"),
        (("swept_volume_cm3", "bore_mm=nan", "stroke_mm=1"), "must be a finite number"),
        (("swept_volume_cm3", "76.8"), "is not key=value"),
        (("shaft_pair", "order=1.5", "amplitude_g_mm=1"), "must be a whole number"),
        (("correction_mass_g", "unbalance_g_mm=1", "radius_mm=0"), "must be > 0"),
        (("piston_motion", "crank_radius_mm=9", "rod_length_mm=3", "angle_deg=0"), "rod length is 3 mm"),
        (
            ("achieved_grade", "residual_g_mm=1e300", "rotor_mass_g=1e-300", "speed_rpm=1"),
            "result is infinite",
        ),
        (("convert_unbalance", "value=1", "unit=lb"), "the unit 'lb' is not known"),
    ],
)
def test_wrong_use_is_one_line(words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("calc", *words) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_result_is_never_nan() -> None:
    assert call("stroke_for_displacement_mm", {"displacement_cm3": "297", "bore_mm": "76.8"}) > 64.0
