"""Suggestions: each closed form near what was tried, each trial what was wanted, in drawing and metal."""

import math
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

import autobalance as ab
from autobalance.command import main
from autobalance.drawn_cranks.design import PRESETS
from autobalance.drawn_cranks.generate import crank_solid
from autobalance.drawn_cranks.input import with_settings
from autobalance.drawn_cranks.suggested_sizes import largest_bob_weight_g, radius_for_bob_weights_mm
from autobalance.drawn_cranks.truth import crank_anatomy
from autobalance.errors import JobError
from autobalance.rigid_rotor.unbalance import Moments
from autobalance.solid.csg.region import Region
from autobalance.solid.csg.solid import Solid

ENGINE = {"stroke_mm": 58.0, "rotating_g": {"rod": 250.0}, "reciprocating_g": {"piston": 262.0}}
SINGLE = {"preset": "single", "engine": ENGINE, "segments": 32}
FACTOR, SHARE = 1e-3, 1e-4  # what counts as reached


@pytest.fixture(scope="module")
def to_half() -> dict[str, Any]:
    found: dict[str, Any] = ab.generate(SINGLE, suggest={"balance_factor": 0.5}).report
    return found


def of_kind(report: dict[str, Any], kind: str) -> dict[str, Any]:
    found: dict[str, Any] = next(each for each in report["suggestions"]["found"] if each["kind"] == kind)
    return found


def test_the_sizes_suggested_make_the_factor_wanted(to_half: dict[str, Any]) -> None:
    for kind in ("counterweight_radius", "counterweight_thickness", "counterweight_fan_angle"):
        (change,) = of_kind(to_half, kind)["changes"]
        built = ab.generate(SINGLE, settings={change["key"]: change["to"]}).report
        assert built["engine"]["balance_factor"] == pytest.approx(0.5, abs=FACTOR)
        # the closed form knows neither draft nor the web's flanks
        assert change["closed_form"] - change["from"] == pytest.approx(
            change["to"] - change["from"], rel=0.05
        )


def test_the_weight_suggested_is_mass_times_radius(to_half: dict[str, Any]) -> None:
    bores = of_kind(to_half, "weight")["bores"]
    product = sum(bore["mass_g"] * bore["radius_mm"] for bore in bores)
    wanted = (0.5 - to_half["suggestions"]["now"]["balance_factor"]) * 262.0 * 29.0
    assert product == pytest.approx(wanted, rel=2e-3)
    assert {bore["web"] for bore in bores} == {1, 2}
    assert all(bore["angle_deg"] == pytest.approx(180.0) for bore in bores)


def test_a_report_with_suggestions_keeps_to_its_schema(to_half: dict[str, Any]) -> None:
    Draft202012Validator(ab.schema("generate")).validate(to_half)


def test_the_hole_suggested_takes_from_the_solid_what_it_says() -> None:
    report = ab.generate(SINGLE, suggest={"balance_factor": 0.2}).report
    bores = of_kind(report, "hole")["bores"]
    solid = crank_solid(PRESETS["single"], 32)
    rotor_z = report["frame"]["file_to_rotor"][2][3]
    for bore in bores:
        assert bore["depth_mm"] == pytest.approx(bore["closed_form_depth_mm"], rel=1e-3)
        x, y = (bore["radius_mm"] * f(math.radians(bore["angle_deg"])) for f in (math.cos, math.sin))
        inwards = math.copysign(bore["depth_mm"], -bore["z_mm"])
        low, high = sorted(z - rotor_z for z in (bore["z_mm"], bore["z_mm"] + inwards))
        tool = Solid.prism(Region.circle(0.5 * bore["diameter_mm"], 256, (x, y)), low, high)
        assert (solid & tool).volume_mm3 * 7.85e-3 == pytest.approx(bore["mass_g"], rel=1e-3)


def test_factor_and_inertia_are_met_together() -> None:
    report = ab.generate(SINGLE, suggest={"balance_factor": 0.45, "inertia_kg_mm2": 1710.0}).report
    found = report["suggestions"]["found"]
    assert {each["kind"] for each in found} >= {"counterweight_radius_and_counterweight_thickness", "weight"}
    for each in found:
        assert each["reached"]
        assert each["leaves"]["balance_factor"] == pytest.approx(0.45, abs=FACTOR)
        assert each["leaves"]["inertia_kg_mm2"] == pytest.approx(1710.0, rel=SHARE)


def test_an_inertia_alone_keeps_the_unbalance() -> None:
    crank = ab.generate("pressed-up-single", segments=32).crank
    report = ab.inspect(crank, suggest={"inertia_kg_mm2": 2500.0}).report
    whole = ab.schema("report")
    part = {"$ref": "#/$defs/suggestions", "$defs": whole["$defs"]}
    Draft202012Validator(part).validate(report["suggestions"])
    hole = of_kind(report, "hole")["leaves"]
    assert hole["inertia_kg_mm2"] == pytest.approx(2500.0, rel=SHARE)
    before = report["suggestions"]["now"]["unbalance_g_mm"]
    assert hole["unbalance_g_mm"] == pytest.approx(before, abs=1e-3 * abs(before[0]))
    assert {each["kind"] for each in report["suggestions"]["refused"]} == {"weight", "rim"}


def test_a_job_is_told_how_to_reach_its_factor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ab.generate(SINGLE, file="single.stl").write(tmp_path, only=("stl",))
    (tmp_path / "job.toml").write_text(
        '[crankshaft]\nfile = "single.stl"\nunit = "mm"\ndensity_kg_m3 = 7850.0\n'
        "[engine]\nrotating_g = { rod = 250.0 }\nreciprocating_g = { piston = 262.0 }\n"
        '[balance]\nfactor = 0.25\ngrade = 6.3\nspeed_rpm = 9000\n[correction]\nmethod = "shoulder"\n'
    )
    assert main(["inspect", str(tmp_path / "job.toml"), "--suggest"]) == 0
    said = capsys.readouterr().out
    assert "For balance factor 25.00 %" in said
    assert "bore" in said
    assert "counterweights turned to" in said


@pytest.mark.parametrize(
    ("design", "wanted", "message"),
    [
        ("single", {"balance_factor": 0.5}, "needs the weights"),
        ({"preset": "inline-4", "engine": {**ENGINE, "stroke_mm": 86.0}}, {"balance_factor": 0.5}, "cancel"),
        ("single", {"factor": 0.5}, "suggest has no 'factor'"),
        ("single", {"inertia_kg_mm2": True}, "must be a number"),
        ("single", {"balance_factor": 1.5}, "0 to 1"),
        ("single", {}, "suggest: expected a target"),
    ],
)
def test_a_wish_that_cannot_be_is_refused(design: Any, wanted: dict[str, Any], message: str) -> None:
    with pytest.raises(ab.AutobalanceError, match=message):
        ab.generate(design, segments=16, suggest=wanted)


def test_a_wish_beyond_every_size_says_how_near_each_comes() -> None:
    found = ab.generate({**SINGLE, "segments": 16}, suggest={"inertia_kg_mm2": 200.0}).report["suggestions"]
    assert found["found"] == []
    assert all(each["reason"] for each in found["refused"])


def test_a_wish_without_a_number_is_a_wrong_command_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["generate", "single", "--suggest", "balance_factor=much"]) == 2
    assert "balance_factor=NUMBER" in capsys.readouterr().err


def test_counterweights_are_as_small_as_balances_the_bob_weight() -> None:
    """Moments about the last crankpin, of the crank as meshed and of the weights on its pins."""
    design, most_g = with_settings(PRESETS["v8-crossplane"], {"stroke_mm": 80.0}), 2100.0
    radius_mm, left = radius_for_bob_weights_mm(design, most_g), []
    for radius in (radius_mm, round(radius_mm - 0.1, 1)):
        drawn = with_settings(design, {"counterweight.radius_mm": radius})
        solid, throws = crank_solid(drawn, 128), crank_anatomy(drawn).throws
        crank = solid.moved(crank_anatomy(drawn).file_to_rotor).moments(drawn.density_kg_m3 * 1e-6)
        both = sum((Moments.point(most_g, each.crankpin.centre_mm) for each in throws), crank)
        end_mm = throws[-1].crankpin.centre_mm[2]
        about_the_end = both.second_g_mm2[:2, 2] - end_mm * both.first_g_mm[:2]
        one_g = 40.0 * (end_mm - throws[0].crankpin.centre_mm[2])
        left.append(float(about_the_end @ throws[0].direction) / one_g)
    heavy_g, light_g = left
    assert light_g < 0.0 < heavy_g < 20.0  # a step of 0.1 mm


def test_throws_that_cancel_each_other_need_no_bob_weight() -> None:
    assert largest_bob_weight_g(PRESETS["inline-4"]) is None
    with pytest.raises(JobError, match="cancel each other out"):
        radius_for_bob_weights_mm(PRESETS["inline-4"], 700.0)
