"""Holes at given places, from the job to the verified report; what 0.1 mm of each drill takes off."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from tests import jobs

CORRECTION = """
[correction]
method = "drill"
[correction.drill]
diameters_mm = [8.0]
max_holes = 12
min_wall_mm = 1.5
positions = """


def test_a_job_with_positions_is_balanced_and_verified(tmp_path: Path) -> None:
    job = jobs.bundled_job(tmp_path, grade="40", factor="0.45")
    places = [[angle, z] for z in (-19.0, 19.0) for angle in range(130, 240, 10)]
    job.write_text(job.read_text().partition("[correction]")[0] + CORRECTION + repr(places), encoding="utf-8")
    with jobs.without_advice():
        report = jobs.balanced(job, tmp_path / "out")
    assert report["outcome"] == "within_tolerance"
    holes = report["corrections"]
    assert len({hole["depth_mm"] for hole in holes}) == 1
    for hole in holes:
        assert any(
            abs(hole["angle_deg"] - angle) < 0.01 and abs(hole["z_mm"] - z) < 0.01 for angle, z in places
        )
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 0
    report["job"]["correction"]["drill"]["positions"] = [[90.0, -19.0]]
    (tmp_path / "out" / "report.json").write_text(json.dumps(report), encoding="utf-8")
    assert jobs.run("verify", tmp_path / "out" / "report.json") == 3


def test_chart_of_what_each_drill_takes_off(capsys: pytest.CaptureFixture[str]) -> None:
    assert jobs.run("calc", "drill_chart", "radius_mm=58", "series=inch", "--json", "-") == 0
    rows = json.loads(capsys.readouterr().out)["result"]
    half = next(row for row in rows if row["drill"] == "1/2 in")
    assert half["mass_g"] == pytest.approx(7.85e-3 * math.pi / 4.0 * 12.7**2 * 0.1)
    assert half["unbalance_g_mm"] == pytest.approx(58.0 * half["mass_g"])
    assert jobs.run("calc", "drill_chart", "radius_mm=58", "series=furlong") == 2
    assert "must be one of mm, inch, letter, number" in capsys.readouterr().err
