"""A scanned crank goes on to a balancing machine: read, cut again on its fitted faces, verified."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import autobalance as ab
from autobalance.solid.csg.solid import Solid
from autobalance.solid.formats.write import Written
from tests import jobs
from tests.scans import scan

pytestmark = pytest.mark.usefixtures("cranks_read_once")

JOB = """
[crankshaft]
file = "scan.stl"
unit = "mm"
density_kg_m3 = 7850.0
{readings}
[engine.rotating_g]
big_end = 150.0
[engine.reciprocating_g]
piston = 250.0
[balance]
factor = 0.6
grade = 100
speed_rpm = 8000
[correction]
method = "shoulder"
"""
READING = """
zero_deg = 0.0
rotation = "ccw"
umar_g_mm = 5.0
urr_percent = 90.0
{planes}
"""
PLANE = """
[[plane]]
at = "{name}"
g_mm = {amount}
angle_deg = {angle}
"""


@pytest.mark.parametrize("calibrate", ["none", "density"])
def test_a_scan_is_cut_again_by_what_the_machine_read_and_verified(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], calibrate: str
) -> None:
    there = scan("single", 0.02, edge_mm=2.8, seed=1)
    (tmp_path / "scan.stl").write_bytes(Written.of(there.mesh, "stl", 1.0).data)
    weighed = 1.003 * Solid.from_mesh(there.mesh).volume_mm3 * 7.85e-3
    readings = "" if calibrate == "none" else f'weighed_g = {weighed}\ncalibrate = "density"'
    (tmp_path / "job.toml").write_text(JOB.format(readings=readings), encoding="utf-8")
    with jobs.without_advice():
        first = ab.balance(tmp_path / "job.toml")
    first.write(tmp_path / "out", only=("json",))
    heavy = np.array(first.report["corrections"][0]["unbalance_change_g_mm"])
    angle = float(np.degrees(np.arctan2(-heavy[1], -heavy[0])) % 360.0)
    planes = "".join(PLANE.format(name=name, amount=250.0, angle=angle) for name in "AB")
    (tmp_path / "reading.toml").write_text(READING.format(planes=planes), encoding="utf-8")
    report = tmp_path / "out" / "report.json"
    arguments = ("recut", report, tmp_path / "reading.toml", "--only", "json")
    with jobs.without_advice():
        assert jobs.run(*arguments) in (0, 4), capsys.readouterr().err
    stage = tmp_path / "out" / "stage-2" / "report.json"
    values = json.loads(stage.read_text())
    assert {cut["kind"] for cut in values["corrections"]} == {"shoulder"}
    assert values["residual"]["magnitude_g_mm"] < 0.3 * values["initial"]["magnitude_g_mm"]
    assert all(face["flatness_mm"] > 0.0 for face in values["faces"])
    crank, before = values["crank"], first.report["crank"]
    for key in ("roughness_mm", "axis_uncertainty"):
        assert crank[key] == before[key]
    assert crank["main_journals"][0]["diameter_pm_mm"] == before["main_journals"][0]["diameter_pm_mm"]
    assert ab.verify(stage).holds
