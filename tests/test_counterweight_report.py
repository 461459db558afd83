"""m_cw, r′ and m_cw·r′ of the source in a balancing run's report."""

import json
from pathlib import Path

import pytest

import autobalance as ab
from tests import jobs


def test_the_product_goes_from_the_sources_to_the_wanted_one(tmp_path: Path) -> None:
    job = jobs.BUNDLED / "straight" / "factor-0.28.toml"
    assert jobs.run("balance", job, "-o", tmp_path / "out", "--no-report") == 0
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    found = report["counterweight"]
    product = found["product_g_mm"]
    assert found["mass_g"] == pytest.approx(2020.40, abs=0.07)
    assert found["radius_mm"] == pytest.approx(6.16, abs=0.001)
    assert product["initial"] == pytest.approx(found["mass_g"] * found["radius_mm"], rel=1e-12)
    bob_g = sum(weight["mass_g"] for weight in report["engine"]["bob_weights"])
    assert product["target"] == pytest.approx(bob_g * 26.9, abs=1e-2)
    assert product["target"] - product["final"] == pytest.approx(
        report["residual"]["unbalance_g_mm"][0], abs=1e-6
    )


def test_no_product_is_given_where_it_would_be_negative(tmp_path: Path) -> None:
    """A sector too light for its own crankpin's side: the webs' centre of mass lies on that side."""
    sizes = {"counterweight.radius_mm": 34.0, "counterweight.fan_angle_deg": 60.0}
    crank = ab.generate("single", file="crank.stl", settings=sizes, segments=48)
    (tmp_path / "crank.stl").write_bytes(crank.data)
    report = ab.inspect(tmp_path / "crank.stl", unit="mm").report
    assert [web["counterweight"] for web in report["crank"]["webs"]] == [True, True]
    assert report["counterweights"] == []
    light = ab.inspect(tmp_path / "crank.stl", unit="mm").text()
    assert "m_cw" not in light
