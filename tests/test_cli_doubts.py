"""A verdict that hangs on which cylinder is the main journal: both readings are tried and told."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalance as ab
from autobalance.solid.formats.write import encode
from tests import jobs
from tests.stepped import Step, pin, stepped

SEATS = [Step(35, 19), Step(54, 12), pin(30, 20, 0), Step(54, 12), Step(35, 19)]
"""Shoulders at the webs and seats behind them, as a public crank has: planes at ±46.5 mm, or at ±31 mm."""
SPEED_RPM = 900.0

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0

[engine.rotating_g]
rod = 10.0

[engine.reciprocating_g]
piston = 10.0

[[engine.attached]]
name = "against the crank's own"
mass_g = 1
unbalance_g_mm = [{x}, {y}]
z_mm = 0.0

[[engine.attached]]
name = "one end"
mass_g = 1
unbalance_g_mm = [0.0, {couple}]
z_mm = 30.0

[[engine.attached]]
name = "other end"
mass_g = 1
unbalance_g_mm = [0.0, -{couple}]
z_mm = -30.0

[balance]
factor = 0.0
grade = 6.3
speed_rpm = {speed}
{more}

[correction]
method = "drill"
[correction.drill]
diameters_mm = [6.0]
zone = "anywhere"
"""


def written_job(folder: Path, share: float, more: str = "") -> Path:
    """Write a crank and a job whose couple is a share of what planes at ±31 mm permit."""
    solid, _ = stepped(SEATS, segments=192)
    (folder / "crank.stl").write_bytes(encode(solid.mesh, "stl", 1.0))
    found = ab.inspect(folder / "crank.stl", unit="mm", density_kg_m3=7850.0).report
    x, y = (-each for each in found["initial"]["unbalance_g_mm"])
    x -= 10.0 * found["crank"]["throws"][0]["crank_radius_mm"]
    permissible = found["crank"]["mass_g"] * 6.3 / (SPEED_RPM * math.pi / 30.0)
    couple = share * 0.5 * permissible * 62.0 / 60.0
    text = JOB.format(x=x, y=y, couple=couple, speed=SPEED_RPM, more=more)
    (folder / "job.toml").write_text(text, encoding="utf-8")
    return folder / "job.toml"


def test_a_verdict_that_another_reading_changes_is_not_proven(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = written_job(tmp_path, 1.2)
    report = jobs.computed(job, tmp_path / "out")
    assert report["outcome"] == "already_within_tolerance"
    assert report["proven"] is False
    doubts = report["crank"]["doubts"]
    assert [each["number"] for each in doubts] == [1, 2]
    for each, side in zip(doubts, (-1.0, 1.0), strict=True):
        assert each["about"] == "main_journal"
        assert_place(each["chosen"], side * 46.5, 35.0, 19.0)
        assert_place(each["other"], side * 31.0, 54.0, 12.0)
    plane = report["tolerance"]["planes"][0]["permissible_g_mm"]
    both = "if the front main journal is ⌀54 at -31 mm and the rear main journal is ⌀54 at 31 mm: "
    assert f"{both}plane A {1.2 * plane:.2f} of {plane:.2f} g·mm" in report["reason"]
    assert "-46.5" not in report["reason"]
    shown = capsys.readouterr().out
    assert "not proven" in shown
    assert both in " ".join(shown.split())
    assert jobs.run("balance", job, "-o", tmp_path / "strict", "--no-report", "--strict") == 4
    found = ab.verify(tmp_path / "out" / "report.json")
    assert found.exit_code == 0
    assert both in found.text()
    assert "if the rear main journal is ⌀2.1260 at 1.2205 in: plane A " in found.text("inch")
    assert "g·mm" not in found.text("inch").splitlines()[1]
    rest = [each["key"] for each in found.report["not_checked"]]
    assert not any(key == "reason" or key.startswith(("crank", "tolerance")) for key in rest)


def assert_place(place: dict[str, Any], z: float, diameter: float, width: float) -> None:
    found = [place[key] for key in ("z_mm", "diameter_mm", "width_mm")]
    assert found == pytest.approx([z, diameter, width], abs=1e-3)


def test_the_line_to_paste_takes_the_other_reading(tmp_path: Path) -> None:
    job = written_job(tmp_path, 1.2)
    quickly = job.read_text(encoding="utf-8").replace("[correction]", '[correction]\nprefer = "least_metal"')
    job.write_text(quickly, encoding="utf-8")
    first = jobs.computed(job, tmp_path / "first")
    (line,) = {each["set"] for each in first["crank"]["doubts"]}
    assert any(line in warning for warning in first["warnings"])
    with jobs.without_advice():
        code = jobs.run("balance", job, "-o", tmp_path / "out", "--no-report", "--set", line)
    assert code in (0, 4)
    report = jobs.report_of(tmp_path / "out")
    assert report["crank"]["doubts"] == []
    mains = report["crank"]["main_journals"]
    found = [(each["centre_mm"][2], each["diameter_mm"], each["width_mm"]) for each in mains]
    assert np.array(found) == pytest.approx(np.array([(-31.0, 54.0, 12.0), (31.0, 54.0, 12.0)]), abs=1e-3)
    assert report["outcome"] != "already_within_tolerance"
    plane = report["tolerance"]["planes"][0]["permissible_g_mm"]
    before = [each["magnitude_g_mm"] for each in report["initial"]["planes"]]
    assert before == pytest.approx([1.2 * plane] * 2, rel=1e-3)
    assert report["crank"]["mass_g"] == pytest.approx(first["crank"]["mass_g"], rel=1e-9)
    text = job.read_text(encoding="utf-8")
    key, value = line.split(" = ", 1)
    pasted = text.replace('unit = "mm"', f'unit = "mm"\n{key.removeprefix("crankshaft.")} = {value}')
    job.write_text(pasted, encoding="utf-8")
    with jobs.without_advice():
        assert jobs.run("balance", job, "-o", tmp_path / "pasted", "--no-report") in (0, 4)
    assert jobs.report_of(tmp_path / "pasted")["crank"]["main_journals"] == mains


def test_a_verdict_that_both_readings_share_is_proven(tmp_path: Path) -> None:
    report = jobs.balanced(written_job(tmp_path, 0.5), tmp_path / "out", 0, "--strict", "--no-report")
    assert len(report["crank"]["doubts"]) == 2
    assert report["proven"] is True
    assert report["reason"] is None


def test_planes_that_the_job_states_do_not_hang_on_the_journals(tmp_path: Path) -> None:
    job = written_job(tmp_path, 1.2, "tolerance_planes_mm = [-46.5, 46.5]")
    report = jobs.balanced(job, tmp_path / "out", 0, "--strict", "--no-report")
    assert report["proven"] is True
    assert "others" not in report["tolerance"]


def test_a_report_that_hides_the_other_reading_is_found_out(tmp_path: Path) -> None:
    jobs.computed(written_job(tmp_path, 1.2), tmp_path / "out")
    whole = jobs.report_of(tmp_path / "out")
    for key, value in (("proven", True), ("reason", None), ("doubts", []), ("others", None)):
        report = json.loads(json.dumps(whole))
        place = {"doubts": report["crank"], "others": report["tolerance"]}.get(key, report)
        if value is None and key == "others":
            del place[key]
        else:
            place[key] = value
        (tmp_path / "out" / "report.json").write_text(json.dumps(report), encoding="utf-8")
        with pytest.raises(ab.AutobalanceError):
            ab.verify(tmp_path / "out" / "report.json")


def test_a_stage_after_a_reading_hangs_on_the_journals_too(tmp_path: Path) -> None:
    """A reading of 0.8 of what planes at the seats permit is above tolerance in planes at the shoulders."""
    jobs.balanced(written_job(tmp_path, 1.2), tmp_path / "out")
    first = jobs.report_of(tmp_path / "out")
    text = (tmp_path / "out" / "reading.toml").read_text(encoding="utf-8")
    plane = first["tolerance"]["planes"][0]["permissible_g_mm"]
    for share, angle_deg in ((0.8, 90.0), (0.78, 270.0)):
        text = text.replace('g_mm = "FILL IN" ', f"g_mm = {share * plane}", 1)
        text = text.replace('angle_deg = "FILL IN" ', f"angle_deg = {angle_deg}", 1)
    (tmp_path / "out" / "reading.toml").write_text(text, encoding="utf-8")
    report = tmp_path / "out" / "report.json"
    arguments = ("recut", report, tmp_path / "out" / "reading.toml", "-o", tmp_path / "again")
    assert jobs.run(*arguments) == 0
    again = jobs.report_of(tmp_path / "again")
    assert again["crank"]["doubts"] == first["crank"]["doubts"]
    assert again["crank"]["cylinders"] == first["crank"]["cylinders"]
    assert again["proven"] is False
    assert "if the rear main journal is ⌀54 at 31 mm: plane A " in again["reason"]
    assert ab.verify(tmp_path / "again" / "report.json").exit_code == 0
    assert jobs.run(*arguments[:-1], tmp_path / "strict", "--strict") == 4
