"""The command ``study``: many cranks to one plan."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from autobalance.studies.study.verb import study
from tests.coarse import bundled_corners
from tests.jobs import main, write_stl

pytestmark = pytest.mark.usefixtures("cranks_read_once")

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
density_pm_kg_m3 = 3.0
crankpin_in_file = false
[engine.rotating_g]
big_end = { g = 95.04, pm = 0.3 }
bearing = 39.00
[engine.reciprocating_g]
small_end = { g = 34.00, pm = 0.4, distribution = "rectangular" }
rest = 227.50
[engine.crankpin_g]
crankpin = 114.65
[[engine.attached]]
name = "flywheel"
mass_g = 1200.0
unbalance_g_mm = [1.0, 2.0]
z_mm = 80.0
pm_g_mm = 3.0
[balance]
factor = 0.28
grade = 6.3
speed_rpm = 15200
[correction]
method = "shoulder"
faces = "auto"
depth_tolerance_mm = 0.02
"""
CERTAIN = JOB.replace("pm = 0.3", "pm = 0.0").replace("pm = 0.4", "pm = 0").replace("pm_g_mm = 3.0", "")
CERTAIN = CERTAIN.replace("density_pm_kg_m3 = 3.0", "").replace("depth_tolerance_mm = 0.02", "")
ORIGINAL = JOB.replace("factor = 0.28", 'factor = "original"') + (
    "[original.rotating_g]\nbig_end = { g = 134.04, pm = 0.2 }\n"
    "[original.reciprocating_g]\nall = { g = 242.7, pm = 0.5 }\n[original.crankpin_g]\ncrankpin = 114.65\n"
)


def written(folder: Path, text: str, name: str = "job.toml") -> str:
    (folder / name).write_text(text, "utf-8")
    write_stl(folder / "crank.stl", bundled_corners("straight", 96))
    return str(folder / name)


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return study(written(tmp_path_factory.mktemp("study"), JOB), samples=20_000, exact=3, workers=1).report


def budget(text: str, folder: Path) -> dict[str, Any]:
    """Return what ``balance`` says of the same."""
    assert main(["balance", written(folder, text), "--no-report", "-o", str(folder / "out")]) == 0
    found: dict[str, Any] = json.loads((folder / "out" / "report.json").read_text("utf-8"))
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", [JOB.replace("rectangular", "normal"), ORIGINAL.replace("rectangular", "normal")]
)
def test_the_spread_is_that_of_the_error_budget(tmp_path: Path, text: str) -> None:
    text = text.replace(
        "pm_g_mm = 3.0", ""
    )  # with "original", the budget moves the factor by attached parts too
    shares = budget(text, tmp_path)["residual"]["uncertainty_shares_g_mm"]
    expected = math.hypot(*(shares[cause] for cause in ("density", "weights", "attached", "depth")))
    found = study(str(tmp_path / "job.toml"), samples=8_000, exact=0).report
    assert found["spread"]["linear_g_mm"] == pytest.approx(expected, rel=0.02)
    assert found["spread"]["sampled_g_mm"] == pytest.approx(expected, rel=0.02)


@pytest.mark.slow
def test_shares_of_causes_sum_to_one(report: dict[str, Any]) -> None:
    causes = {cause["name"]: cause for cause in report["contributions"]}
    assert set(causes) == {
        "engine.rotating_g.big_end",
        "engine.reciprocating_g.small_end",
        "crankshaft.density_kg_m3",
        "engine.attached.flywheel",
        "correction.depth",
    }
    assert sum(cause["share"] for cause in causes.values()) == pytest.approx(1.0)
    assert [cause["share"] for cause in report["contributions"]] == sorted(
        (cause["share"] for cause in causes.values()), reverse=True
    )
    assert causes["engine.attached.flywheel"]["effect_g_mm"] is None
    pin = causes["engine.rotating_g.big_end"]["share"] / causes["engine.reciprocating_g.small_end"]["share"]
    assert pin == pytest.approx((0.3 / 1.959964) ** 2 / (0.28 * 0.4 / math.sqrt(3.0)) ** 2, rel=1e-6)


def test_the_linear_model_is_checked_by_cranks_that_are_cut(report: dict[str, Any]) -> None:
    check = report["linear_model"]
    assert check["checked"] == 3
    assert check["greatest_error_g_mm"] < 0.01 * report["spread"]["linear_g_mm"]
    assert check["share_of_permissible"] == pytest.approx(
        check["greatest_error_g_mm"] / report["tolerance"]["permissible_g_mm"]
    )


@pytest.mark.slow
def test_the_linear_model_follows_holes_journals_and_original_parts(tmp_path: Path) -> None:
    text = ORIGINAL.replace('"shoulder"\nfaces = "auto"', '"drill"') + (
        "[study]\nposition_pm_mm = 0.05\nwander_pm_deg = 0.3\njournal_pm_mm = 0.01\nmeasurement = true\n"
        'sampling = "latin_hypercube"\n[correction.drill]\nzone = "anywhere"\ndiameters_mm = [8.0]\n'
    )
    found = study(written(tmp_path, text), samples=500, exact=3, workers=1).report
    names = {cause["name"] for cause in found["contributions"]}
    assert {
        "study.position",
        "study.wander",
        "study.journal",
        "study.facets",
        "original.reciprocating_g.all",
    } <= names
    assert found["linear_model"]["greatest_error_g_mm"] < 0.02 * found["spread"]["linear_g_mm"]


@pytest.mark.slow
def test_a_crank_of_the_series_is_the_same_whatever_their_number(tmp_path: Path) -> None:
    job = written(tmp_path, JOB)
    many, few = (
        list(csv.reader(study(job, samples=n, exact=0).series.decode().splitlines())) for n in (60, 9)
    )
    assert many[:10] == few
    assert few[0][:3] == ["sample", "engine.rotating_g.big_end", "engine.reciprocating_g.small_end"]
    assert {"engine.attached.flywheel.x", "correction.depth[cut 1]", "unbalance_x_g_mm", "within"} <= set(
        few[0]
    )
    heavy = np.array([float(row[1]) for row in many[1:]])
    assert heavy.mean() == pytest.approx(95.04, abs=0.1)


@pytest.mark.slow
def test_exit_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    job = written(tmp_path, JOB)
    quick = ["--samples", "300", "--exact", "0"]
    series = tmp_path / "s.csv"
    assert main(["study", job, *quick, "--target", "0.999999", "--json", "-", "--series", str(series)]) == 4
    found = json.loads(capsys.readouterr().out)
    assert found["advice"]["reached"] is False
    assert found["within"] == sum(row.endswith(",1") for row in series.read_text().splitlines())
    assert found["reason"]
    assert main(["study", job, *quick, "--target", "0.01"]) == 0
    assert "WITHIN TOLERANCE: " in capsys.readouterr().out
    assert main(["study", written(tmp_path, CERTAIN, "certain.toml")]) == 3
    said = capsys.readouterr().err
    assert "density_pm_kg_m3" in said
    assert "depth_tolerance_mm" in said
    assert main(["study", written(tmp_path, JOB + "[study]\nposition_mm = 1.0\n", "typo.toml")]) == 3
    assert "study.position_mm is an unknown key" in capsys.readouterr().err


@pytest.mark.slow
def test_a_report_is_studied_as_it_stands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    budget(JOB, tmp_path)
    path = tmp_path / "out" / "report.json"
    of_report, of_job = (study(str(p), samples=200, exact=0).report for p in (path, tmp_path / "job.toml"))
    assert len(of_report["nominal"]["report_sha256"]) == 64
    assert of_report["percentiles"] == of_job["percentiles"]
    other = path.read_text("utf-8").replace('"depth_mm": ', '"depth_mm": 1')
    (tmp_path / "out" / "other.json").write_text(other, "utf-8")
    assert main(["study", str(tmp_path / "out" / "other.json")]) == 3
    assert "are not those that its job gives" in capsys.readouterr().err


def test_key_figures_follow_each_cause(report: dict[str, Any]) -> None:
    figures = {figure["figure"]: figure for figure in report["sensitivity"]}
    effects = {cause["name"]: cause["effect_g_mm"] for cause in report["contributions"]}
    for cause in figures["magnitude_g_mm"]["causes"]:
        assert [cause["values"][0], cause["values"][-1]] == pytest.approx(effects[cause["name"]])
        assert cause["values"][len(cause["values"]) // 2] == pytest.approx(
            report["nominal"]["magnitude_g_mm"]
        )
    factors = {cause["name"]: cause["values"] for cause in figures["balance_factor"]["causes"]}
    assert (np.diff(factors["engine.rotating_g.big_end"]) < 0.0).all()
    assert (np.diff(factors["crankshaft.density_kg_m3"]) > 0.0).all()
    shares = report["sobol"]["shares"]
    assert {each["name"] for each in shares} == set(effects)
    assert all(each["first"] <= each["total"] + 0.03 for each in shares)
    assert sum(each["first"] for each in shares) < 1.03


@pytest.mark.slow
def test_the_response_of_the_engine_is_a_key_figure(tmp_path: Path, rough_plots: None) -> None:
    cycle = "[cycle]\nbore_mm = 76.8\ncompression_ratio = 13.0\nheat_J = 900.0\n"
    text = JOB.replace("[engine.rotating_g]", "[engine]\nrod_length_mm = 104.0\n[engine.rotating_g]") + cycle
    text = text.replace("density_pm_kg_m3 = 3.0", "density_pm_kg_m3 = 50.0").replace("15200", "10000")
    found = study(written(tmp_path, text), samples=50, exact=0)
    figures = {figure["figure"]: figure for figure in found.report["sensitivity"]}
    response = {cause["name"]: cause["values"] for cause in figures["acceleration_rad_s2"]["causes"]}
    light, planned, heavy = response["crankshaft.density_kg_m3"]
    assert light > planned > heavy > 0.0
    assert light / heavy == pytest.approx(1.0 + 2.0 * 50.0 / 7850.0, rel=0.5e-2)
    loads = {cause["name"]: cause["values"] for cause in figures["greatest_main_load_N"]["causes"]}
    assert np.ptp(loads["engine.reciprocating_g.small_end"]) > 0.0
    assert {"study-tornado-acceleration-rad-s2", "study-curves-magnitude-g-mm"} <= set(found.plots())
