"""A verdict that hangs on which bore or stub is the shaft's: the other reading is tried and told."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import autobalance as ab
from autobalance.solid.formats.write import encode
from tests import jobs
from tests.odd_kinds import OddCrank, bored_arm, lone_web

pytestmark = pytest.mark.usefixtures("cranks_read_once")

JOB = """
[crankshaft]
file = "crank.stl"
unit = "mm"
density_kg_m3 = 7850.0
crankpin_in_file = {in_file}

[engine.rotating_g]
rod = 10.0

[engine.reciprocating_g]
piston = 10.0

{pin}

[[engine.attached]]
name = "against the crank's own"
mass_g = 1
unbalance_g_mm = [{x}, {y}]
z_mm = 0.0

[balance]
factor = 0.0
grade = {grade}
speed_rpm = 3000
judge = "static"

[correction]
method = "drill"
[correction.drill]
diameters_mm = [2.0]
min_wall_mm = 1.0
max_depth_mm = 4.0
max_holes = 2
zone = "anywhere"
"""
PIN = "[engine.crankpin_g]\ncrankpin = 20.0"


def written_job(
    folder: Path, crank: OddCrank, in_file: str, grade: float, left_g_mm: float = 0.0, pin: str = ""
) -> Path:
    """Write a job whose attached part cancels the crank's unbalance but for some along its throw."""
    folder.mkdir(exist_ok=True)
    (folder / "crank.stl").write_bytes(encode(crank.solid.mesh, "stl", 1.0))
    values = {"in_file": in_file, "pin": pin, "grade": grade}
    (folder / "job.toml").write_text(JOB.format(x=0.0, y=0.0, **values), encoding="utf-8")
    initial = ab.balance(ab.read_job(folder / "job.toml")).report["initial"]
    x, y = (-each for each in initial["unbalance_g_mm"])
    (folder / "job.toml").write_text(JOB.format(x=x + left_g_mm, y=y, **values), encoding="utf-8")
    return folder / "job.toml"


def pasted(job: Path, folder: Path, line: str) -> dict[str, Any]:
    """Return the report of a job with the line of a doubt, where nothing is cut."""
    with jobs.without_advice():
        assert jobs.run("balance", job, "-o", folder, "--no-report", "--set", line) in (0, 4)
    return jobs.report_of(folder)


@pytest.fixture
def ambiguous() -> OddCrank:
    """One web whose bores nothing tells apart: the wider one is the crankpin's by the counterweight."""
    return lone_web(pin=11.0, shaft=8.0)


def test_a_verdict_about_another_axis_is_not_proven(
    tmp_path: Path, ambiguous: OddCrank, capsys: pytest.CaptureFixture[str]
) -> None:
    job = written_job(tmp_path / "in", ambiguous, "false", 6.3, pin=PIN)
    report = jobs.computed(job, tmp_path / "out")
    assert report["outcome"] == "already_within_tolerance"
    assert report["proven"] is False
    (doubt,) = report["crank"]["doubts"]
    assert doubt["about"] == "axis"
    there = pasted(job, tmp_path / "pasted", doubt["set"])
    found, permitted = there["initial"]["magnitude_g_mm"], there["tolerance"]["permissible_g_mm"]
    assert found > permitted
    text = f"if the axis is ⌀22 at 0 mm: the resultant {found:.2f} of {permitted:.2f} g·mm"
    assert report["reason"] == text
    assert "not proven: the verdict depends on which cylinder is the shaft" in capsys.readouterr().out
    assert jobs.run("balance", job, "-o", tmp_path / "strict", "--no-report", "--strict") == 4
    assert ab.verify(tmp_path / "out" / "report.json").exit_code == 0


def test_a_verdict_about_both_axes_is_proven(tmp_path: Path, ambiguous: OddCrank) -> None:
    """At a grade so wide that the web is within tolerance about either bore."""
    job = written_job(tmp_path / "in", ambiguous, "false", 16000.0, pin=PIN)
    report = jobs.balanced(job, tmp_path / "out", 0, "--strict", "--no-report")
    (doubt,) = report["crank"]["doubts"]
    assert pasted(job, tmp_path / "pasted", doubt["set"])["outcome"] == "already_within_tolerance"
    assert report["proven"] is True
    assert report["reason"] is None
    assert ab.verify(tmp_path / "out" / "report.json").exit_code == 0


def test_a_crank_above_tolerance_about_both_axes_has_one_verdict(tmp_path: Path, ambiguous: OddCrank) -> None:
    job = written_job(tmp_path / "in", ambiguous, "false", 6.3, left_g_mm=3e5, pin=PIN)
    report = jobs.computed(job, tmp_path / "out", 4)
    assert "if the axis is" not in report["reason"]


def test_a_stub_that_may_be_the_shaft_leaves_the_crankpins_weight_open(tmp_path: Path) -> None:
    """The bore is the crankpin's then, and the job does not state the weight of what is pressed in."""
    crank = bored_arm(beyond_pin=25.0)
    job = written_job(tmp_path / "in", crank, "true", 6.3)
    report = jobs.computed(job, tmp_path / "out")
    assert report["proven"] is False
    (doubt,) = report["crank"]["doubts"]
    assert doubt["set"] == "crankshaft.crankpin_in_file = false"
    assert report["reason"].startswith("if the axis is ⌀7 at ")
    assert "without its crankpin, whose weight is not in the job" in report["reason"]
    text = job.read_text(encoding="utf-8").replace("crankpin_in_file = true", "crankpin_in_file = false")
    weighed = text + "\n[engine.crankpin_g]\ncrankpin = 0.0\n"
    (tmp_path / "in" / "weighed.toml").write_text(weighed, encoding="utf-8")
    weighed_too = ("balance", tmp_path / "in" / "weighed.toml", "-o", tmp_path / "weighed", "--no-report")
    with jobs.without_advice():
        assert jobs.run(*weighed_too) in (0, 4)
    there = jobs.report_of(tmp_path / "weighed")
    found, permitted = there["initial"]["magnitude_g_mm"], there["tolerance"]["permissible_g_mm"]
    assert f": the resultant {found:.2f} of {permitted:.2f} g·mm without" in report["reason"]
    assert ab.verify(tmp_path / "out" / "report.json").exit_code == 0
    (back,) = there["crank"]["doubts"]
    assert back["set"] == "crankshaft.crankpin_in_file = true"
    assert math.isclose(there["crank"]["mass_g"], report["crank"]["mass_g"], rel_tol=1e-9)


def test_the_crankpin_with_which_the_other_reading_is_within_is_told(tmp_path: Path) -> None:
    """About the stub the arm's own metal pulls away from the bore: a pin of some weight balances it."""
    crank = bored_arm(beyond_pin=25.0)
    job = written_job(tmp_path / "in", crank, "true", 6.3, left_g_mm=-2000.0)
    report = jobs.computed(job, tmp_path / "out", 4)
    assert "; within with one of about " in report["reason"]
